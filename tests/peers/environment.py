"""A virtual environment of its own for what the peers need, made once for each requirements.txt."""

import os
import pathlib
import subprocess
import sys

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
FOLDER = REPOSITORY / 'target/peers'
REQUIREMENTS = pathlib.Path(__file__).with_name('requirements.txt')


def enter():
    """Runs the calling script again with the environment's Python, unless that is what runs it."""
    if pathlib.Path(sys.prefix) == FOLDER:
        return
    made = FOLDER / 'made_for'
    if not made.exists() or made.read_text() != REQUIREMENTS.read_text():
        make()
        made.write_text(REQUIREMENTS.read_text())
    sys.exit(subprocess.run([FOLDER / 'bin/python', *sys.argv]).returncode)


def scans():
    """Paths of the real scans; where there are none, says so and ends."""
    folder = pathlib.Path(os.environ.get('DEFORMABLE_COBOT_REAL', REPOSITORY.parent / 'shared/real')) / 'scans'
    found = sorted(folder.glob('*.ply'))
    if not found:
        print(f'skipped: no scans in {folder}; DEFORMABLE_COBOT_REAL names another folder')
        sys.exit(0)
    return found


def example(package, name):
    """The command that runs an example of one of the crates."""
    return ['cargo', 'run', '--quiet', '--release', '--manifest-path', str(REPOSITORY / 'Cargo.toml'),
            '--package', package, '--example', name, '--']


def make():
    print(f'making {FOLDER} (once)', file=sys.stderr)
    venv = subprocess.run(['/usr/bin/python3', '-m', 'venv', '--clear', FOLDER])
    if venv.returncode:
        sys.exit(f'{FOLDER} cannot be made; if Python says that ensurepip is missing: apt-get install python3-venv')
    subprocess.run([FOLDER / 'bin/pip', 'install', '--quiet', '--disable-pip-version-check', '-r', REQUIREMENTS],
                   check=True)

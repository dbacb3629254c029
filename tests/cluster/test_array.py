"""launch/dataset.sbatch on a real Slurm: shards made by an array job, merged, are what one run makes."""

import filecmp
import os
import shutil
import subprocess

import pytest

from slurm import Slurm

ARGUMENTS = ('--object', 'tiny-ball', '--object', 'small-cup', '--count', '40', '--seed', '5')
TASKS = 4
ARRAY_S = 90


@pytest.fixture
def slurm(tmp_path):
    """A cluster of this machine; the test is skipped where Slurm is not installed, or the user is not root."""
    programs = ('munged', 'slurmctld', 'slurmd', 'sbatch', 'sinfo')
    missing = [name for name in programs if not shutil.which(name, path=f'{os.environ["PATH"]}:/usr/sbin')]
    if missing:
        pytest.skip(f'no Slurm: {", ".join(missing)} not found; make test-cluster installs it')
    if os.geteuid() != 0:
        pytest.skip('the daemons of Slurm need root')
    slurm = Slurm(tmp_path, cpus=4)
    try:
        slurm.start()
        yield slurm
    finally:
        slurm.stop()
        print(slurm.printed())  # seen where the test fails


def files(folder):
    """Paths below a folder, relative to it."""
    return sorted(path.relative_to(folder) for path in folder.rglob('*') if path.is_file())


@pytest.mark.built
@pytest.mark.timeout(200)
def test_shards_of_an_array_job_make_one_run(slurm, checkout, executable, tmp_path):
    generate = executable('generate_dataset')
    script, whole, merged = checkout / 'launch' / 'dataset.sbatch', tmp_path / 'whole', tmp_path / 'merged'
    variables = {'DATASET_OUT': str(merged), 'DATASET_PROGRAM': str(generate)}
    code, array = slurm.submit('--parsable', f'--array=1-{TASKS}', '--cpus-per-task=1', '--mem=0', script, *ARGUMENTS,
                               **variables)
    assert code == 0, array
    code, printed = slurm.submit('--wait', f'--dependency=afterok:{array}', '--kill-on-invalid-dep=yes',
                                 '--output=merge.log', '--wrap', f'{generate} merge --out {merged} {merged}.part*',
                                 timeout_s=ARRAY_S)
    assert code == 0, printed + slurm.printed()

    subprocess.run([generate, '--out', whole, *ARGUMENTS], check=True, timeout=60)
    assert files(merged) == files(whole)
    _, different, unreadable = filecmp.cmpfiles(whole, merged, files(whole), shallow=False)
    assert not different and not unreadable
    # Each task made its part.
    for number in range(1, TASKS + 1):
        part = tmp_path / f'merged.part{number}'
        assert 0 < len(list(part.rglob('*.ply'))) < len(list(whole.rglob('*.ply')))


@pytest.mark.built
@pytest.mark.timeout(100)
def test_a_task_says_what_it_lacks(slurm, checkout, tmp_path):
    script = checkout / 'launch' / 'dataset.sbatch'
    code, printed = slurm.submit('--wait', '--array=1-1', '--mem=0', '--output=lacking.log', script, *ARGUMENTS,
                                 timeout_s=60)
    assert code == 2, printed
    assert 'DATASET_OUT is not set' in (tmp_path / 'lacking.log').read_text()

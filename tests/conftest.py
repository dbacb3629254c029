"""Fixtures of the whole-system tests. Each test runs in a process of its own (pytest-forked)."""

import os
import pathlib
import shutil
import subprocess
import tempfile
import time

import pytest

from graph import Core, Graph
from processes import MARK, kill_marked, wait_until

LINES_SHOWN = 60
# The folder that the tests of a session share; each runs in a process of its own.
SHARED = 'DEFORMABLE_COBOT_SHARED'


@pytest.fixture(scope='session')
def checkout():
    """The top folder of this project."""
    return pathlib.Path(__file__).resolve().parent.parent


@pytest.fixture(scope='session')
def executables(checkout):
    """Names of the programs that the package offers."""
    lists = (checkout / 'ros' / 'CMakeLists.txt').read_text()
    return sorted(name for kind in ('GRAPH', 'TOOL')
                  for name in lists.split(f'set({kind}_EXECUTABLES')[1].split(')')[0].split())


@pytest.fixture(scope='session')
def real(checkout):
    """Folder with real scans and captures; the test is skipped where there is none."""
    folder = pathlib.Path(os.environ.get('DEFORMABLE_COBOT_REAL', checkout.parent / 'shared' / 'real'))
    if not folder.is_dir():
        pytest.skip(f'no real data: {folder} is missing; DEFORMABLE_COBOT_REAL may name another folder')
    return folder


@pytest.fixture(scope='session')
def shared_folder():
    """A folder for what is made once and used by several tests."""
    return pathlib.Path(os.environ[SHARED])


@pytest.fixture
def core(tmp_path):
    """A roscore on a free port; all that runs on it is ended after the test, which fails where the simulated robot was moved
    against the contract of motion."""
    core = Core(tmp_path)
    try:
        core.start()
        yield core
    finally:
        core.stop()
    violations = core.violations()
    assert not violations, f'against the contract of motion: {violations}'


@pytest.fixture
def launch(core):
    """Starts one of the package's launch files: launch('sim.launch', name=value) -> Graph."""
    return lambda file, **arguments: Graph(core, file, **arguments)


@pytest.fixture
def sim(launch):
    """The simulated robot with a can in its hand, ready to scan."""
    graph = launch('sim.launch')
    graph.wait_for_service('scan_object', timeout_s=60)
    graph.hold('medium-can')
    return graph


@pytest.fixture
def executable(checkout):
    """Path of a program by its name."""
    return lambda name: checkout / 'target' / 'release' / name


@pytest.fixture
def start(core, executable):
    """Starts a node by itself: start('camera_mount', _parameter=value), and this process as a rospy node."""
    import rospy
    rospy.init_node('client', anonymous=True, disable_signals=True)

    def run(name, **parameters):
        program = core.run(executable(name), *(f'{key}:={value}' for key, value in parameters.items()))
        wait_until(lambda: f'/{name}' in core.nodes(), 20, f'{name} at the master')
        return program
    return run


@pytest.fixture
def shell(tmp_path):
    """Runs a bash script to its end; returns what it printed, or fails with it."""
    def run(script, timeout_s=60, **variables):
        done = subprocess.run(['bash', '-c', script], cwd=tmp_path, env={**os.environ, **variables}, text=True,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              timeout=timeout_s)
        assert done.returncode == 0, f'{script}\nended with {done.returncode}:\n{done.stdout}'
        return done.stdout
    return run


def waited_s():
    """Seconds so far in which some process of this machine waited for a processor; None where the kernel does not tell."""
    try:
        return int(pathlib.Path('/proc/pressure/cpu').read_text().split('total=')[1].split()[0]) / 1e6
    except (OSError, IndexError):
        return None


def pytest_runtest_setup(item):
    item.began = time.monotonic(), waited_s()


def busyness(began, waited_before_s):
    """How busy the machine was since then, by which a fault is told from a machine that has too much to do."""
    lasted_s, waited_after_s = time.monotonic() - began, waited_s()
    if None in (waited_before_s, waited_after_s):
        return f'load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors'
    share = (waited_after_s - waited_before_s) / max(lasted_s, 1e-3)
    return (f'{share:.0%} of the time something waited for a processor, load {os.getloadavg()[0]:.1f} on '
            f'{os.cpu_count()} processors' + (': a deadline may have passed for that alone' if share > 0.8 else ''))


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item):
    """Shows the ends of the programs' logs where a test fails, and how busy the machine was."""
    report = (yield).get_result()
    if report.failed and hasattr(item, 'began'):
        report.sections.append(('the machine', busyness(*item.began)))
    core = item.funcargs.get('core')
    if report.failed and core is not None:
        for program in core.programs:
            end = '\n'.join(program.printed().splitlines()[-LINES_SHOWN:])
            report.sections.append((' '.join(program.command), end))


def pytest_sessionstart():
    os.environ[MARK] = f'pytest-{os.getpid()}:'
    os.environ[SHARED] = tempfile.mkdtemp(prefix='deformable_cobot-')


def pytest_unconfigure():
    """Removes what the tests shared, and kills what tests that crashed have left."""
    if MARK in os.environ:
        kill_marked(os.environ[MARK])
        shutil.rmtree(os.environ[SHARED], ignore_errors=True)


@pytest.fixture
def shelf(tmp_path):
    """An empty folder for what is saved."""
    (tmp_path / 'shelf').mkdir()
    return tmp_path / 'shelf'

"""Fixtures of the tests on several hosts: `core` is a robot and three computers."""

import shutil

import pytest

from graph import Graph
from lab import ADDRESSES, ARM, GRIPPER, Lab, missing

# Shorter than the defaults, so that errors come soon.
DEADLINES_S = {'motion_deadline_s': 6.0, 'answer_deadline_s': 3.0}
NODES = {'motion_deadline_s': 'view_capture', 'answer_deadline_s': 'scan_server'}


@pytest.fixture
def make_lab(tmp_path):
    """Starts a lab with a simulated robot; this process runs on its main computer. Everything is stopped after the test, which
    fails if the robot was moved against the contract of motion."""
    why = missing()
    if why:
        pytest.skip(why)
    labs = []

    def make(**options):
        labs.append(Lab(tmp_path, **options))
        labs[0].start()
        return labs[0]
    try:
        yield make
    finally:
        for lab in labs:
            lab.stop()
    violations = [line for lab in labs for line in lab.violations()]
    assert not violations, f'against the contract of motion: {violations}'


@pytest.fixture
def core(make_lab):
    """A lab whose network works."""
    return make_lab()


@pytest.fixture
def launch_robot(checkout, tmp_path):
    """Starts the graph on all computers of a lab, from the main one, with a can in the hand."""
    def run(lab):
        config = tmp_path / 'config'
        shutil.copytree(checkout / 'config', config)
        for name, value in DEADLINES_S.items():
            with open(config / f'{NODES[name]}.yaml', 'a', encoding='utf-8') as file:
                file.write(f'{name}: {value}\n')
        lab.camera = lab.launch('sim_camera.launch')
        graph = Graph(lab, 'robot.launch', arm=ADDRESSES[ARM], gripper=ADDRESSES[GRIPPER], config=config)
        graph.wait_for_service('scan_object', timeout_s=60)
        graph.hold('medium-can')
        return graph
    return run


@pytest.fixture
def graph(core, launch_robot):
    """The graph in a lab whose network works."""
    return launch_robot(core)

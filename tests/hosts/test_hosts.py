"""The graph on a robot and three computers: started by ssh, or by hand on each."""

import os
import signal
import subprocess
import sys

import pytest
import rosgraph

from graph import Graph
from lab import ADDRESSES, ARM, GRIPPER, MAIN
from processes import wait_until

pytestmark = pytest.mark.built

# A host with a program on it; prints their process ids.
KILLED = '''
import sys, time
sys.path[:0] = sys.argv[1:]
from lab import MAIN, Namespace, Switch
switch, host = Switch(), Namespace()
switch.plug_in(MAIN, host)
import subprocess
program = subprocess.Popen(host.enter('sleep', '1000'))
print(switch.pid, host.pid, program.pid, flush=True)
time.sleep(1000)
'''


def scan_well(graph):
    response = graph.scan()
    assert (response.error, response.result.label, response.result.known) == ('', 'medium-can', True)
    return response.result


def test_one_command_starts_all_by_ssh(graph, core):
    result = scan_well(graph)
    assert core.nodes_on(ARM) == {'wrist_rotator'}
    assert {'view_capture', 'classifier', 'camera_mount'} <= core.nodes_on(MAIN)
    for host in (ARM, GRIPPER, MAIN):
        # Each hears the robot and the main computer.
        assert 'enabled: True' in core.output_on(host, 'rostopic', 'echo', '-n1', '/robot/state')
        assert result.scan_id in core.output_on(host, 'rostopic', 'echo', '-n1', '/classification')


def test_started_by_hand_on_each(core, checkout):
    """The env-loader finds this computer's own address and workspace."""
    core.run_on(ARM, 'env', '--unset=ROS_IP', '--unset=ROS_PACKAGE_PATH', '--unset=CMAKE_PREFIX_PATH', 'bash',
                checkout / 'launch' / 'env_loader.bash', 'roslaunch', 'deformable_cobot', 'arm.launch')
    core.launch('sim_camera.launch')
    graph = Graph(core, 'main.launch')
    graph.wait_for_service('rotate_wrist')
    graph.hold('medium-can')
    scan_well(graph)
    assert f'//{ADDRESSES[ARM]}:' in rosgraph.Master('/test').lookupNode('/wrist_rotator')


def test_nothing_is_left_of_a_killed_test(core, checkout):
    folders = [str(checkout / 'tests'), str(checkout / 'tests' / 'hosts')]
    child = subprocess.Popen([sys.executable, '-c', KILLED, *folders], stdout=subprocess.PIPE, text=True)
    processes = child.stdout.readline().split()
    assert all(os.path.exists(f'/proc/{process}') for process in processes)
    child.send_signal(signal.SIGKILL)
    child.wait(5)
    wait_until(lambda: not any(os.path.exists(f'/proc/{process}') for process in processes), 5, 'the end of all')

"""Who asked for a motion, at each entry point, dies or is unplugged: the arm or the fingers come to rest, stay there, and the
next request works."""

import os
import signal
import time

import pytest

from faults import Wrist, recovers
from lab import ARM, GRIPPER
from processes import wait_until

pytestmark = [pytest.mark.built, pytest.mark.timeout(240)]

# A client of the action, as somebody would write it.
ACTION_CLIENT = '''
import actionlib, rospy
from deformable_cobot.msg import ScanObjectAction, ScanObjectGoal
rospy.init_node('somebody')
client = actionlib.SimpleActionClient('scan_object', ScanObjectAction)
client.wait_for_server()
client.send_goal_and_wait(ScanObjectGoal(views=8))
'''

# What a caller runs, and on which computer: not on that of the node that it calls.
ENTRIES = {
    'rotate_wrist': (GRIPPER, ['rosservice', 'call', '/rotate_wrist', 'angle: 2.9']),
    'sweep_wrist': (GRIPPER, ['rosservice', 'call', '/sweep_wrist', '{angle: 2.9, rate: 1.0}']),
    'sweep_object': (GRIPPER, ['rosservice', 'call', '/sweep_object', 'range: 5.0']),
    'scan_object, service': (GRIPPER, ['rosservice', 'call', '/scan_object', 'views: 8']),
    'scan_object, action': (GRIPPER, ['/usr/bin/python3', '-c', ACTION_CLIENT]),
    'calibrate_camera_mount': (GRIPPER, ['rosservice', 'call', '/calibrate_camera_mount',
                                         '{views: 8, add: false, write: false}']),
    'capture_views': (GRIPPER, ['rosservice', 'call', '/capture_views', '{views: 8}']),
}
# Until the arm rests: what the network takes to tell, and the ramp.
REST_S = {'killed': 1.0, 'unplugged': 4.5}
# Whether somebody waits for a goal is seen by who listens to its result. A client that died may come back for 3 s; one that was
# unplugged has been silent for so long when it counts as gone.
ACTION_S = {'killed': 3.0, 'unplugged': 0.0}


class Fingers:
    """How far open the gripper is, as the main computer hears it."""

    def __init__(self):
        import rospy
        from baxter_core_msgs.msg import EndEffectorState
        self.position = None
        self.subscriber = rospy.Subscriber('/robot/end_effector/left_gripper/state', EndEffectorState, self._note)
        wait_until(lambda: self.position is not None, 10, 'the gripper')

    def _note(self, state):
        self.position = state.position


def end(core, host, caller, fault):
    if fault == 'killed':
        os.killpg(caller.process.pid, signal.SIGKILL)
    else:
        core.switch.set_link(host, 'down')


@pytest.mark.parametrize('fault', REST_S)
@pytest.mark.parametrize('entry', ENTRIES)
def test_nobody_waits_for_the_arm(graph, core, entry, fault):
    """
    the wrist comes to rest, at once where the caller died (an action's client: after 3 s) and within 4.5 s where it was
    unplugged, and stays; the next scan succeeds, without anybody's help
    """
    host, command = ENTRIES[entry]
    recovers(graph)
    wrist = Wrist()
    core.output('rosservice', 'call', '/rotate_wrist', 'angle: -2.9')
    caller = core.run_on(host, *command)
    wrist.moves()
    end(core, host, caller, fault)
    time.sleep(REST_S[fault] + (ACTION_S[fault] if 'action' in entry else 0))
    stopped = wrist.angle_rad
    time.sleep(2)
    assert abs(wrist.angle_rad - stopped) < 0.01, 'it goes on without its caller'
    core.switch.set_link(host, 'up')
    recovers(graph)


@pytest.mark.parametrize('fault', REST_S)
def test_who_asked_to_stop_is_gone(graph, core, fault):
    """
    the wrist stops all the same; the next scan succeeds
    """
    recovers(graph)
    wrist = Wrist()
    core.output('rosservice', 'call', '/rotate_wrist', 'angle: -2.9')
    core.run('rosservice', 'call', '/rotate_wrist', 'angle: 2.9')
    wrist.moves()
    caller = core.run_on(GRIPPER, 'rosservice', 'call', '/stop_wrist', '{}')
    before = wrist.rests(10)
    end(core, GRIPPER, caller, fault)
    time.sleep(1)
    assert abs(wrist.angle_rad - before) < 0.01 and before < 2.5
    core.switch.set_link(GRIPPER, 'up')
    recovers(graph)


@pytest.mark.parametrize('fault', REST_S)
def test_nobody_waits_for_the_fingers(graph, core, fault):
    """
    the fingers stop, or reach what they were told before anybody can know; they stay, and the next grasp works
    """
    graph.hold('')  # the gripper is calibrated at its first use, which needs an empty hand
    assert 'reached' in core.output('rosservice', 'call', '/grasp', '{command: open}')
    fingers = Fingers()
    caller = core.run_on(ARM, 'rosservice', 'call', '/grasp', '{command: close}')
    begin = fingers.position
    wait_until(lambda: fingers.position != begin, 15, 'the fingers', period_s=0.005)
    end(core, ARM, caller, fault)
    time.sleep(REST_S[fault])
    stopped = fingers.position
    time.sleep(1)
    assert abs(fingers.position - stopped) < 1.0, 'they go on without their caller'
    core.switch.set_link(ARM, 'up')
    wait_until(lambda: 'missed' in core.output('rosservice', 'call', '/grasp', '{command: close}'), 20, 'the next grasp')

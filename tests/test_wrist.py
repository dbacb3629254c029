"""The wrist rotator against the simulated Baxter: it moves as asked, and not a tick longer than it may."""

import signal
import threading
import time

import pytest
import rospy
from rosgraph import Master
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

from graph import Listener, within
from processes import wait_until

COMMANDS = '/robot/limb/left/joint_command'
W2 = 'left_w2'


class Wrist:
    """What the robot's W2 does, and the service that turns it."""

    def __init__(self):
        from deformable_cobot.srv import RotateWrist
        self.angle_rad = None
        self.commands = Listener(COMMANDS, clock=time.monotonic)
        self.states = rospy.Subscriber('/robot/joint_states', JointState, self._note)
        rospy.wait_for_service('rotate_wrist', 20)
        self.turn = rospy.ServiceProxy('rotate_wrist', RotateWrist)
        wait_until(lambda: self.angle_rad is not None, 10, 'joint states')
        wait_until(lambda: self.turn(0.0).success, 10, 'a healthy robot')
        self.commands.all()

    def _note(self, message):
        if W2 in message.name:
            self.angle_rad = message.position[message.name.index(W2)]

    def start_turn(self, angle_rad):
        """Begins a turn; returns when the wrist moves. The result is the list's later only element."""
        results = []
        begin = self.angle_rad

        def turn():
            try:
                results.append(self.turn(angle_rad))
            except rospy.ServiceException as error:
                results.append(error)

        threading.Thread(target=turn, daemon=True).start()
        wait_until(lambda: abs(self.angle_rad - begin) > 0.1, 5, 'motion', period_s=0.005)
        return results

    def rests(self):
        """Waits until the wrist is still; returns its angle."""
        def still():
            before = self.angle_rad
            time.sleep(0.15)
            return abs(self.angle_rad - before) < 1e-3
        wait_until(still, 5, 'rest')
        return self.angle_rad


@pytest.fixture
def wrist(start):
    start('sim_baxter')
    node = start('wrist_rotator')
    wrist = Wrist()
    wrist.node = node
    return wrist


def test_it_turns_and_says_when_it_came_to_rest(wrist):
    begin = time.monotonic()
    answer = wrist.turn(0.6)
    took_s = time.monotonic() - begin
    assert answer.success, answer.error
    assert abs(wrist.angle_rad - 0.6) < 0.0088 and abs(answer.angle - 0.6) < 0.0088
    assert 0 < (rospy.Time.now() - answer.at_rest).to_sec() < took_s
    assert len(wrist.commands.all()) > 50, 'about 100 commands a second'


@pytest.mark.parametrize('target, words', [(9.0, '3.059'), (float('nan'), 'finite')])
def test_impossible_targets_are_refused_by_name(wrist, target, words):
    answer = wrist.turn(target)
    assert not answer.success
    assert words in answer.error
    assert wrist.commands.all() == []


def test_an_emergency_stop_ends_the_motion(wrist):
    results = wrist.start_turn(1.5)
    stop = rospy.Publisher('/sim_baxter/press_estop', Bool, queue_size=1, latch=True)
    stop.publish(True)
    wait_until(lambda: results, 3, 'answer')
    assert not results[0].success and 'stop' in results[0].error
    assert wrist.rests() < 1.4
    wrist.commands.all()
    assert not wrist.turn(0.0).success, 'never resets or enables by itself'
    assert wrist.commands.all() == []


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_shutdown_stops_the_motion_first(wrist, number):
    results = wrist.start_turn(2.0)
    wrist.node.process.send_signal(number)
    assert wrist.node.wait(5) == 0
    wait_until(lambda: results, 3, 'answer')
    assert wrist.rests() < 1.9


def test_another_commander_is_noticed(wrist):
    Master('/intruder').registerPublisher(COMMANDS, 'baxter_core_msgs/JointCommand', 'http://127.0.0.1:1/')
    answer = within(5, 'rotate_wrist', lambda: wrist.turn(0.6))
    assert not answer.success and '/intruder' in answer.error


def test_a_stall_is_not_made_up_for(wrist):
    """After half a second without processor, no burst of the commands that were missed."""
    wrist.start_turn(2.5)
    wrist.node.process.send_signal(signal.SIGSTOP)
    time.sleep(0.5)
    wrist.commands.all()
    wrist.node.process.send_signal(signal.SIGCONT)
    resumed = time.monotonic()
    wrist.rests()
    early = [when for when, _ in wrist.commands.all() if when < resumed + 0.05]
    assert len(early) <= 10, f'{len(early)} commands within 50 ms'


def test_commands_that_nobody_would_hear_are_not_sent(start):
    """A robot that is seen but does not listen, as behind a firewall, or just after a restart of the rotator."""
    from baxter_core_msgs.msg import AssemblyState
    from deformable_cobot.srv import RotateWrist
    names = [f'left_{joint}' for joint in ('s0', 's1', 'e0', 'e1', 'w0', 'w1', 'w2')]
    states = rospy.Publisher('/robot/state', AssemblyState, queue_size=1)
    joints = rospy.Publisher('/robot/joint_states', JointState, queue_size=1)

    def speak(_):
        states.publish(AssemblyState(ready=True, enabled=True))
        message = JointState(name=names, position=[0.0] * 7, velocity=[0.0] * 7)
        message.header.stamp = rospy.Time.now()
        joints.publish(message)

    start('wrist_rotator')
    rospy.Timer(rospy.Duration(0.01), speak)
    rospy.wait_for_service('rotate_wrist', 20)
    turn = rospy.ServiceProxy('rotate_wrist', RotateWrist)
    wait_until(lambda: f'nobody listens to {COMMANDS}' in turn(0.6).error, 20, 'a refusal for want of a listener')

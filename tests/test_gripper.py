"""The gripper node against the simulated Baxter's electric gripper and ReFlex hands."""

import signal
import threading
import time

import pytest
import rospy
from std_msgs.msg import Bool, Empty, Float64

from graph import Listener, within
from processes import wait_until

CAN_M = 0.066
STATE = '/robot/end_effector/left_gripper/state'
COMMAND = '/robot/end_effector/left_gripper/command'
# What the node may take altogether, in words of its defaults: calibration, acknowledgements, motion.
DEADLINE_S = 15


class Hand:
    """The service, and what people do to the simulated hand."""

    def __init__(self, side='left'):
        from deformable_cobot.srv import Grasp
        rospy.wait_for_service('grasp', 20)
        self.proxy = rospy.ServiceProxy('grasp', Grasp)
        self.width = rospy.Publisher(f'/sim_baxter/{side}_object_width_m', Float64, queue_size=1, latch=True)

    def grasp(self, command, width=0.0, force=0.0):
        return within(DEADLINE_S, f'grasp {command}', lambda: self.proxy(command, width, force))

    def healthy(self):
        """Opens the hand as soon as it is heard; a gripper that was never used is calibrated by that."""
        wait_until(lambda: self.grasp('open').outcome == 'reached', 20, 'a hand that opens')

    def hold(self, width_m):
        self.width.publish(width_m)


def electric_state():
    from baxter_core_msgs.msg import EndEffectorState
    return rospy.wait_for_message(STATE, EndEffectorState, 5)


@pytest.fixture
def electric(start):
    simulator, node = start('sim_baxter'), start('gripper')
    hand = Hand()
    hand.simulator, hand.node = simulator, node
    return hand


def test_electric_calibrates_then_grips_what_is_there_and_misses_what_is_not(electric):
    electric.healthy()
    assert electric_state().calibrated == 1
    missed = electric.grasp('close')
    assert (missed.outcome, missed.error) == ('missed', '')
    assert missed.width == pytest.approx(0.054, abs=1e-3)
    electric.grasp('open')
    electric.hold(CAN_M)
    wait_until(lambda: electric_state().gripping == 1, 5, 'the can in the hand')
    assert electric.grasp('open').outcome == 'reached'
    gripped = electric.grasp('close', force=0.2)
    assert (gripped.outcome, gripped.error) == ('gripped', '')
    assert gripped.width == pytest.approx(CAN_M, abs=1e-3)
    state = electric_state()
    assert (state.gripping, state.force) == (1, 20.0)
    assert electric.grasp('close').outcome == 'gripped', 'it is still there'
    assert electric.grasp('width', 0.07).outcome == 'reached'
    assert electric_state().position == pytest.approx(100 * (0.07 - 0.054) / 0.041666, abs=5)
    assert electric.grasp('width', 0.058).outcome == 'gripped', 'the can is in the way'


def test_impossible_requests_are_refused_by_name(electric):
    electric.healthy()
    commands = Listener(COMMAND)
    for arguments, words in ((('shut',), "'shut' is no command"), (('width', 0.2), '0.054 to 0.0956'),
                             (('close', 0.0, 2.0), 'force is 2')):
        answer = electric.grasp(*arguments)
        assert answer.outcome == 'refused' and words in answer.error
    assert commands.all() == []


def test_a_gripper_that_must_not_be_calibrated_is_left_alone(start):
    start('sim_baxter')
    start('gripper', _electric='{calibrate: false}')
    hand = Hand()
    wait_until(lambda: 'not calibrated' in hand.grasp('close').error, 10, 'a refusal')
    assert electric_state().command == ''


def test_calibration_with_something_in_the_hand_fails_by_name(electric):
    electric.hold(CAN_M)
    wait_until(lambda: electric_state().gripping == 1, 10, 'the can in the hand')
    answer = electric.grasp('close')
    assert answer.outcome == 'failed' and 'between the fingers' in answer.error
    electric.hold(0.0)
    wait_until(lambda: electric_state().gripping == 0, 5, 'the can taken away')
    assert electric.grasp('close').outcome == 'missed', 'reset and calibrated'


def test_a_robot_that_is_not_enabled_keeps_its_gripper_still(electric):
    electric.healthy()
    enable = rospy.Publisher('/robot/set_super_enable', Bool, queue_size=1, latch=True)
    enable.publish(False)
    wait_until(lambda: 'not enabled' in electric.grasp('open').error, 10, 'a refusal')
    commands = Listener(COMMAND)
    assert electric.grasp('close').outcome == 'refused'
    stop = rospy.Publisher('/robot/set_super_stop', Empty, queue_size=1, latch=True)
    stop.publish()
    wait_until(lambda: 'stopped' in electric.grasp('close').error, 10, 'a refusal')
    assert commands.all() == [], 'never enables or moves by itself'


def test_a_silent_gripper_is_named_within_the_deadline(electric):
    electric.healthy()
    electric.simulator.process.send_signal(signal.SIGSTOP)
    try:
        begin = time.monotonic()
        answer = electric.grasp('close')
        assert answer.outcome in ('refused', 'failed') and 'old' in answer.error
        assert time.monotonic() - begin < 2
    finally:
        electric.simulator.process.send_signal(signal.SIGCONT)


def test_a_gripper_that_is_not_there_is_named(start):
    start('sim_baxter', _left_hand='none')
    start('gripper')
    hand = Hand()
    wait_until(lambda: f'no message on {STATE}' in hand.grasp('close').error, 10, 'a refusal')


def test_a_gripper_that_ignores_its_commands_is_named(start):
    """As the maker's emulator: it speaks, but acknowledges nothing."""
    from baxter_core_msgs.msg import AssemblyState, EndEffectorCommand, EndEffectorState
    state = rospy.Publisher(STATE, EndEffectorState, queue_size=1)
    robot = rospy.Publisher('/robot/state', AssemblyState, queue_size=1)
    commands = Listener(COMMAND, EndEffectorCommand)
    start('gripper')

    def speak(_):
        robot.publish(AssemblyState(enabled=True))
        state.publish(EndEffectorState(id=65538, enabled=1, calibrated=1, ready=1, position=100.0))

    rospy.Timer(rospy.Duration(0.01), speak)
    hand = Hand()
    wait_until(lambda: "did not acknowledge 'configure'" in hand.grasp('close').error, 10, 'an error')
    sent = []

    def senders():
        sent.extend(commands.all())
        return {message.sender for message in sent}
    wait_until(lambda: senders() >= {'gripper_configure', 'gripper_stop'}, 5, 'the commands')
    assert {message.id for message in sent} == {65538}
    assert all(0 < message.sequence <= 0x7fffffff for message in sent)


def test_a_shutdown_stops_the_fingers(electric):
    from baxter_core_msgs.msg import EndEffectorCommand
    electric.healthy()
    commands = Listener(COMMAND, EndEffectorCommand)
    caller = threading.Thread(target=lambda: electric.proxy('close', 0.0, 0.0), daemon=True)
    caller.start()
    commands.next(5, lambda command: command.command == 'go')
    electric.node.process.terminate()
    commands.next(5, lambda command: command.command == 'stop')
    assert electric.node.wait(5) == 0


def test_a_caller_that_is_killed_stops_the_fingers(electric, core):
    from baxter_core_msgs.msg import EndEffectorCommand
    electric.healthy()
    commands = Listener(COMMAND, EndEffectorCommand)
    caller = core.run('rosservice', 'call', '/grasp', '{command: close, width: 0.0, force: 0.0}')
    commands.next(10, lambda command: command.command == 'go')
    caller.process.kill()
    commands.next(2, lambda command: command.command == 'stop')
    assert electric_state().position > 5, 'stopped on the way'
    assert electric.grasp('close').outcome == 'missed', 'the next one is served'


@pytest.mark.parametrize('side, base', [('left', '/hand2/reflex_takktile'), ('right', '/reflex_takktile')])
def test_reflex(start, side, base):
    from reflex_msgs.msg import Hand as HandState, PoseCommand
    start('sim_baxter', **{f'_{side}_hand': 'reflex'})
    commands = Listener(f'{base}/command_position', PoseCommand)
    start('gripper', _hand='reflex', _side=side)
    hand = Hand(side)
    hand.healthy()
    missed = hand.grasp('close')
    assert (missed.outcome, missed.error) == ('missed', '')
    hand.grasp('open')
    hand.hold(CAN_M)
    wait_until(lambda: hand.grasp('open').outcome == 'reached', 5, 'an open hand')
    gripped = hand.grasp('close', force=0.4)
    assert (gripped.outcome, gripped.error) == ('gripped', '')
    assert gripped.width == pytest.approx(CAN_M, abs=2e-3)
    loads = [motor.load for motor in rospy.wait_for_message(f'{base}/hand_state', HandState, 5).motor[:3]]
    assert all(100 < load < 200 for load in loads), f'0.4 of 350 was asked for: {loads}'
    assert hand.grasp('width', 0.1).outcome == 'reached'
    assert all(0 <= angle <= 2.19 for command in commands.all() for angle in (command.f1, command.f2, command.f3))

"""Cameras, clocks, processes, people and strangers that do what they should not. Beside each stands what must happen."""

import pathlib
import signal
import time

import pytest

from conftest import DEADLINES_S
from faults import Answers, Scan, Wrist, recovers
from graph import Listener
from lab import ADDRESSES, GRIPPER, ROBOT
from processes import wait_until

pytestmark = [pytest.mark.built, pytest.mark.timeout(180)]

# A node on another computer whose clock is so many seconds ahead.
STRANGE_CLOCK = '''
import sys, rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
rospy.init_node('stranger')
publisher = rospy.Publisher('/diagnostics', DiagnosticArray, queue_size=1)
while not rospy.is_shutdown():
    array = DiagnosticArray(status=[DiagnosticStatus(name='stranger: clock')])
    array.header.stamp = rospy.Time.now() + rospy.Duration(float(sys.argv[1]))
    publisher.publish(array)
    rospy.sleep(0.2)
'''


class Driver:
    """Stands in for the camera's driver: shows one image, which the simulated camera took, again and again."""

    def __init__(self):
        import rospy
        from sensor_msgs.msg import CameraInfo, Image
        topics = {'camera/depth/image_rect_raw': Image, 'camera/depth/camera_info': CameraInfo}
        self.messages = [Listener(topic, kind).next(10) for topic, kind in topics.items()]
        self.publishers = [rospy.Publisher(topic, kind, queue_size=1) for topic, kind in topics.items()]
        self.stamp = rospy.Time.now
        self.timer = rospy.Timer(rospy.Duration(0.1), self._show)

    def _show(self, _):
        for publisher, message in zip(self.publishers, self.messages):
            message.header.stamp = self.stamp()
            publisher.publish(message)

    def close(self):
        self.timer.shutdown()
        for publisher in self.publishers:
            publisher.unregister()


def test_camera_gone_wrong(graph, core):
    """
    stopped, showing one image for ever, stamped in the past: each an error that says so, within 2 s of the deadline of 2 s
    stamped in the future: no view is taken, since it may have been seen before the wrist came to rest
    a frozen image with fresh stamps: the second view is refused
    each time the next scan with a good camera succeeds
    """
    import rospy
    answers = Answers('medium-can')
    recovers(graph)
    core.kill('sim_camera', signal.SIGSTOP)
    response = graph.scan()
    assert "no cloud on 'points' newer than the wrist's rest" in response.error, response.error
    core.kill('sim_camera', signal.SIGCONT)
    recovers(graph)

    driver = Driver()
    core.camera.stop()
    now = rospy.Time.now()
    for stamp, words in [
        (lambda: now, "no cloud on 'points' newer than the wrist's rest"),
        (lambda: rospy.Time.now() - rospy.Duration(60), "no cloud on 'points' newer than the wrist's rest"),
        (lambda: rospy.Time.now() + rospy.Duration(0.5), 'ahead of this computer'),
        (rospy.Time.now, 'it is frozen'),
    ]:
        driver.stamp = stamp
        wait_until(lambda: words in graph.scan().error, 15, words)
    driver.close()
    core.camera = core.launch('sim_camera.launch')
    graph.hold('medium-can')
    recovers(graph)
    answers.check()


def test_clock_stepped(graph, core):
    """
    50 ms: diagnostics warn, and name the node and the number; a scan succeeds
    more than 100 ms, ahead or behind, of the robot or of a computer that only watches: no view is taken, and the error names
    the node, its computer and the number
    back in step: the next scan succeeds
    """
    import rospy
    from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
    from std_msgs.msg import Float64
    clock = rospy.Publisher('/sim_baxter/step_clock', Float64, queue_size=1, latch=True)
    diagnostics = Listener('/diagnostics', DiagnosticArray)
    recovers(graph)

    clock.publish(0.05)
    warning = diagnostics.next(20, accept=lambda array: any(
        status.name == 'view_capture: clocks' and status.level == DiagnosticStatus.WARN for status in array.status))
    assert f'the clock of /sim_baxter at {ADDRESSES[ROBOT]} is' in str(warning)
    recovers(graph, timeout_s=10)
    for offset_s, words in [(0.3, 'ms ahead of'), (-0.3, 'ms behind')]:
        clock.publish(offset_s)
        named = f'the clock of /sim_baxter at {ADDRESSES[ROBOT]}'
        wait_until(lambda: named in (error := graph.scan().error) and words in error, 20, 'a refusal that names the clock')
    clock.publish(0.0)
    recovers(graph)

    stranger = core.run_on(GRIPPER, '/usr/bin/python3', '-c', STRANGE_CLOCK, 0.3)
    named = f'the clock of /stranger at {ADDRESSES[GRIPPER]} is'
    wait_until(lambda: named in graph.scan().error, 20, 'a refusal that names the computer')
    stranger.stop()
    recovers(graph)


def test_emergency_stop_in_mid_scan(graph):
    """
    the wrist rests at once; the scan ends with an error that says why; nothing is enabled or moved by itself
    after reset and enabling by hand: the next scan succeeds
    """
    import rospy
    from std_msgs.msg import Bool, Empty
    wrist, answers = Wrist(), Answers('medium-can')
    button = rospy.Publisher('/sim_baxter/press_estop', Bool, queue_size=1, latch=True)
    reset = rospy.Publisher('/robot/set_super_reset', Empty, queue_size=1)
    enable = rospy.Publisher('/robot/set_super_enable', Bool, queue_size=1)
    recovers(graph)
    scan = Scan(graph)
    wrist.moves()
    button.publish(True)
    stopped = wrist.rests(1.0)
    assert 'emergency stop (button pressed' in scan.result(2).error
    button.publish(False)
    wait_until(lambda: 'emergency stop (button released' in graph.scan().error, 5, 'a released button')
    assert abs(wrist.angle_rad - stopped) < 0.01
    reset.publish()
    wait_until(lambda: 'not enabled' in graph.scan().error, 5, 'a reset robot')
    enable.publish(True)
    recovers(graph)
    answers.check()


# What a scan says while a node is stopped; empty: it succeeds, since the node is not needed.
STOPPED = {
    'wrist_rotator': 'sweep_wrist',
    'depth_threshold': "no cloud on 'points'",
    'icp_registration': 'not running: icp_registration',
    'roi_crop': 'not running: roi_crop',
    'classifier': 'not running: classifier',
    'camera_mount': '',
    'robot_state_publisher': 'TF of',
    'sim_baxter': 'check the link to the robot',
}


def test_nodes_stopped_and_continued(graph, core):
    """
    each node stopped: the scan ends with an error that names it, or what it should have sent, by the deadlines
    continued: the next scan succeeds
    the wrist rotator stopped in mid-turn until its caller has given up: continued, it does not move the arm any more
    killed on another computer: it is started again there, and the next scan succeeds
    """
    answers, wrist = Answers('medium-can'), Wrist()
    recovers(graph)
    for node, words in STOPPED.items():
        core.kill(node, signal.SIGSTOP)
        response = graph.scan(timeout_s=sum(DEADLINES_S.values()) + 10)
        core.kill(node, signal.SIGCONT)
        assert words in response.error and bool(words) == bool(response.error), f'{node}: {response.error}'
        print(f'{node}: {response.error}')
        recovers(graph)

    scan = Scan(graph)
    wrist.moves()
    core.kill('wrist_rotator', signal.SIGSTOP)
    stopped = wrist.rests(1.0)
    response = scan.result(DEADLINES_S['motion_deadline_s'] + 2)
    assert 'rotate_wrist' in response.error, response.error
    core.kill('wrist_rotator', signal.SIGCONT)
    time.sleep(2)
    assert abs(wrist.angle_rad - stopped) < 0.02, 'it moves though nobody waits'
    recovers(graph)

    killed = core.kill('wrist_rotator')
    wait_until(lambda: core.process_of('wrist_rotator') not in (None, killed), 20, 'the arm computer starting it again')
    recovers(graph)
    answers.check()


GROWTH_MAX_BYTES = 64 << 20


def test_hostile_peer(graph, core):
    """
    a stranger's computer connects to every port of every node and says nothing, or garbage, or announces 4 GiB; it also
    publishes on the robot's topic, and answers nobody, or announces 4 GiB: scans succeed again while it stays there, also
    after the node that hears it was started afresh; no node grows by more than 64 MiB
    """
    answers = Answers('medium-can')
    recovers(graph)
    nodes = (*STOPPED, 'view_capture', 'sim_camera')
    before = {node: core.memory(node) for node in nodes}
    stranger = core.run_on(GRIPPER, '/usr/bin/python3', pathlib.Path(__file__).with_name('stranger.py'),
                           ADDRESSES[GRIPPER])
    wait_until(lambda: 'all is done' in stranger.printed(), 30, 'the stranger')
    recovers(graph, timeout_s=45)
    grown = {node: core.memory(node) - before[node] for node in nodes}
    print(f'grown by MiB: { {node: growth >> 20 for node, growth in grown.items()} }')
    assert max(grown.values()) < GROWTH_MAX_BYTES, grown
    killed = core.kill('wrist_rotator')
    wait_until(lambda: core.process_of('wrist_rotator') not in (None, killed), 20, 'the arm computer starting it again')
    recovers(graph, timeout_s=45)
    assert stranger.running()
    answers.check()

"""/diagnostics tells which stage is the trouble (REP 107)."""

import re
import signal

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from camera import Camera, camera_info, depth_image
from graph import Listener
from processes import wait_until


class Diagnostics:
    """The latest word of each part of each node."""

    def __init__(self):
        self.statuses = {}
        self.times = []
        self.subscriber = rospy.Subscriber('/diagnostics', DiagnosticArray, self._note)

    def _note(self, array):
        self.times.append(array.header.stamp.to_sec())
        self.statuses.update({status.name: status for status in array.status})

    def wait(self, name, level, words='', timeout_s=10):
        """Waits until a part has this level and these words; returns its status."""
        def found():
            status = self.statuses.get(name)
            return status if status and status.level == level and words in status.message else None
        try:
            return wait_until(found, timeout_s, f'{name} at level {level} with "{words}"')
        except TimeoutError as error:
            raise TimeoutError(f'{error}; it says {self.statuses.get(name)}') from None


def test_a_silent_camera_shows_at_the_depth_threshold(start):
    start('depth_threshold')
    diagnostics = Diagnostics()
    image = 'camera/depth/image_rect_raw'
    never = diagnostics.wait('depth_threshold: links', DiagnosticStatus.ERROR, f'nothing on {image} yet')
    assert 'nobody publishes it' in never.message
    camera = Camera(depth_image(), camera_info())
    diagnostics.wait('depth_threshold: links', DiagnosticStatus.OK)
    well = wait_until(lambda: rated(diagnostics.statuses['depth_threshold: links'], image), 5, 'a rate')
    assert 2 < well < 12, 'the camera of this test has 10 Hz on a machine that is not too busy'
    camera.close()
    diagnostics.wait('depth_threshold: links', DiagnosticStatus.WARN, f'nothing on {image} for')
    silent = diagnostics.wait('depth_threshold: links', DiagnosticStatus.ERROR, f'nothing on {image} for')
    assert 'its publisher is silent' in silent.message and silent.hardware_id == 'none'
    pauses_s = [late - early for early, late in zip(diagnostics.times, diagnostics.times[1:])]
    assert 0.8 < sum(pauses_s) / len(pauses_s) < 1.2, 'once a second'


def rated(status, topic):
    """The rate in Hz of a topic in a status; 0 before there is one."""
    values = {value.key: value.value for value in status.values}
    return float(re.search(r'([0-9.]+) Hz', values[topic]).group(1))


def test_a_silent_robot_shows_at_the_wrist_and_the_gripper(start):
    robot = start('sim_baxter')
    start('wrist_rotator')
    start('gripper')
    diagnostics = Diagnostics()
    for node in ('wrist_rotator', 'gripper'):
        diagnostics.wait(f'{node}: links', DiagnosticStatus.OK)
    assert diagnostics.wait('wrist_rotator: arm', DiagnosticStatus.OK, 'may move').hardware_id == '/robot/limb/left'
    robot.process.send_signal(signal.SIGSTOP)
    try:
        for node in ('wrist_rotator', 'gripper'):
            status = diagnostics.wait(f'{node}: links', DiagnosticStatus.ERROR, 'nothing on /robot/state for')
        assert 'left_gripper/state' in status.message
        diagnostics.wait('wrist_rotator: arm', DiagnosticStatus.WARN, '/robot/state')
    finally:
        robot.process.send_signal(signal.SIGCONT)
    diagnostics.wait('wrist_rotator: links', DiagnosticStatus.OK)


def test_messages_that_were_lost_are_counted(start):
    from sensor_msgs.msg import JointState
    publisher = rospy.Publisher('/robot/joint_states', JointState, queue_size=10)
    start('wrist_rotator')
    listener = Listener('/diagnostics', DiagnosticArray)
    wait_until(lambda: publisher.get_num_connections() == 1, 10, 'link')
    for number in (5, 6, 9, 10):
        message = JointState(name=['left_w2'], position=[0.0])
        publisher.publish(message)
        publisher.impl.seq = number
    values = {}

    def told():
        for status in listener.next(3).status:
            values.update({value.key: value.value for value in status.values})
        return '4 messages' in values.get('/robot/joint_states', '')

    wait_until(told, 10, 'four messages')
    assert values['/robot/joint_states'].endswith('6 lost'), values

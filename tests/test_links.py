"""What lib/node does whatever its peers do."""

import struct

import pytest
import rosbag
import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import JointState, PointCloud2

from camera import Camera, camera_info, depth_image
from graph import Listener, within
from processes import wait_until
from tcpros import BrokenPublisher, MuteService, StalledSubscriber


def messages_heard(topic):
    """How many messages a node says, in its diagnostics, to have decoded on the topic."""
    array = Listener('/diagnostics', DiagnosticArray).next(5, lambda array: topic in str(array.status))
    values = {value.key: value.value for status in array.status for value in status.values}
    return int(values[topic].split()[0])


def scan_within(timeout_s):
    """The answer to a scan of one view."""
    rospy.wait_for_service('scan_object', 10)
    from deformable_cobot.srv import ScanObject
    return within(timeout_s, 'scan_object', lambda: rospy.ServiceProxy('scan_object', ScanObject)(1))


def test_a_lost_link_is_dialled_again(start):
    publisher = BrokenPublisher('/points', PointCloud2)
    start('view_capture', _use_tf='false', _mode='passive')
    wait_until(lambda: publisher.dialled == 1, 10, 'first link')
    publisher.send_message(PointCloud2())
    publisher.cut()
    wait_until(lambda: publisher.dialled >= 2, 10, 'second link after the first was lost')
    publisher.send_message(PointCloud2())
    wait_until(lambda: messages_heard('points') >= 2, 10, 'a message over the second link')


@pytest.mark.parametrize('elements', [2**31 - 1, 2**32 - 1])
def test_a_forged_length_does_not_abort(start, elements):
    """28 bytes that claim so many joint names."""
    publisher = BrokenPublisher('/robot/joint_states', JointState)
    node = start('view_capture', _use_tf='false', _mode='passive')
    wait_until(lambda: publisher.dialled == 1, 10, 'link')
    publisher.send(bytes(16) + struct.pack('<I', elements) + bytes(8))
    publisher.send_message(JointState(name=['left_w2'], position=[0.0]))
    wait_until(lambda: messages_heard('/robot/joint_states') == 1, 10, 'the good message after the forged one')
    assert node.running()


def test_a_call_ends_by_its_deadline(start, core):
    MuteService('/rotate_wrist')
    start('icp_registration')
    start('view_capture', _use_tf='false', _motion_deadline_s='1.0')
    start('scan_server')
    response = scan_within(6)
    assert 'rotate_wrist did not answer within 1.0s' in response.error


def test_a_scan_that_nobody_listens_to_is_not_begun(start):
    start('view_capture', _use_tf='false')
    start('scan_server')
    response = scan_within(10)
    assert "nobody listens to 'views'" in response.error


def test_an_absent_service_is_named(start):
    start('icp_registration')
    start('view_capture', _use_tf='false', _motion_deadline_s='1.0')
    start('scan_server')
    response = scan_within(6)
    assert 'nobody offers the service rotate_wrist' in response.error


def test_a_restarted_master_learns_of_the_node_again(start, core):
    start('camera_mount', _translation_m='[0.2, 0.0, 0.1]')
    first_run = core.output('rosparam', 'get', '/run_id')
    core.roscore.stop()
    core.start()
    assert core.output('rosparam', 'get', '/run_id') != first_run, 'a master that knows nothing of the node'
    wait_until(lambda: '/camera_mount' in core.nodes(), 15, 'camera_mount at the new master')
    assert 'camera_link' in core.output('rostopic', 'echo', '-n1', '/tf_static')
    assert core.output('rosparam', 'get', '/camera_mount/translation_m').split() == ['-', '0.2', '-', '0.0', '-', '0.1']


def test_late_listeners_get_a_latched_message_once(start, core, tmp_path):
    """And rosbag learns that it is latched, so that it plays it to those who come late."""
    from tf2_msgs.msg import TFMessage
    start('camera_mount')
    core.output('rosbag', 'record', '--duration', '3', '-O', tmp_path / 'late.bag', '/tf_static', timeout_s=30)
    recorded = list(rosbag.Bag(str(tmp_path / 'late.bag')).read_messages(return_connection_header=True))
    assert [message.connection_header['latching'] for message in recorded] == [b'1']
    late = Listener('/tf_static', TFMessage)
    assert late.next().transforms[0].child_frame_id == 'camera_link'
    rospy.sleep(2.5)
    assert late.all() == []


def test_rosnode_tells_of_connections(start, core):
    start('camera_mount')
    Listener('/tf_static').next()
    told = core.output('rosnode', 'info', '/camera_mount')
    assert '* topic: /tf_static' in told and 'ERROR' not in told, told


@pytest.mark.parametrize('unset, given, expected', [
    (['ROS_IP', 'ROS_HOSTNAME'], {'ROS_MASTER_URI': 'http://no-such-host.invalid:11311'}, 'neither ROS_IP nor ROS_HOSTNAME'),
    ([], {'ROS_IP': 'my-computer'}, "ROS_IP is 'my-computer'"),
    ([], {'ROS_HOSTNAME': 'no-such-host.invalid'}, 'cannot resolve'),
    ([], {'ROS_MASTER_URI': 'localhost'}, "ROS_MASTER_URI is 'localhost'"),
])
def test_a_bad_environment_is_named(core, executable, unset, given, expected):
    for name in unset:
        core.environment.pop(name, None)
    program = core.run(executable('camera_mount'), **given)
    assert program.wait(20) == 1
    assert expected in program.printed()


def test_an_address_that_is_not_set_is_the_one_towards_the_master(start, core):
    core.environment.pop('ROS_IP', None)
    core.environment.pop('ROS_HOSTNAME', None)
    start('camera_mount')
    Listener('/tf_static').next()
    assert rosgraph.Master('/tests').lookupNode('/camera_mount').startswith('http://127.0.0.1:')


def test_parameters_are_checked_and_shown(start, core, executable):
    for arguments, expected in [(['_radius:=1'], 'unknown field `radius`'),
                                (['_translation_m:=[9.0, 0.0, 0.0]'], 'parameter translation_m is 9;'),
                                (['_translation_m:=far'], 'translation_m')]:
        program = core.run(executable('camera_mount'), *arguments)
        assert program.wait(20) == 1
        assert expected in program.printed(), program.printed()
        core.output('rosparam', 'delete', '/camera_mount')
    start('camera_mount')
    assert 'rotation_rpy_rad' in core.output('rosparam', 'get', '/camera_mount')


def test_a_node_says_goodbye(start, core):
    program = start('camera_mount')
    program.process.terminate()
    assert program.wait(10) == 0
    wait_until(lambda: '/camera_mount' not in core.nodes(), 5, 'camera_mount gone from the master')


def test_a_node_starts_again_on_the_parameters_it_wrote_back(start, core):
    first = start('view_capture', _use_tf='false')
    first.process.kill()
    first.wait(5)
    second = start('view_capture')
    rospy.wait_for_service('capture_views', 10)
    assert second.running()
    assert core.output('rosparam', 'get', '/view_capture/view_count').strip() == '3'


def test_a_command_link_is_left_alone(start):
    """Dialling a silent command topic again would lose the command that comes meanwhile."""
    from baxter_core_msgs.msg import JointCommand
    publisher = BrokenPublisher('/robot/limb/left/joint_command', JointCommand)
    start('sim_baxter')
    wait_until(lambda: publisher.dialled == 1, 10, 'link')
    rospy.sleep(12)
    assert publisher.dialled == 1


def test_a_listener_that_stands_still_holds_up_nobody(start):
    start('depth_threshold')
    camera = Camera(depth_image(), camera_info())
    stalled = StalledSubscriber('/points', PointCloud2, '/depth_threshold')
    points = Listener('points', PointCloud2)
    # Some 10 MB, of which the system keeps 5 at most for who does not read.
    for _ in range(80):
        points.next(timeout_s=2)
    stalled.connection.close()
    camera.close()

"""Bad input: a message that names it, and a node that lives on; or, at start, one that ends with a message."""

import re
import struct

import pytest

from camera import Camera, camera_info, depth_image
from processes import wait_until

pytestmark = [pytest.mark.built, pytest.mark.timeout(180)]

NODES = ('camera_mount', 'classifier', 'deformation', 'depth_threshold', 'gripper', 'icp_registration', 'roi_crop',
         'scan_markers', 'scan_server', 'sim_baxter', 'sim_camera', 'view_capture', 'wrist_rotator')
# Where nothing but the test moves or shows anything.
ALONE = {'kinematics': 'false', 'mount': 'false', 'rotator': 'false'}


def ends_with_message(core, node, *arguments, **variables):
    """Starts one node; returns what it printed before it gave up."""
    program = core.run('rosrun', 'deformable_cobot', node, *arguments, **variables)
    assert program.wait(30) == 1, program.printed()
    return program.printed()


def test_unknown_parameter_is_named_by_every_node(core):
    for node in NODES:
        assert re.search('no_such_key', ends_with_message(core, node, '_no_such_key:=1')), node


@pytest.mark.parametrize('node, name, value', [
    ('depth_threshold', 'depth_max_m', -1), ('view_capture', 'view_count', 0), ('wrist_rotator', 'rate_hz', 0),
    ('classifier', 'device', 'TPU'), ('view_capture', 'mode', 'lazy'),
])
def test_parameter_out_of_range_is_named(core, node, name, value):
    printed = ends_with_message(core, node, f'_{name}:={value}')
    assert name in printed or str(value) in printed


def test_parameter_that_moved_is_named_with_its_new_node(core):
    for name in ('answer_deadline_s', 'scan_at_start', 'stop_when_confident'):
        printed = ends_with_message(core, 'view_capture', f'_{name}:=1')
        assert name in printed and 'parameter of scan_server now' in printed
        core.output('rosparam', 'delete', '/view_capture')


def test_missing_master_is_named(core):
    printed = ends_with_message(core, 'camera_mount', ROS_MASTER_URI='http://127.0.0.1:9')
    assert 'http://127.0.0.1:9' in printed and 'roscore' in printed


@pytest.mark.parametrize('content', [None, b'', b'not a network'], ids=['missing', 'empty', 'garbage'])
def test_unusable_model_is_named(core, tmp_path, content):
    model = tmp_path / 'some.onnx'
    if content is not None:
        model.write_bytes(content)
    assert str(model) in ends_with_message(core, 'classifier', f'_model:={model}')


@pytest.mark.parametrize('image, info, named', [
    (lambda: depth_image('8UC1'), camera_info, '8UC1'),
    (lambda: depth_image(step=7), camera_info, 'step'),
    (depth_image, lambda: None, 'camera_info'),
], ids=['encoding', 'step', 'camera_info'])
def test_bad_depth_image_is_named_and_a_good_one_then_works(launch, image, info, named):
    graph = launch('graph.launch', **ALONE)
    camera = Camera(image(), info())
    response = graph.scan()
    assert named in response.error
    before = graph.core.process_of('depth_threshold')
    camera.close()
    camera = Camera(depth_image(), camera_info())
    wait_until(lambda: 'depth_threshold' not in graph.scan().error, 30, 'a scan that gets beyond depth_threshold')
    assert graph.core.process_of('depth_threshold') == before, 'the node died'


def test_depth_in_metres_works(launch):
    graph = launch('graph.launch', **ALONE)
    Camera(depth_image('32FC1'), camera_info())
    response = graph.scan(views=3)
    assert response.error == '' and response.result.view_count == 3


def cloud(points, names='xyz', point_step=16):
    """A PointCloud2 of these points; `names` are its fields."""
    from sensor_msgs.msg import PointCloud2, PointField
    fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate(names)]
    data = b''.join(struct.pack('<3f', *point).ljust(point_step, b'\0') for point in points)
    return PointCloud2(height=1, width=len(points), fields=fields, point_step=point_step, row_step=len(data), data=data)


@pytest.mark.parametrize('points, options, named', [
    ([], {}, 'of a cloud of 0;'),
    ([(0.0, 0.0, 0.0)] * 500, {}, 'of a cloud of 0;'),
    ([(float('nan'),) * 3] * 500, {}, 'of a cloud of 0;'),
    ([(0.1, 0.1, 0.1)] * 500, {'names': 'abc'}, "no field 'x' (it has: a, b, c)"),
    ([(0.1, 0.1, 0.1)] * 500, {'point_step': 12, 'names': 'xyzw'}, ''),
    ([(0.1, 0.1, 0.1)] * 3, {}, 'of a cloud of 3;'),
], ids=['empty', 'zeros', 'nan', 'fields', 'extra', 'few'])
def test_bad_cloud_is_an_error_of_the_service(launch, points, options, named):
    graph = launch('graph.launch', **ALONE)
    graph.wait_for_service('classify_cloud', timeout_s=30)
    before = graph.core.process_of('classifier')
    error = graph.call('classify_cloud', cloud=cloud(points, **options)).result.error
    assert named in error and bool(error) == bool(named), error
    assert graph.core.process_of('classifier') == before, 'the node died'

"""Parameters that are changed while the graph runs, by dynamic_reconfigure's own client and dynparam."""

import shutil

import pytest
import yaml

from graph import Listener
from processes import wait_until

pytestmark = [pytest.mark.built, pytest.mark.timeout(240)]

TUNED = ('depth_threshold', 'icp_registration', 'roi_crop', 'view_capture')


@pytest.fixture
def sim(launch):
    """Starts the simulated robot with a can in its hand: sim(tuned=folder) -> Graph."""
    def run(**arguments):
        graph = launch('sim.launch', **arguments)
        graph.wait_for_service('scan_object', timeout_s=60)
        graph.hold('medium-can')
        return graph
    return run


def client_of(node):
    from dynamic_reconfigure.client import Client
    client = Client(node, timeout=20)
    assert client.get_configuration(timeout=10) is not None
    return client


def dynparam(core, *words):
    # By the system's Python: a pyenv may come first in PATH.
    return core.output('rosrun', '--prefix', '/usr/bin/python3', 'dynamic_reconfigure', 'dynparam', *words)


def test_descriptions_have_defaults_and_bounds(sim):
    import rospy
    sim()
    for node in TUNED:
        client = client_of(node)
        described = client.get_parameter_descriptions(timeout=10)
        in_force = rospy.get_param(f'/{node}')
        assert described
        for entry in described:
            assert entry['min'] <= entry['default'] <= entry['max'] and entry['description'], entry
            assert in_force[entry['name']] == pytest.approx(client.get_configuration()[entry['name']])
            assert type(entry['default']) is {'int': int, 'double': float}[entry['type']]


def test_a_change_counts_from_the_next_scan_on(sim, checkout, tmp_path):
    import rospy
    from deformable_cobot.msg import ObjectCloud
    from sensor_msgs.msg import PointCloud2
    config = tmp_path / 'config'
    shutil.copytree(checkout / 'config', config)
    with open(config / 'scan_server.yaml', 'a', encoding='utf-8') as file:
        file.write('stop_when_confident: 0\n')
    graph = sim(config=config, motion='steps')
    before = graph.scan()
    assert (before.error, before.result.view_count) == ('', 3)

    view_capture = client_of('view_capture')
    assert view_capture.update_configuration({'view_count': 2})['view_count'] == 2
    assert rospy.get_param('/view_capture/view_count') == 2, 'a node that is started again goes on with it'
    assert graph.scan().result.view_count == 2
    # What is out of range becomes the nearest value in it.
    assert view_capture.update_configuration({'view_count': 100})['view_count'] == 64
    view_capture.update_configuration({'view_count': 1})

    objects = Listener('object', ObjectCloud)
    client_of('roi_crop').update_configuration({'height_m': 0.05})
    scanned = graph.scan().result
    cut = objects.next(accept=lambda cut: cut.scan_id == scanned.scan_id and cut.complete)
    assert 0 < cut.cloud.width < 0.7 * before.result.point_count and cut.outside_cylinder > 0

    client_of('icp_registration').update_configuration({'min_points': 1000000})
    assert 'min_points' in graph.scan().error or '1000000' in graph.scan().error

    depth = client_of('depth_threshold')
    assert depth.update_configuration({'depth_max_m': 0.3})['depth_max_m'] == pytest.approx(0.3)
    Listener('points', PointCloud2).next(accept=lambda cloud: cloud.width == 0)
    # A change that contradicts another parameter is not made.
    refused = depth.update_configuration({'depth_min_m': 0.4})
    assert (refused['depth_min_m'], refused['depth_max_m']) == (0.25, pytest.approx(0.3))


def test_dynparam_sets_and_dumps_what_launch_files_load(sim, tmp_path):
    graph = sim()
    core = graph.core
    assert set(dynparam(core, 'list').split()) >= {f'/{node}' for node in TUNED}
    dynparam(core, 'set', 'view_capture', 'view_count', 2)
    dynparam(core, 'set', 'roi_crop', yaml.dump({'radius_m': 0.07, 'stray_min_neighbours': 6}))
    tuned = tmp_path / 'tuned'
    tuned.mkdir()
    for node in TUNED:
        dynparam(core, 'dump', node, tuned / f'{node}.yaml')
    assert graph.roslaunch.stop() == 0
    wait_until(lambda: '/view_capture' not in core.nodes(), 20, 'the end of the first graph')

    again = core.launch('sim.launch', tuned=tuned)
    import rospy
    wait_until(lambda: rospy.get_param('/roi_crop/stray_min_neighbours', None) == 6, 60, 'the tuned parameters')
    wait_until(lambda: rospy.get_param('/view_capture/view_count', None) == 2, 30, 'the tuned parameters')
    assert rospy.get_param('/roi_crop/radius_m') == pytest.approx(0.07)
    assert again.running()

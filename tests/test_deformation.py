"""How a held object is deformed: the node on the whole graph, its service, and references that cannot serve."""

import math
import pathlib
import shutil
import struct

import pytest

from graph import Listener
from test_bad_input import ALONE, cloud
from test_diagnostics import Diagnostics

pytestmark = [pytest.mark.built, pytest.mark.timeout(240)]

REFERENCES = pathlib.Path(__file__).resolve().parent.parent / 'config/references'
DENTED = {'squeeze_m': 0.010, 'seed': 1}


@pytest.fixture
def sim(launch):
    graph = launch('sim.launch')
    graph.wait_for_service('scan_object', timeout_s=60)
    graph.wait_for_service('measure_deformation', timeout_s=60)
    return graph


def deformation_of(listener, scan_id):
    """The answer to a whole scan."""
    return listener.next(accept=lambda answer: answer.scan_id == scan_id and answer.complete)


def test_a_dent_is_measured_in_the_hand_and_an_undented_can_has_none(sim):
    from deformable_cobot.msg import Deformation, ObjectCloud
    from visualization_msgs.msg import MarkerArray
    answers, objects = Listener('deformation', Deformation), Listener('object', ObjectCloud)
    pictures = Listener('deformation/markers', MarkerArray)
    sim.hold('medium-can', **DENTED)
    scan = sim.scan(views=4).result
    answer = deformation_of(answers, scan.scan_id)
    assert (answer.error, answer.reason, answer.label, answer.fits) == ('', '', 'medium-can', True)
    assert answer.reference.endswith('medium-can.ply') and answer.turn_is_open
    assert answer.dents, answer.summary
    dent = answer.dents[0]
    assert answer.largest_depth == dent.depth and 0.006 < dent.depth < 0.0125, answer.summary
    assert dent.centre.z > 0.1 and math.hypot(dent.centre.x, dent.centre.y) < 0.06, 'it is on the object in the hand'
    assert 0 < dent.centre_in_object.z < 0.1274
    assert answer.summary.startswith('dented: ') and 'mm height' in answer.summary
    assert 'deformation' in [stage.stage for stage in answer.timing]
    cut = objects.next(accept=lambda cut: cut.scan_id == scan.scan_id and cut.complete)
    assert len(cut.viewpoints) == 4 and answer.cloud.width == cut.cloud.width
    assert [field.name for field in answer.cloud.fields] == ['x', 'y', 'z', 'deviation']
    deviations = [struct.unpack_from('<f', answer.cloud.data, offset + 12)[0]
                  for offset in range(0, len(answer.cloud.data), answer.cloud.point_step)]
    assert min(value for value in deviations if value == value) < -0.5 * dent.depth

    assert len(answer.shape) > 300 and max(answer.shape_triangles) < len(answer.shape) and answer.shape_rms < 0.003
    for dent in answer.unseen_dents:
        assert 0.002 < dent.depth < 0.02 and dent.depth_sigma <= 0.0025 and dent.area == 0
    assert bool(answer.unseen_dents) != bool(answer.unseen_reason)

    depths = sorted(f'{1000 * dent.depth:.0f} mm' for dent in [*answer.dents, *answer.unseen_dents])

    def shows_each_dent(picture):
        """Pictures of the running answers come before."""
        drawn = [marker.ns for marker in picture.markers]
        said = sorted(marker.text for marker in picture.markers if marker.ns == 'depths')
        return drawn.count('dents') == len(depths) and said == depths and {'ghost', 'scale'} <= set(drawn)

    pictures.next(accept=shows_each_dent)

    again = sim.call('measure_deformation', cloud=cut.cloud, up=cut.up, viewpoints=cut.viewpoints,
                     in_hand_frame=True, label='medium-can').result
    assert (again.reason, again.largest_depth) == ('', answer.largest_depth)
    other = sim.call('measure_deformation', cloud=cut.cloud, up=cut.up, viewpoints=cut.viewpoints,
                     in_hand_frame=True, label='medium-ball').result
    assert not other.fits and not other.dents and 'does not fit' in other.reason

    sim.hold('medium-can', squeeze_m=0)
    answer = deformation_of(answers, sim.scan(views=4).result.scan_id)
    assert (answer.reason, answer.fits, answer.dents) == ('', True, []), answer.summary
    assert answer.summary.startswith('no dent') and 0.2 < answer.seen_share < 1
    assert not answer.unseen_dents and not answer.shape and 'no dent is in sight' in answer.unseen_reason


def test_without_synthesis_nothing_is_said_of_the_unseen_side(launch, tmp_path):
    from deformable_cobot.msg import Deformation
    config = shutil.copytree(REFERENCES.parent, tmp_path / 'config')
    (config / 'deformation.yaml').write_text('synthesis: false\n')
    graph = launch('sim.launch', config=config)
    graph.wait_for_service('scan_object', timeout_s=60)
    graph.wait_for_service('measure_deformation', timeout_s=60)
    answers = Listener('deformation', Deformation)
    graph.hold('medium-can', **DENTED)
    answer = deformation_of(answers, graph.scan(views=4).result.scan_id)
    assert answer.dents and not answer.unseen_dents and not answer.shape
    assert 'switched off' in answer.unseen_reason and 'unseen' not in answer.summary


def test_an_empty_hand_has_no_dents_and_says_why(sim):
    from deformable_cobot.msg import Deformation
    answers = Listener('deformation', Deformation)
    sim.hold('')
    answer = deformation_of(answers, sim.scan().result.scan_id)
    assert 'holds nothing' in answer.reason and not answer.dents


def test_a_label_that_the_cloud_contradicts_shows_in_diagnostics(launch, tmp_path):
    for file in REFERENCES.glob('*.ply'):
        shutil.copy(file, tmp_path)
    shutil.copy(REFERENCES / 'medium-ball.ply', tmp_path / 'medium-can.ply')
    graph = launch('sim.launch', references=tmp_path)
    graph.wait_for_service('scan_object', timeout_s=60)
    graph.wait_for_service('measure_deformation', timeout_s=60)
    diagnostics = Diagnostics()
    graph.hold('medium-can', **DENTED)
    assert graph.scan().result.label == 'medium-can'
    diagnostics.wait('deformation: fit', 1, 'is said to be medium-can')


def test_bad_clouds_and_labels_are_reasons_and_the_node_lives_on(launch, tmp_path):
    (tmp_path / 'metres.ply').write_bytes(scaled(REFERENCES / 'medium-can.ply', 0.001))
    (tmp_path / 'points.ply').write_text('ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n'
                                         'property float z\nend_header\n1 2 3\n')
    (tmp_path / 'broken.ply').write_bytes(b'not a mesh')
    graph = launch('graph.launch', references=tmp_path, **ALONE)
    graph.wait_for_service('measure_deformation', timeout_s=30)
    before = graph.core.process_of('deformation')
    points = [(0.1, 0.1, 0.1 + 0.0001 * i) for i in range(500)]

    def reason(label, points, **options):
        result = graph.call('measure_deformation', cloud=cloud(points, **options), label=label).result
        assert not result.fits and not result.dents and result.summary
        return result.reason

    assert 'teapot.ply' in reason('teapot', points)
    assert 'millimetres' in reason('metres', points)
    assert 'no faces' in reason('points', points)
    assert 'broken.ply' in reason('broken', points)
    assert "no field 'x'" in reason('metres', points, names='abc')
    assert graph.core.process_of('deformation') == before, 'the node died'


def test_points_that_are_nothing_do_not_fit(launch):
    graph = launch('graph.launch', **ALONE)
    graph.wait_for_service('measure_deformation', timeout_s=30)
    for points in ([], [(0.0, 0.0, 0.0)] * 50, [(float('nan'),) * 3] * 50, [(1e6, 1e6, 1e6)] * 50):
        result = graph.call('measure_deformation', cloud=cloud(points), label='medium-can').result
        assert result.reason and not result.fits and not result.dents


def scaled(path, factor):
    """A binary PLY of ours with its vertices scaled."""
    content = path.read_bytes()
    head, body = content.split(b'end_header\n', 1)
    count = int(head.split(b'element vertex ')[1].split()[0])
    values = [factor * value for value in struct.unpack_from(f'<{3 * count}f', body)]
    return head + b'end_header\n' + struct.pack(f'<{3 * count}f', *values) + body[12 * count:]

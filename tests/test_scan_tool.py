"""The program `scan`, as typed into a terminal."""

import json
import signal

import pytest
import yaml

from graph import Listener
from processes import wait_until

pytestmark = [pytest.mark.built, pytest.mark.timeout(240)]


@pytest.fixture
def sim(launch):
    """The simulated robot with a can in its hand, ready to scan."""
    graph = launch('sim.launch')
    graph.wait_for_service('scan_object', timeout_s=60)
    graph.hold('medium-can')
    return graph


def pcd_points(path):
    """The number of points that a PCD file announces; fails where it has other than three floats for each."""
    head, data = path.read_bytes().split(b'DATA binary\n')
    count = int(head.split(b'POINTS ')[1].split()[0])
    assert len(data) == 12 * count
    return count


def test_it_answers_and_saves_the_scan(sim, executable, shelf):
    folder = shelf / 'can'
    printed = sim.core.output(executable('scan'), '--views', 2, '--json', '--save', folder, timeout_s=60)
    assert printed.count(f'saved in {folder}') == 1
    answer = json.loads(printed.replace(f'saved in {folder}', ''))
    assert (answer['label'], answer['known'], answer['view_count']) == ('medium-can', True, 2)
    assert sum(answer['probabilities'].values()) == pytest.approx(1)
    assert [path.name for path in shelf.iterdir()] == ['can'], 'nothing unfinished is left'
    names = sorted(path.name for path in folder.iterdir())
    assert names == ['object.pcd', 'registered.pcd', 'scan.yaml', 'view_1.pcd', 'view_2.pcd']
    described = yaml.safe_load((folder / 'scan.yaml').read_text())
    assert (described['label'], described['frame']) == ('medium-can', 'left_hand')
    assert pcd_points(folder / 'object.pcd') == described['object_points'] == answer['point_count']
    assert pcd_points(folder / 'registered.pcd') == described['registered_points'] > described['object_points']
    for view in described['views']:
        assert pcd_points(folder / view['file']) == view['points'] > 1000
        assert view['registered']['accepted'] and len(view['hand_from_camera']['rotation']) == 4
    # The same folder again is refused before the arm moves.
    again = sim.core.run(executable('scan'), '--save', folder)
    assert again.wait(20) == 1
    assert 'exists already' in again.printed()
    assert sorted(path.name for path in folder.iterdir()) == names


def test_two_at_once_do_not_end_each_other(sim, executable):
    first = sim.core.run(executable('scan'), '--views', 8)
    progress = Listener('scan_object/feedback')
    progress.next(timeout_s=20)
    second = sim.core.run(executable('scan'), '--views', 1)
    assert second.wait(60) == 0, second.printed()
    assert 'medium-can' in second.printed()
    assert first.wait(20) == 1
    assert 'stopped on request: preempted by a newer goal' in first.printed()


def test_ctrl_c_ends_with_a_still_arm_and_nothing_saved(sim, executable, shelf):
    from sensor_msgs.msg import JointState
    joints = Listener('/robot/joint_states', JointState)

    def speed():
        state = joints.next(accept=lambda state: 'left_w2' in state.name)
        joints.all()
        return abs(state.velocity[state.name.index('left_w2')])

    scan = sim.core.run(executable('scan'), '--views', 8, '--save', shelf / 'can')
    wait_until(lambda: speed() > 0.2, 20, 'the wrist to turn', period_s=0)
    scan.process.send_signal(signal.SIGINT)
    assert scan.wait(10) == 1
    joints.all()
    assert speed() < 0.05
    assert 'stopped on request: cancelled' in scan.printed()
    assert not list(shelf.iterdir())
    assert sim.scan().error == ''


def test_what_is_wrong_is_said(core, executable):
    alone = core.run(executable('scan'))
    wrong = core.run(executable('scan'), '--views', 'many')
    assert wrong.wait(20) == 2
    assert "invalid value 'many'" in wrong.printed()
    assert alone.wait(30) == 1
    assert 'is view_capture running?' in alone.printed()

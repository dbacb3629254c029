"""The program `scan`, as typed into a terminal."""

import json
import os
import signal

import pytest
import yaml

from graph import Listener
from processes import wait_until

pytestmark = [pytest.mark.built, pytest.mark.timeout(240)]


def pcd_points(path, floats=3):
    """The number of points that a PCD file announces; fails where it has other than so many floats for each."""
    head, data = path.read_bytes().split(b'DATA binary\n')
    count = int(head.split(b'POINTS ')[1].split()[0])
    assert len(data) == 4 * floats * count
    return count


def test_it_answers_and_saves_the_scan(sim, executable, shelf):
    folder = shelf / 'can'
    printed = sim.core.output(executable('scan'), '--views', 2, '--json', '--save', folder, timeout_s=60)
    assert printed.count(f'saved in {folder}') == 1
    answer = json.loads(printed.replace(f'saved in {folder}', ''))
    assert (answer['label'], answer['known'], answer['view_count']) == ('medium-can', True, 2)
    assert sum(answer['probabilities'].values()) == pytest.approx(1)
    assert answer['deformation']['fits'] and answer['deformation']['summary']
    assert [path.name for path in shelf.iterdir()] == ['can'], 'nothing unfinished is left'
    names = sorted(path.name for path in folder.iterdir())
    assert names == ['object.pcd', 'registered.pcd', 'scan.html', 'scan.yaml', 'view_1.pcd', 'view_2.pcd']
    described = yaml.safe_load((folder / 'scan.yaml').read_text())
    assert (described['label'], described['frame']) == ('medium-can', 'left_hand')
    assert b'FIELDS x y z deviation' in (folder / 'object.pcd').read_bytes()
    assert described['deformation']['summary'] == answer['deformation']['summary']
    assert pcd_points(folder / 'object.pcd', floats=4) == described['object_points'] == answer['point_count']
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
    assert 'is scan_server running?' in alone.printed()


@pytest.mark.timeout(3600)
@pytest.mark.parametrize('views, code', [(1, 0), (65, 1)], ids=['answered', 'refused'])
def test_it_never_hangs(sim, executable, views, code):
    """Also where others listen to goals, as `rosbag record -a` does. DEFORMABLE_COBOT_SCANS says how often."""
    listener = Listener('scan_object/goal')
    for _ in range(int(os.environ.get('DEFORMABLE_COBOT_SCANS', '5'))):
        scan = sim.core.run(executable('scan'), '--views', views)
        assert scan.wait(30) == code, scan.printed()
    listener.close()


class ForgetfulServer:
    """A server of the action that loses the first goal, the first result and the first cancellation."""

    def __init__(self):
        import rospy
        from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
        from deformable_cobot.msg import ScanObjectActionFeedback, ScanObjectActionGoal, ScanObjectActionResult
        self.status = GoalStatus()
        self.goals, self.cancels, self.is_done = [], [], False
        self.lost_results = 1
        self.statuses = rospy.Publisher('scan_object/status', GoalStatusArray, queue_size=1)
        self.feedback = rospy.Publisher('scan_object/feedback', ScanObjectActionFeedback, queue_size=1)
        self.results = rospy.Publisher('scan_object/result', ScanObjectActionResult, queue_size=1)
        self.links = [rospy.Subscriber('scan_object/goal', ScanObjectActionGoal, self._take),
                      rospy.Subscriber('scan_object/cancel', GoalID, self._cancel)]
        self.timer = rospy.Timer(rospy.Duration(0.1), self._tell)

    def _tell(self, _event):
        from actionlib_msgs.msg import GoalStatusArray
        self.statuses.publish(GoalStatusArray(status_list=[self.status] if self.status.goal_id.id else []))

    def _take(self, goal):
        self.goals.append(goal)
        if len(self.goals) == 2:
            self.status.goal_id, self.status.status = goal.goal_id, self.status.ACTIVE
        elif self.is_done:
            self._answer()

    def _cancel(self, goal_id):
        self.cancels.append(goal_id)
        if len(self.cancels) == 2:
            self.end(self.status.PREEMPTED)

    def end(self, status):
        """The goal has ended; the first result is lost."""
        self.status.status, self.is_done = status, True

    def _answer(self):
        from deformable_cobot.msg import ScanObjectActionResult
        result = ScanObjectActionResult(status=self.status)
        result.result.classification.label, result.result.classification.known = 'medium-can', True
        self.results.publish(result)


@pytest.fixture
def forgetful(core):
    import rospy
    rospy.init_node('client', anonymous=True, disable_signals=True)
    return ForgetfulServer()


def test_what_is_lost_on_the_way_is_sent_again(forgetful, core, executable):
    scan = core.run(executable('scan'))
    wait_until(lambda: len(forgetful.goals) == 2, 20, 'the goal again')
    forgetful.end(forgetful.status.SUCCEEDED)
    assert scan.wait(10) == 0, scan.printed()
    assert 'medium-can' in scan.printed()
    assert len({goal.goal_id.id for goal in forgetful.goals}) == 1


def test_a_lost_cancellation_is_sent_again(forgetful, core, executable):
    scan = core.run(executable('scan'))
    wait_until(lambda: len(forgetful.goals) == 2, 20, 'the goal again')
    scan.process.send_signal(signal.SIGINT)
    assert scan.wait(10) == 1, scan.printed()
    assert len(forgetful.cancels) >= 2

"""The action `scan_object`, asked by actionlib's own client and by rostopic."""

import signal

import pytest

from graph import Listener
from processes import wait_until

pytestmark = [pytest.mark.built, pytest.mark.timeout(240)]

GOAL_TYPE = 'deformable_cobot/ScanObjectActionGoal'


@pytest.fixture
def client(sim):
    """actionlib's client of the action."""
    return make_client()


def make_client():
    import actionlib
    import rospy
    from deformable_cobot.msg import ScanObjectAction
    client = actionlib.SimpleActionClient('scan_object', ScanObjectAction)
    assert client.wait_for_server(rospy.Duration(20))
    return client


def send(client, views, **callbacks):
    from deformable_cobot.msg import ScanObjectGoal
    client.send_goal(ScanObjectGoal(views=views), **callbacks)


def ended(client, timeout_s=60):
    """Waits for the end of the client's goal; returns the name of its state, and its result."""
    import actionlib
    import rospy
    assert client.wait_for_result(rospy.Duration(timeout_s))
    # A status from before the result, handled after it, makes the client take the goal for active again until the next one.
    live = (actionlib.GoalStatus.PENDING, actionlib.GoalStatus.ACTIVE)
    wait_until(lambda: client.get_state() not in live, 5, 'the status of a goal that has its result')
    return actionlib.GoalStatus.to_string(client.get_state()), client.get_result()


class W2:
    """Where joint W2 is, and whether it moves."""

    def __init__(self):
        import rospy
        from sensor_msgs.msg import JointState
        self.angle, self.speed = None, None
        self.states = rospy.Subscriber('/robot/joint_states', JointState, self._note)

    def _note(self, state):
        if 'left_w2' in state.name:
            index = state.name.index('left_w2')
            self.angle, self.speed = state.position[index], abs(state.velocity[index])

    def wait_for_motion(self):
        wait_until(lambda: self.speed is not None and self.speed > 0.2, 20, 'the wrist to turn', period_s=0.005)


def test_types_are_those_that_genaction_makes(checkout, tmp_path):
    """rosrust_msg does not read .action files; the messages that it is given must be the ones everybody else has."""
    import subprocess
    import roslib.message
    import roslib.packages
    [genaction] = roslib.packages.find_node('actionlib_msgs', 'genaction.py')
    folder = checkout / 'msg'
    action = folder / 'deformable_cobot' / 'action' / 'ScanObject.action'
    subprocess.run(['/usr/bin/python3', genaction, action, '-o', tmp_path], check=True)
    kept = {file.name: file.read_text() for file in (folder / 'derived/deformable_cobot/msg').iterdir()}
    assert kept == {file.name: file.read_text() for file in tmp_path.iterdir()}
    assert roslib.message.get_message_class('deformable_cobot/ScanObjectAction') is not None


def test_a_goal_is_told_of_and_answered(client):
    told = []
    send(client, 3, feedback_cb=told.append)
    state, result = ended(client)
    assert (state, result.error) == ('SUCCEEDED', '')
    answer = result.classification
    assert (answer.label, answer.view_count, answer.complete) == ('medium-can', 3, True)
    assert {feedback.state for feedback in told} >= {'turning', 'looking', 'classifying'}
    assert {feedback.scan_id for feedback in told} == {answer.scan_id}
    views = [feedback.view for feedback in told]
    assert set(views) == {1, 2, 3} and views == sorted(views)
    assert all(feedback.count == 3 for feedback in told)
    turning = [feedback for feedback in told if feedback.state == 'turning']
    angles = [feedback.wrist_angle for feedback in turning]
    assert max(angles) - min(angles) > 1.0, 'three views are 1.2 rad from first to last'
    assert any(feedback.view_count == 2 and feedback.label == 'medium-can' and feedback.points > 1000
               for feedback in turning)


def test_a_cancelled_goal_leaves_a_still_arm_and_a_free_graph(client):
    from deformable_cobot.msg import Classification, ScanObjectFeedback
    answers, progress = Listener('classification', Classification), Listener('progress', ScanObjectFeedback)
    wrist = W2()
    for _ in range(2):
        send(client, 8)
        wrist.wait_for_motion()
        client.cancel_goal()
        state, result = ended(client, timeout_s=5)
        assert state == 'PREEMPTED' and 'stopped on request' in result.error
        assert wrist.speed < 0.05
        angle = wrist.angle
    answers.next(accept=lambda answer: answer.complete and 'stopped on request' in answer.error)
    assert progress.next(accept=lambda report: report.state == 'stopped').count == 8
    assert wrist.angle == pytest.approx(angle, abs=0.01)
    send(client, 2)
    state, result = ended(client)
    assert (state, result.error, result.classification.label) == ('SUCCEEDED', '', 'medium-can')


def test_a_new_goal_preempts_the_old_one(client):
    other, wrist = make_client(), W2()
    send(client, 8)
    wrist.wait_for_motion()
    send(other, 2)
    state, result = ended(client, timeout_s=10)
    assert state == 'PREEMPTED'
    state, result = ended(other)
    assert (state, result.classification.view_count) == ('SUCCEEDED', 2)


def test_service_and_action_share_the_one_scan_at_a_time(client, sim):
    wrist = W2()
    send(client, 4)
    wrist.wait_for_motion()
    assert 'already running' in sim.scan().error
    state, result = ended(client)
    assert (state, result.classification.view_count) == ('SUCCEEDED', 4)
    send(client, 65)
    state, result = ended(client)
    assert state == 'ABORTED' and '65 views' in result.error


def test_a_caller_of_the_service_that_dies_ends_its_scan(sim):
    from deformable_cobot.msg import Classification
    answers, wrist = Listener('classification', Classification), W2()
    caller = sim.core.run('rosservice', 'call', '/scan_object', 'views: 8')
    wrist.wait_for_motion()
    caller.process.kill()
    ended = answers.next(timeout_s=20, accept=lambda answer: answer.complete)
    assert 'hung up or died' in ended.error
    assert wrist.speed < 0.05
    assert sim.scan(views=1).error == ''


def test_rostopic_sends_and_cancels_goals(sim):
    from actionlib_msgs.msg import GoalStatusArray
    from deformable_cobot.msg import ScanObjectActionResult
    core, results = sim.core, Listener('scan_object/result', ScanObjectActionResult)
    statuses = Listener('scan_object/status', GoalStatusArray)
    wrist = W2()
    core.run('rostopic', 'pub', '--once', '/scan_object/goal', GOAL_TYPE, 'goal: {views: 8}')
    wrist.wait_for_motion()
    core.run('rostopic', 'pub', '--once', '/scan_object/cancel', 'actionlib_msgs/GoalID', '{}')
    result = results.next(timeout_s=20)
    assert result.status.status == result.status.PREEMPTED
    assert result.status.goal_id.id and result.status.goal_id.stamp.to_sec() > 0, 'the server gave it a name'
    listed = statuses.next(accept=lambda message: message.status_list and message.status_list[0].status == 2)
    assert listed.status_list[0].goal_id == result.status.goal_id
    statuses.next(timeout_s=10, accept=lambda message: not message.status_list)


def test_a_goal_ends_when_nobody_waits_for_its_result(sim):
    from deformable_cobot.msg import Classification
    answers, wrist = Listener('classification', Classification), W2()
    echo = sim.core.run('rostopic', 'echo', '/scan_object/result')
    # As a client that is killed: nobody tells the master.
    wait_until(lambda: 'scan_server' in sim.core.output('rostopic', 'info', '/scan_object/result'), 10, 'the topic')
    wait_until(lambda: '/rostopic_' in sim.core.output('rostopic', 'info', '/scan_object/result'), 10, 'the listener')
    sim.core.run('rostopic', 'pub', '--once', '/scan_object/goal', GOAL_TYPE, 'goal: {views: 16}')
    wrist.wait_for_motion()
    echo.process.kill()
    ended = answers.next(timeout_s=10, accept=lambda answer: answer.complete)
    assert 'scan_object/result' in ended.error
    wait_until(lambda: wrist.speed < 0.05, 1, 'rest')
    assert sim.scan(views=1).error == ''


@pytest.mark.parametrize('node, state', [('scan_server', 'PREEMPTED'), ('view_capture', 'ABORTED')])
def test_a_node_that_is_told_to_end_says_so_to_the_client(sim, client, node, state):
    wrist = W2()
    send(client, 8)
    wrist.wait_for_motion()
    stopped = sim.core.kill(node, signal.SIGINT)
    ended_as, result = ended(client, timeout_s=10)
    assert ended_as == state and 'shutting down' in result.error
    assert wrist.speed < 0.05
    wait_until(lambda: sim.core.process_of(node) not in (None, stopped), 20, f'{node} again')
    assert f'[{node}' in sim.roslaunch.printed() and 'exit code -' not in sim.roslaunch.printed()
    wait_until(lambda: sim.scan(views=1).error == '', 30, 'the next scan')


def test_a_goal_that_comes_again_is_the_same_and_its_lost_result_comes_again(sim):
    import rospy
    from deformable_cobot.msg import ScanObjectActionGoal, ScanObjectActionResult
    results = Listener('scan_object/result', ScanObjectActionResult)
    goals = rospy.Publisher('scan_object/goal', ScanObjectActionGoal, queue_size=4)
    wait_until(lambda: goals.get_num_connections() > 0, 10, 'the server')
    goal = ScanObjectActionGoal()
    goal.goal_id.id, goal.goal.views = 'the same', 1
    goals.publish(goal)
    goals.publish(goal)
    first = results.next(timeout_s=30)
    assert results.all() == []
    goals.publish(goal)
    again = results.next(timeout_s=5)
    assert first.status.status == first.status.SUCCEEDED and first.result == again.result


def test_a_scan_at_the_start_moves_no_arm_unless_told_so_twice(sim):
    import rospy
    from diagnostic_msgs.msg import DiagnosticArray
    diagnostics, wrist = Listener('/diagnostics', DiagnosticArray), W2()
    commands = Listener('/robot/limb/left/joint_command')
    rospy.set_param('/scan_server/scan_at_start', True)
    sim.core.kill('scan_server')
    told = diagnostics.next(timeout_s=30, accept=lambda array: 'scan_server: scan_at_start' in str(array.status))
    assert 'scan_at_start_moves_arm' in str(told.status)
    assert commands.all() == []
    rospy.set_param('/scan_server/scan_at_start_moves_arm', True)
    sim.core.kill('scan_server')
    wrist.wait_for_motion()

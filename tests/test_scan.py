"""The whole graph on the simulated robot."""

import re
import shutil
import time

import pytest

from graph import Listener
from processes import wait_until
from timing import milliseconds

pytestmark = [pytest.mark.built, pytest.mark.timeout(240)]

VIEWS = 3


def test_scan_names_the_object(sim):
    response = sim.scan()
    result = response.result
    assert (response.error, result.error) == ('', '')
    assert (result.label, result.known, result.complete) == ('medium-can', True, True)
    assert result.label == result.labels[result.probabilities.index(max(result.probabilities))]
    assert sum(result.probabilities) == pytest.approx(1, abs=1e-6)
    assert result.provider == 'openvino:CPU'
    assert {'capture', 'settle', 'register', 'crop', 'sample', 'infer'} <= set(milliseconds(result.timing))


def test_one_id_runs_through_all_messages_of_a_scan(sim):
    from deformable_cobot.msg import Classification, ObjectCloud, RegisteredCloud, View
    topics = {'views': View, 'registered': RegisteredCloud, 'object': ObjectCloud, 'classification': Classification}
    listeners = {topic: Listener(topic, kind) for topic, kind in topics.items()}
    ids = []

    def complete(message):
        return message.scan_id == ids[-1] and message.complete

    for _ in range(2):
        response = sim.scan(views=VIEWS)
        assert response.error == ''
        ids.append(response.result.scan_id)
        views = {}
        while len(views) < VIEWS:
            view = listeners['views'].next(accept=lambda view: view.scan_id == ids[-1])
            views.setdefault(view.index, view)  # latched messages are said again each second
        assert list(views) == list(range(VIEWS))
        assert all(view.has_pose and view.hand_frame == 'left_hand' for view in views.values())
        registered = listeners['registered'].next(accept=complete)
        assert len(registered.views) == VIEWS
        assert all(view.accepted for view in registered.views), [view.reason for view in registered.views]
        cut = listeners['object'].next(accept=complete)
        assert (cut.error, cut.in_hand_frame, cut.header.frame_id) == ('', True, 'left_hand')
        answer = listeners['classification'].next(accept=complete)
        assert answer.label == response.result.label
        assert answer.header.stamp == views[VIEWS - 1].header.stamp
    assert ids[0] != ids[1]


def test_as_many_views_as_the_caller_asks_for(sim):
    response = sim.scan(views=5)
    assert (response.error, response.result.view_count) == ('', 5)


def test_scan_with_a_reflex_hand_on_the_right_arm(launch):
    from deformable_cobot.msg import ObjectCloud
    from sensor_msgs.msg import JointState
    graph = launch('sim.launch', side='right', hand='reflex')
    graph.wait_for_service('scan_object', timeout_s=60)
    graph.hold('medium-can')
    objects, states = Listener('object', ObjectCloud), Listener('/robot/joint_states', JointState)
    before = wrists(states.next(accept=wrists))
    response = graph.scan(views=VIEWS)
    assert (response.error, response.result.label, response.result.view_count) == ('', 'medium-can', VIEWS)
    cut = objects.next(accept=lambda message: message.complete)
    assert (cut.in_hand_frame, cut.header.frame_id) == (True, 'right_hand')
    after = wrists([state for state in states.all() if wrists(state)][-1])
    turned = {joint: abs(angle - before[joint]) > 0.5 for joint, angle in after.items()}
    assert turned == {'left_w2': False, 'right_w2': True}


def wrists(state):
    """Angle by wrist joint in a JointState; empty where it is about other joints."""
    return {name: angle for name, angle in zip(state.name, state.position) if name.endswith('_w2')}


def test_command_line_tools_see_the_graph(sim):
    core = sim.core
    assert 'name: ' not in core.output('rosnode', 'list')
    answer = core.output('rosservice', 'call', '/scan_object', 'views: 0', timeout_s=60)
    assert 'label: "medium-can"' in answer
    # The topic is latched, and said again each second for those who came late.
    assert 'label: "medium-can"' in core.output('rostopic', 'echo', '-n', '1', '/classification')
    assert 'enabled: True' in core.output('rostopic', 'echo', '-n', '1', '/robot/state')
    assert 'frame_id: "camera_depth_optical_frame"' in core.output(
        'rostopic', 'echo', '-n', '1', '--noarr', '/camera/depth/image_rect_raw')
    assert 'deformable_cobot/View' in core.output('rostopic', 'info', '/views')


def test_scans_while_one_runs_are_refused_or_answered(sim):
    import threading
    responses = []
    callers = [threading.Thread(target=lambda: responses.append(sim.scan(views=VIEWS))) for _ in range(2)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join(90)
    assert len(responses) == 2
    assert any(response.error == '' for response in responses)
    assert all(response.error or response.result.view_count == VIEWS for response in responses)


@pytest.mark.parametrize('file, setting, value, words', [
    ('scan_pose.yaml', 'left_w1', 1.2, 'the gripper leans 2[0-9][.][0-9] degrees .* more than the 15 allowed'),
    ('scan_pose.yaml', 'head_pan_rad', 0.65, 'pixels beyond the (left|right) edge of the image'),
    ('view_capture.yaml', 'depth_max_m', 0.3, '0[.]1[0-9] m too far'),
], ids=['leaning', 'out of view', 'out of range'])
def test_a_hand_that_cannot_be_scanned_is_not_turned(launch, checkout, tmp_path, file, setting, value, words):
    from baxter_core_msgs.msg import JointCommand
    shutil.copytree(checkout / 'config', tmp_path / 'config')
    settings = tmp_path / 'config' / file
    text, changes = re.subn(f'({setting}: )[-0-9.]+', f'\\g<1>{value}', settings.read_text())
    settings.write_text(text if changes else f'{text}{setting}: {value}\n')
    sim = launch('sim.launch', config=tmp_path / 'config')
    sim.wait_for_service('scan_object', timeout_s=60)
    commands = Listener('/robot/limb/left/joint_command', JointCommand)
    error = sim.scan().error
    assert re.search(words, error), error
    assert commands.all() == []


def test_a_caller_that_is_killed_ends_its_scan_and_the_motion(sim):
    import rospy
    from deformable_cobot.msg import RegisteredCloud
    from sensor_msgs.msg import JointState
    angles, registered = [], Listener('registered', RegisteredCloud)

    def note(message):
        if 'left_w2' in message.name:
            angles.append(message.position[message.name.index('left_w2')])

    rospy.Subscriber('/robot/joint_states', JointState, note)
    assert sim.scan().error == ''
    begin = angles[-1]
    registered.all()
    caller = sim.core.run('rosservice', 'call', '/scan_object', 'views: 3')
    wait_until(lambda: abs(angles[-1] - begin) > 0.1, 20, 'motion', period_s=0.005)
    caller.process.kill()
    time.sleep(0.5)
    at = angles[-1]
    time.sleep(0.5)
    assert abs(angles[-1] - at) < 2e-3, 'it moves on'
    assert 'caller' in registered.next(5, lambda message: message.error != '').error
    assert sim.scan().error == '', 'the next scan'

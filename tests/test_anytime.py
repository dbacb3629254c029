"""Answers while a scan goes on: after each view, and before the last one where that is enough."""

import shutil

import pytest

from camera import Camera, camera_info, depth_image
from graph import Listener, within
from processes import wait_until

pytestmark = [pytest.mark.built, pytest.mark.timeout(240)]

VIEWS = 3
# What the network has no doubt about in any view.
PLAIN = 'small-cup'


@pytest.fixture
def sim(launch, checkout, tmp_path):
    """Starts the simulated robot, which scans by steps, with settings of scan_server: sim(stop_when_confident=0.9) -> Graph."""
    def run(**settings):
        config = tmp_path / 'config'
        shutil.copytree(checkout / 'config', config)
        with open(config / 'view_capture.yaml', 'a', encoding='utf-8') as file:
            file.write('motion: steps\n')
        with open(config / 'scan_server.yaml', 'a', encoding='utf-8') as file:
            file.writelines(f'{name}: {value}\n' for name, value in settings.items())
        graph = launch('sim.launch', config=config)
        graph.wait_for_service('scan_object', timeout_s=60)
        graph.hold(PLAIN)
        return graph
    return run


def of_scan(listener, scan_id):
    """The scan's messages up to the complete one, each once: latched ones are said again each second."""
    found = []
    while not found or not found[-1].complete:
        message = listener.next(accept=lambda message: message.scan_id == scan_id)
        if message not in found:
            found.append(message)
    return found


@pytest.mark.parametrize('views', [1, 3])
def test_every_stage_speaks_after_each_view(sim, views):
    from deformable_cobot.msg import Classification, ObjectCloud, RegisteredCloud
    graph = sim()
    kinds = {'registered': RegisteredCloud, 'object': ObjectCloud, 'classification': Classification}
    listeners = {topic: Listener(topic, kind) for topic, kind in kinds.items()}
    response = graph.scan(views=views)
    assert response.error == ''
    for topic, listener in listeners.items():
        messages = of_scan(listener, response.result.scan_id)
        assert [message.view_count for message in messages] == list(range(1, views + 1)), topic
        assert [message.complete for message in messages] == [False] * (views - 1) + [True], topic
        assert all(message.error == '' for message in messages), topic
        last = messages[-1]
    assert last == response.result


def test_a_sure_answer_ends_the_scan_and_the_wrist_stays(sim):
    from deformable_cobot.msg import Classification, View
    from sensor_msgs.msg import JointState
    graph = sim(stop_when_confident=0.9)
    views, answers = Listener('views', View), Listener('classification', Classification)
    response = graph.scan()
    result = response.result
    assert (response.error, result.label, result.known, result.complete) == ('', PLAIN, True, True)
    assert result.view_count < VIEWS and result.probability >= 0.9
    running, last = of_scan(answers, result.scan_id)[-2:]
    assert (running.view_count, running.complete) == (last.view_count, False)
    assert (running.label, running.probability) == (last.label, last.probability)
    seen = {view.index: view for view in views.all() if view.scan_id == result.scan_id}
    end = seen.pop(result.view_count)
    assert (end.count, end.error, end.cloud.width) == (result.view_count, '', 0)
    assert sorted(seen) == list(range(result.view_count))
    joints = Listener('/robot/joint_states', JointState).next(accept=lambda state: 'left_w2' in state.name)
    angle = joints.position[joints.name.index('left_w2')]
    assert angle == pytest.approx(seen[result.view_count - 1].wrist_angle, abs=0.02)
    # The next scan begins anew.
    assert graph.scan().result.label == PLAIN


def test_an_answer_that_is_never_sure_takes_all_views(sim):
    response = sim(stop_when_confident=1.0).scan()
    assert (response.error, response.result.label, response.result.view_count) == ('', PLAIN, VIEWS)


@pytest.mark.parametrize('settings', [{'stop_when_confident': 0}, {'stop_when_confident': 0.1}], ids=['all views', 'early end allowed'])
def test_an_empty_hand_is_an_answer(sim, settings):
    graph = sim(**settings)
    graph.hold('')
    response = graph.scan(timeout_s=30)
    result = response.result
    assert (response.error, result.error) == ('', '')
    assert (result.known, result.label, result.probability) == (False, '', 0)
    assert not result.labels and not result.probabilities
    assert (result.view_count, result.complete) == (VIEWS, True)
    graph.hold('large-cup')
    response = graph.scan()
    assert (response.error, response.result.label) == ('', 'large-cup')


@pytest.mark.parametrize('node', ['roi_crop', 'classifier'])
def test_a_stage_killed_between_views_is_back_for_the_answer(sim, node):
    """What it gets after its start has all views so far: none is lost with it."""
    from concurrent.futures import ThreadPoolExecutor
    from deformable_cobot.msg import Classification
    graph = sim(answer_deadline_s=30)
    answers = Listener('classification', Classification)
    with ThreadPoolExecutor() as pool:
        scan = pool.submit(graph.scan, views=8)
        assert answers.next(timeout_s=30).view_count == 1
        killed = graph.core.kill(node)
        response = scan.result(90)
    assert (response.error, response.result.view_count, response.result.label) == ('', 8, PLAIN)
    assert graph.core.process_of(node) not in (None, killed)


class Stages:
    """What comes after scan_server, made by a test: answers each view as told, and hears how the scan ends."""

    def __init__(self, answer_to):
        import rospy
        from deformable_cobot.msg import Classification, View
        self.ends = []
        self.answer_to = answer_to
        self.answers = rospy.Publisher('classification', Classification, queue_size=10)
        self.views = rospy.Subscriber('views', View, self._hear)
        self.heard = set()

    def _hear(self, view):
        from deformable_cobot.msg import Classification
        if (view.kind, view.index) in self.heard or view.kind == view.FAILED:
            return
        self.heard.add((view.kind, view.index))
        if view.kind == view.END:
            self.ends.append(view)
        fields = self.answer_to(view)
        if fields is not None:
            self.answers.publish(Classification(scan_id=view.scan_id, **fields))


def answer(view, **fields):
    """As the classifier would: the complete one after the last view, or when the scan is ended early."""
    is_end = view.kind == view.END
    return {'view_count': view.index + (not is_end), 'complete': is_end or view.index + 1 == view.count,
            'label': 'cup', 'known': True, 'probability': 0.9, **fields}


@pytest.fixture
def capture(start):
    """Scans without later stages, which end at 0.8: capture(answer_to) -> response, later stages of the test."""
    def scan(answer_to):
        import rospy
        from deformable_cobot.srv import ScanObject
        start('depth_threshold')
        start('view_capture', _use_tf='false')
        start('scan_server', _stop_when_confident='0.8', _stop_turn_min_rad='0.0', _answer_deadline_s='2.0')
        Camera(depth_image(), camera_info())
        stages = Stages(answer_to)
        wait_until(lambda: stages.answers.get_num_connections() > 0, 20, 'scan_server listening to the answers')
        rospy.wait_for_service('scan_object', 20)
        response = within(60, 'scan_object', lambda: rospy.ServiceProxy('scan_object', ScanObject)(0))
        return response, stages
    return scan


@pytest.mark.parametrize('first, views', [
    ({}, 1), ({'probability': 0.79}, 2), ({'known': False}, 2), ({'error': 'too few points'}, 2),
    ({'label': '', 'known': False, 'probability': 0.0}, 2),
], ids=['sure', 'unsure', 'unknown', 'no answer yet', 'empty hand'])
def test_only_a_sure_and_known_answer_ends_a_scan(capture, first, views):
    response, stages = capture(lambda view: answer(view, **(first if view.index == 0 else {})))
    assert (response.error, response.result.view_count) == ('', views)
    assert [end.index for end in stages.ends] == [views]


def test_no_running_answer_means_all_views(capture):
    response, stages = capture(lambda view: answer(view) if view.index + 1 == view.count else None)
    assert (response.error, response.result.view_count, stages.ends) == ('', VIEWS, [])


def test_a_lost_end_is_noticed(capture):
    response, stages = capture(lambda view: answer(view) if view.kind == view.VIEW else None)
    assert 'no answer within 2.0s' in response.error
    assert len(stages.ends) == 1


def test_a_stage_that_fails_ends_the_scan_at_once(capture):
    failure = {'error': 'roi_crop: broken', 'complete': True, 'view_count': 0}
    response, stages = capture(lambda view: answer(view, **failure))
    assert 'roi_crop: broken' in response.error
    assert {index for _, index in stages.heard} == {0}

"""Bags: a scan recorded by rosbag, and played to the graph without a robot."""

import pathlib

import pytest

from graph import Core, Graph, Listener
from processes import wait_until

pytestmark = [pytest.mark.built, pytest.mark.timeout(300)]

FINGERS = '/robot/end_effector/left_gripper/state'
TOPICS = ('/camera/depth/image_rect_raw', '/camera/depth/camera_info', '/tf', '/tf_static', '/robot/joint_states',
          FINGERS, '/views', '/registered', '/object', '/classification')


@pytest.fixture
def bag(shared_folder, tmp_path):
    """A scan of a dented cup by steps, recorded once for all tests; the clients are command-line tools."""
    return recording(shared_folder / 'scan.bag', tmp_path, 'scan_object', 'views: 3')


@pytest.fixture
def swept(shared_folder, tmp_path):
    """The same by a sweep."""
    return recording(shared_folder / 'sweep.bag', tmp_path, 'sweep_object', 'range: 1.2')


def recording(bag, folder, service, request):
    if not bag.exists():
        (folder / 'recording').mkdir()
        core = Core(folder / 'recording')
        try:
            record(core, bag, service, request)
        finally:
            core.stop()
    return bag


def record(core, bag, service, request):
    core.start()
    core.launch('sim.launch')
    wait_until(lambda: '/scan_object' in core.output('rosservice', 'list'), 60, 'scan_object', period_s=0.5)
    core.output('rosservice', 'call', '--wait', '/hold_object', '{object: large-cup, squeeze: 0.008, seed: 3}')
    partial = bag.with_suffix('.partial.bag')
    recorder = core.run('rosbag', 'record', '--output-name', partial, '__name:=recorder', *TOPICS)
    for topic in TOPICS:
        wait_until(lambda: '/recorder' in core.output('rostopic', 'info', topic), 30, f'rosbag recording {topic}')
    answer = core.output('rosservice', 'call', f'/{service}', request, timeout_s=60)
    assert 'label: "large-cup"' in answer
    # It is latched: who comes later than the recorder hears it later.
    core.output('rostopic', 'echo', '-n', '1', '/classification/header')
    recorder.stop()
    # rosbag's front end does not wait until the recorder has written all.
    wait_until(partial.exists, 30, 'the bag')
    partial.rename(bag)


def recorded(bag, topic):
    import rosbag
    return [message for _, message, _ in rosbag.Bag(str(bag)).read_messages(topic)]


def recorded_answer(bag):
    return recorded(bag, '/classification')[-1]


@pytest.mark.parametrize('rate', [1, 2])
def test_replay_gives_the_recorded_answer(bag, core, rate):
    from deformable_cobot.msg import Classification, ObjectCloud
    wanted, cut_then = recorded_answer(bag), recorded(bag, '/object')[-1]
    Graph(core, 'replay.launch', bag=bag, rate=rate, motion='steps')
    answers, objects = Listener('classification', Classification), Listener('object', ObjectCloud)
    answer = answers.next(timeout_s=90, accept=lambda answer: answer.complete)
    assert (answer.error, answer.label, answer.view_count) == ('', wanted.label, wanted.view_count)
    cut = objects.next(timeout_s=10, accept=lambda object: object.complete)
    # Other images of the same views. With the fingers anywhere in their stroke it would be a quarter more.
    assert cut.on_fingers == pytest.approx(cut_then.on_fingers, rel=0.1)
    assert 'sim_baxter' not in ''.join(core.nodes()), 'no robot is needed'


@pytest.fixture(params=['steps', 'sweep'])
def bag_by(request):
    """How the wrist turned, and the bag."""
    return request.param, request.getfixturevalue({'steps': 'bag', 'sweep': 'swept'}[request.param])


def test_a_bag_may_have_images_that_are_older_than_its_transforms(bag_by, core, tmp_path):
    """rosbag begins to record each topic at another time."""
    import rosbag
    import rospy
    from deformable_cobot.msg import Classification
    motion, bag = bag_by
    wanted, late = recorded_answer(bag), tmp_path / 'late.bag'
    if motion == 'steps':
        # TF begins while the wrist rests before the scan; the replay's first view would come from an earlier image.
        begin = recorded(bag, TOPICS[0])[0].header.stamp + rospy.Duration(0.3)
    else:
        begin = recorded(bag, '/views')[3].header.stamp
    with rosbag.Bag(str(late), 'w') as out:
        for topic, message, time in rosbag.Bag(str(bag)).read_messages():
            if topic != '/tf' or time > begin:
                out.write(topic, message, time)
    Graph(core, 'replay.launch', bag=late, motion=motion)
    answer = Listener('classification', Classification).next(timeout_s=90, accept=lambda answer: answer.complete)
    assert (answer.error, answer.label) == ('', wanted.label)
    if motion == 'steps':
        assert answer.view_count == wanted.view_count
    else:
        assert wanted.view_count - 8 < answer.view_count < wanted.view_count


def test_a_looping_bag_starts_afresh_each_time(bag, core):
    from deformable_cobot.msg import Classification, View
    wanted = recorded_answer(bag)
    Graph(core, 'replay.launch', bag=bag, loop='true', motion='steps')
    views, answers = Listener('views', View), Listener('classification', Classification)
    seen = {}
    while len(seen) < 3:
        answer = answers.next(timeout_s=90, accept=lambda answer: answer.complete)
        seen[answer.scan_id] = answer
    assert [(answer.error, answer.label) for answer in seen.values()] == [('', wanted.label)] * 3
    taken = [view for view in views.all() if view.scan_id in seen]
    for scan_id in seen:
        stamps = {view.index: view.header.stamp for view in taken if view.scan_id == scan_id}
        assert sorted(stamps) == list(range(wanted.view_count))
        assert sorted(stamps.values()) == [stamps[index] for index in sorted(stamps)]


def test_recorded_views_give_the_recorded_answers(bag, start, core, checkout):
    """The stages after view_capture alone, on what it and the gripper have said."""
    from deformable_cobot.msg import Classification, ObjectCloud
    start('icp_registration')
    start('roi_crop')
    start('classifier', _model=checkout / 'config/model.onnx')
    answers, objects = Listener('classification', Classification), Listener('object', ObjectCloud)
    core.run('rosbag', 'play', bag, '--quiet', '--delay', 3, '--topics', '/views', FINGERS)
    cut_then = {(object.view_count, object.complete): object for object in recorded(bag, '/object')}
    wanted = {(answer.view_count, answer.complete): answer for answer in recorded(bag, '/classification')}
    assert sorted(wanted) == [(1, False), (2, False), (3, True)]
    while wanted:
        answer, cut = answers.next(timeout_s=60), objects.next(timeout_s=60)
        of_views = (answer.view_count, answer.complete)
        then = wanted.pop(of_views, None)
        if then:
            assert (answer.error, answer.label) == ('', then.label)
            assert answer.header.stamp == then.header.stamp
            assert cut.cloud.data == cut_then[of_views].cloud.data, 'the same points, bit for bit'
            assert answer.probabilities == pytest.approx(then.probabilities, abs=1e-6)


def test_a_cloud_that_comes_late_meets_the_fingers_as_they_were(bag, start):
    """On a busy computer the gripper has long said something else when the cloud is there."""
    import copy
    import rospy
    from diagnostic_msgs.msg import DiagnosticArray
    from baxter_core_msgs.msg import EndEffectorState
    from deformable_cobot.msg import ObjectCloud, RegisteredCloud
    cloud = next(cloud for cloud in recorded(bag, '/registered') if cloud.complete)
    then = next(object for object in recorded(bag, '/object') if object.complete)
    held = next(state for state in recorded(bag, FINGERS) if state.timestamp >= cloud.header.stamp)
    opened = copy.deepcopy(held)
    opened.timestamp += rospy.Duration(3)
    opened.position = EndEffectorState.POSITION_OPEN
    start('roi_crop')
    fingers = rospy.Publisher(FINGERS, EndEffectorState, queue_size=1)
    clouds = rospy.Publisher('registered', RegisteredCloud, queue_size=1)
    objects, diagnostics = Listener('object', ObjectCloud), Listener('/diagnostics', DiagnosticArray)
    for publisher in (fingers, clouds):
        wait_until(lambda: publisher.get_num_connections() > 0, 20, f'roi_crop at {publisher.name}')
    for count, state in enumerate((held, opened), 1):
        fingers.publish(state)
        diagnostics.next(20, lambda array: any(value.key == FINGERS and value.value.startswith(f'{count} messages')
                                               for status in array.status for value in status.values))
    clouds.publish(cloud)
    object = objects.next(timeout_s=20)
    assert object.error == ''
    assert object.cloud.data == then.cloud.data, 'the same points, bit for bit'


def test_a_missing_bag_is_named(core):
    player = core.launch('replay.launch', bag=pathlib.Path('/nowhere.bag'))
    wait_until(lambda: '/nowhere.bag' in player.printed(), 30, 'message')


def test_a_bag_of_a_sweep_replays_to_the_same_answer(swept, core):
    from deformable_cobot.msg import Classification
    wanted = recorded_answer(swept)
    Graph(core, 'replay.launch', bag=swept, rate=2)
    answers = Listener('classification', Classification)
    answer = answers.next(timeout_s=90, accept=lambda answer: answer.complete)
    assert (answer.error, answer.label) == ('', wanted.label)
    # The recorded sweep began at rest and ended near rest; which images are views may differ by one at either end.
    assert abs(answer.view_count - wanted.view_count) <= 3

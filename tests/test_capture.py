"""Views without a scan: on request by capture_views, and in passive mode as somebody else turns the wrist."""

import shutil
import signal
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from graph import Listener
from processes import wait_until
from test_action import W2

pytestmark = [pytest.mark.built, pytest.mark.timeout(240)]


@pytest.fixture
def sim(launch, checkout, tmp_path):
    """Starts the simulated robot with settings of view_capture: sim(mode='passive', view_count=20) -> Graph."""
    def run(mode='active', **settings):
        config = tmp_path / 'config'
        shutil.copytree(checkout / 'config', config)
        with open(config / 'view_capture.yaml', 'a', encoding='utf-8') as file:
            file.writelines(f'{name}: {value}\n' for name, value in settings.items())
        # In the hand from the start: a passive run's first view may be of any rest.
        with open(config / 'sim_camera.yaml', 'a', encoding='utf-8') as file:
            file.write('object: medium-can\n')
        graph = launch('sim.launch', config=config, mode=mode)
        graph.wait_for_service('capture_views', timeout_s=60)
        return graph
    return run


def hears_points(graph, node):
    """Whether a node subscribes to `points`, by the master."""
    import rosgraph
    _, subscribers, _ = rosgraph.Master('/test').getSystemState()
    return any(f'/{node}' in nodes for topic, nodes in subscribers if topic == '/points')


def test_views_without_a_scan_need_no_later_stage_and_clouds_only_meanwhile(sim):
    from deformable_cobot.msg import View
    graph, views = sim(), Listener('views', View)
    for node in ('icp_registration', 'roi_crop', 'classifier', 'scan_server'):
        graph.core.output('rosnode', 'kill', node)
    assert not hears_points(graph, 'view_capture'), 'nobody has asked for a view'
    planned = graph.call('plan_views', views=2)
    assert planned.error == '' and len(planned.angles) == 2
    taken = graph.call('capture_views', timeout_s=30, views=2)
    assert taken.error == ''
    assert [view.wrist_angle for view in taken.views] == pytest.approx(planned.angles, abs=0.01)
    assert all(view.has_pose and view.cloud.width > 1000 and view.scan_id == '' for view in taken.views)
    [view] = graph.call('capture_views', timeout_s=30, angles=[0.5]).views
    assert view.wrist_angle == pytest.approx(0.5, abs=0.01)
    wait_until(lambda: not hears_points(graph, 'view_capture'), 10, 'the end of the subscription')
    assert views.all() == []
    for angles, words in (([9.0], '9 rad'), ([float('nan')], 'NaN rad'), ([0.0] * 65, '65 views')):
        assert words in graph.call('capture_views', angles=angles).error


def test_a_range_that_is_used_up_exactly_is_no_panic(sim):
    graph = sim(centre_angle_rad=-0.6, angle_min_rad=-1.7, angle_max_rad=0.4, view_step_rad=0.6)
    before = graph.core.process_of('view_capture')
    for views in (3, 5):
        response = graph.scan(views=views)
        assert (response.error, response.result.view_count) == ('', views)
    assert graph.core.process_of('view_capture') == before


def test_a_caller_that_dies_ends_the_motion(sim):
    graph, wrist = sim(), W2()
    caller = graph.core.run('rosservice', 'call', '/capture_views', '{views: 8}')
    wrist.wait_for_motion()
    caller.process.kill()
    wait_until(lambda: wrist.speed < 0.05, 1, 'rest')
    angle = wrist.angle
    # It is still at rest when the next caller is served.
    wait_until(lambda: graph.call('capture_views', timeout_s=30, angles=[angle]).error == '', 5, 'the next caller')
    assert wrist.angle == pytest.approx(angle, abs=0.01)


@pytest.mark.parametrize('entry', ['capture_views', 'scan_object', 'calibrate_camera_mount'])
def test_a_stop_between_two_turns_ends_the_whole(sim, entry):
    from deformable_cobot.msg import ScanObjectFeedback
    graph, wrist = sim(), W2()
    requests = {'capture_views': {'views': 4}, 'scan_object': {'views': 4},
                'calibrate_camera_mount': {'views': 4, 'add': False, 'write': False}}
    progress = Listener('progress', ScanObjectFeedback)
    with ThreadPoolExecutor() as pool:
        answer = pool.submit(graph.call, entry, timeout_s=30, **requests[entry])
        wrist.wait_for_motion()
        # No cloud comes any more, so that the arm rests and the view is waited for.
        graph.core.kill('depth_threshold', signal.SIGSTOP)
        try:
            wait_until(lambda: wrist.speed < 0.01 and not answer.done(), 5, 'rest')
            if entry == 'scan_object':
                progress.next(10, accept=lambda report: report.state == 'looking')
            time.sleep(0.5)  # the robot has been at rest for the time that arrival asks for
            angle = wrist.angle
            assert 'success: True' in graph.core.output('rosservice', 'call', '/stop_wrist', '{}')
            error = answer.result(2).error
        finally:
            graph.core.kill('depth_threshold', signal.SIGCONT)
    assert 'stop_wrist was called' in error, error
    time.sleep(0.5)  # as long as a next turn would need to be seen
    assert wrist.angle == pytest.approx(angle, abs=0.01)
    wait_until(lambda: graph.scan(2).error == '', 20, 'the next scan', period_s=0.5)


def test_passive_views_come_one_by_one_and_none_is_lost(sim):
    from deformable_cobot.msg import RegisteredCloud, View
    count = 20
    graph = sim(mode='passive', motion='steps', view_count=count, separation_rad=0.05)
    views, registered = Listener('views', View), Listener('registered', RegisteredCloud)
    heard, images = {}, Listener('/camera/depth/camera_info')
    for index in range(count):
        turned = graph.call('rotate_wrist', timeout_s=20, angle=-1.0 + 0.1 * index)
        assert turned.success, turned.error
        images.all()
        for _ in range(5):  # a rest must last until an image of it has come
            images.next()
        # A run counts from its third rest on.
        while index > 1 and len(heard) < index + 1:
            view = views.next()
            if view.kind == view.FAILED and 'turned back' in view.error:
                # The rest from which the wrist came to the first angle may count, too.
                heard.clear()
                continue
            assert (view.kind, view.error, view.count, view.has_pose) == (view.VIEW, '', count, True)
            heard.setdefault(view.index, view)
    assert sorted(heard) == list(range(count))
    assert len({view.scan_id for view in heard.values()}) == 1
    last = registered.next(timeout_s=30, accept=lambda message: message.complete)
    assert (last.error, last.view_count) == ('', count)


def test_a_passive_scan_that_turns_back_is_ended(sim):
    from deformable_cobot.msg import Classification
    graph, answers = sim(mode='passive', motion='steps', view_count=4), Listener('classification', Classification)
    refused = graph.scan()
    assert 'passive mode' in refused.error and '~mode to active' in refused.error
    images = Listener('/camera/depth/camera_info')
    for angle in (-2.0, -1.5, -1.0, -1.5, -2.0, -2.5):
        assert graph.call('rotate_wrist', timeout_s=20, angle=angle).success
        # A rest must last until an image of it has come.
        images.all()
        for _ in range(5):
            images.next()
    ended = answers.next(timeout_s=20, accept=lambda answer: answer.complete)
    assert 'the wrist turned back after 3 of 4 views' in ended.error
    whole = answers.next(timeout_s=20, accept=lambda answer: answer.complete and 'turned back' not in answer.error)
    assert (whole.error, whole.view_count) == ('', 4)

"""Scans in one sweep: views come while the wrist turns."""

import re
import shutil
import signal
import threading

import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from graph import Listener
from processes import wait_until
from test_action import W2, ended, make_client
from test_diagnostics import Diagnostics

pytestmark = [pytest.mark.built, pytest.mark.timeout(240)]

RANGE = 1.2


@pytest.fixture
def sim(launch, checkout, tmp_path):
    """Starts the simulated robot with settings of nodes: sim(view_capture={'motion': 'sweep'}) -> Graph."""
    def run(**settings):
        config = tmp_path / 'config'
        shutil.copytree(checkout / 'config', config)
        for node, values in settings.items():
            with open(config / f'{node}.yaml', 'a', encoding='utf-8') as file:
                file.writelines(f'{name}: {value}\n' for name, value in values.items())
        graph = launch('sim.launch', config=config)
        graph.wait_for_service('scan_object', timeout_s=60)
        graph.hold('small-cup')
        return graph
    return run


def watched():
    wrist = W2()
    wait_until(lambda: wrist.angle is not None, 10, 'joint states')
    return wrist


def sweep(graph, range=RANGE):
    return graph.call('sweep_object', timeout_s=60, range=range)


def gaps(angles):
    return [abs(after - before) for before, after in zip(angles, angles[1:])]


def test_views_come_while_the_wrist_turns_and_the_answer_is_about_all_of_them(sim):
    from deformable_cobot.msg import Classification, View
    graph, wrist = sim(), watched()
    views, answers = Listener('views', View), Listener('classification', Classification)
    for number in (1, 2):
        begin = wrist.angle
        response = sweep(graph)
        result = response.result
        assert (response.error, result.label, result.complete) == ('', 'small-cup', True)
        assert wrist.speed < 0.05, 'the arm rests at the answer'
        seen = {view.index: view for view in views.all() if view.scan_id == result.scan_id and view.kind == view.VIEW}
        assert sorted(seen) == list(range(result.view_count))
        assert result.view_count >= 8
        angles = [seen[index].wrist_angle for index in sorted(seen)]
        assert angles[0] == pytest.approx(begin, abs=0.05), 'the first view needs no motion'
        if number == 2:
            assert angles in (sorted(angles), sorted(angles, reverse=True)), 'one direction, from an end'
        assert max(angles) - min(angles) == pytest.approx(RANGE, abs=0.15)
        assert max(gaps(sorted(angles))) < 0.35, angles
        last = seen[result.view_count - 1]
        assert (last.count, last.has_pose) == (result.view_count, True)
        # Images of a wrist at speed, not of many short rests.
        stamps = [seen[index].header.stamp.to_sec() for index in sorted(seen)]
        assert stamps[-1] - stamps[0] < 2 * sum(gaps(angles))
        of_scan = [answer for answer in answers.all() if answer.scan_id == result.scan_id]
        assert len({answer.view_count for answer in of_scan}) >= 8, 'running answers'
        assert {answer.view_count for answer in of_scan if answer.complete} == {result.view_count}
        assert abs(wrist.angle - begin) > 0.5


@pytest.mark.parametrize('range, words', [(7.0, '0.05 to 6 rad'), (float('nan'), 'NaN'), (-1.0, '-1 rad')])
def test_ranges_that_the_wrist_does_not_have_are_refused_by_name(sim, range, words):
    graph, wrist = sim(), watched()
    angle = wrist.angle
    assert words in sweep(graph, range).error
    assert wrist.angle == pytest.approx(angle, abs=1e-3)


def test_a_rate_that_blurs_is_refused_before_anything_turns(sim):
    graph = sim(view_capture={'exposure_s': 0.06})
    error = sweep(graph).error
    assert 'moves by 3.1' in error and 'blur_max_m' in error and 'sweep_rate_rad_s' in error


def test_sweeps_tell_by_how_much_the_clocks_differ_and_are_refused_beyond_the_bound(sim):
    # Stamps are 30 ms late.
    graph = sim(sim_camera={'stamp_offset_s': 0.03}, view_capture={'time_offset_max_s': 0.02})
    diagnostics = Diagnostics()
    errors = (sweep(graph).error for _ in range(10))
    refused = next(error for error in errors if 'time_offset_max_s' in error)
    assert 'later than their stamps say' in refused
    told = diagnostics.wait('view_capture: time offset', DiagnosticStatus.WARN, 'later than their stamps say')
    offset_ms = float(re.search(r'taken (-?[\d.]+) ±', told.message).group(1))
    assert -45 < offset_ms < -20, told.message
    assert graph.scan(views=2).error == '', 'views at rest need no common clock'


def test_a_sweep_is_the_scan_of_who_asks_for_nothing_else(sim):
    graph = sim(view_capture={'view_spacing_rad': 0.3}, scan_server={'stop_when_confident': 0})
    assert graph.scan().result.view_count in (4, 5, 6)
    assert graph.scan(views=2).result.view_count == 2


def test_a_caller_that_dies_ends_the_sweep(sim):
    graph, wrist = sim(), watched()
    caller = graph.core.run('rosservice', 'call', '/sweep_object', '{range: 5.0}')
    wrist.wait_for_motion()
    caller.process.kill()
    wait_until(lambda: wrist.speed < 0.05, 1, 'rest')
    wait_until(lambda: 'already running' not in sweep(graph).error, 10, 'the next caller')


def test_a_stop_ends_the_sweep_by_name_and_the_next_scan_works(sim):
    graph, wrist = sim(), watched()
    errors = []
    scan = threading.Thread(target=lambda: errors.append(sweep(graph, 5.0).error))
    scan.start()
    wrist.wait_for_motion()
    stopped = graph.call('stop_wrist')
    assert stopped.success, stopped.message
    scan.join(10)
    assert 'stop_wrist was called' in errors[0]
    assert sweep(graph).error == ''


def sweeping(graph, wrist, range=5.0):
    """Begins a sweep; returns when the wrist turns. The error is the list's later only element."""
    errors = []
    scan = threading.Thread(target=lambda: errors.append(sweep(graph, range).error), daemon=True)
    scan.start()
    wrist.wait_for_motion()
    return errors


def test_an_emergency_stop_ends_the_sweep_and_nothing_moves_by_itself(sim):
    import rospy
    from std_msgs.msg import Bool, Empty
    graph, wrist = sim(), watched()
    button = rospy.Publisher('/sim_baxter/press_estop', Bool, queue_size=1, latch=True)
    reset = rospy.Publisher('/robot/set_super_reset', Empty, queue_size=1)
    enable = rospy.Publisher('/robot/set_super_enable', Bool, queue_size=1)
    errors = sweeping(graph, wrist)
    button.publish(True)
    wait_until(lambda: errors, 5, 'the answer')
    assert 'emergency stop (button pressed' in errors[0]
    assert wrist.speed < 0.05
    button.publish(False)
    wait_until(lambda: 'button released' in sweep(graph).error, 5, 'a released button')
    reset.publish()
    wait_until(lambda: 'not enabled' in sweep(graph).error, 5, 'a reset robot')
    enable.publish(True)
    wait_until(lambda: sweep(graph).error == '', 20, 'a sweep')


def test_a_cancelled_goal_ends_the_sweep(sim):
    from deformable_cobot.msg import ScanObjectGoal
    sim()
    client, wrist = make_client(), watched()
    for range, state, words in [(5.0, 'PREEMPTED', 'stopped on request'), (1.0, 'SUCCEEDED', '')]:
        client.send_goal(ScanObjectGoal(range=range))
        if words:
            wrist.wait_for_motion()
            client.cancel_goal()
        ended_as, result = ended(client)
        assert (ended_as, words in result.error) == (state, True), result.error
        assert wrist.speed < 0.05


def test_a_clock_that_jumps_ends_the_sweep_by_name(sim):
    """The robot's, as by a time server: the poses of the images then are those of another time."""
    import rospy
    from std_msgs.msg import Float64
    graph, wrist = sim(), watched()
    clock = rospy.Publisher('/sim_baxter/step_clock', Float64, queue_size=1, latch=True)
    for offset_s in (0.5, -0.5):
        errors = sweeping(graph, wrist)
        clock.publish(offset_s)
        wait_until(lambda: errors, 15, 'the answer')
        assert "the clock of left_w2's joint states was set" in errors[0], errors[0]
        assert wrist.speed < 0.05
        clock.publish(0.0)
        wait_until(lambda: sweep(graph).error == '', 30, 'a sweep')


def test_a_camera_that_dies_ends_the_sweep_and_the_wrist_rests(sim):
    graph, wrist = sim(), watched()
    errors = []
    scan = threading.Thread(target=lambda: errors.append(sweep(graph, 5.5).error))
    scan.start()
    wrist.wait_for_motion()
    graph.core.kill('depth_threshold', signal.SIGSTOP)
    try:
        scan.join(20)
        assert 'no cloud' in errors[0]
        assert wrist.speed < 0.05
    finally:
        graph.core.kill('depth_threshold', signal.SIGCONT)


def test_a_sure_answer_ends_the_sweep(sim):
    graph, wrist = sim(view_capture={'sweep_range_rad': 5.0}), watched()
    response = graph.scan()
    assert (response.error, response.result.label, response.result.complete) == ('', 'small-cup', True)
    assert response.result.view_count < 20
    assert wrist.speed < 0.05


def test_later_stages_that_are_slow_get_fewer_views_and_the_last_one(sim):
    """A stage that is stopped for a while: what it cannot take is left out, counted, and not kept for later."""
    from deformable_cobot.msg import ScanObjectFeedback, View
    graph, wrist = sim(scan_server={'answer_deadline_s': 30}), watched()
    views, progress = Listener('views', View), Listener('progress', ScanObjectFeedback)
    assert graph.call('rotate_wrist', timeout_s=20, angle=3.0).success, 'to an end of the range'
    responses = []
    scan = threading.Thread(target=lambda: responses.append(sweep(graph, 4.0)))
    scan.start()
    views.next(timeout_s=30)
    graph.core.kill('classifier', signal.SIGSTOP)
    try:
        wait_until(lambda: wrist.speed > 0.5, 10, 'the sweep')
        wait_until(lambda: wrist.speed < 0.05, 20, 'its end')
    finally:
        graph.core.kill('classifier', signal.SIGCONT)
    scan.join(40)
    [response] = responses
    assert (response.error, response.result.complete) == ('', True)
    left_out = max(report.left_out for report in progress.all())
    # Those before the stop, and a few that were under way.
    assert left_out > 15 and response.result.view_count < 25, (left_out, response.result.view_count)


def test_capture_views_gives_the_views_of_a_sweep_in_its_answer(sim):
    graph = sim()
    response = graph.call('capture_views', timeout_s=30, range=1.0)
    assert response.error == ''
    assert response.count == len(response.views) >= 8
    assert all(view.scan_id == '' and view.has_pose for view in response.views)
    assert response.views[-1].count == response.count

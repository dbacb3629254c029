"""Nodes whose places are all taken still answer: who is idle makes room."""

import statistics
import time

import pytest
import rospy
from std_srvs.srv import Trigger

from graph import Listener, within
from processes import wait_until
from tcpros import MuteCaller
from test_action import W2, ended, make_client, send

PLACES = 64


@pytest.fixture
def turn(start):
    """Turns the wrist of the simulated robot."""
    from deformable_cobot.srv import RotateWrist
    start('sim_baxter')
    start('wrist_rotator')
    for service in ('rotate_wrist', 'stop_wrist'):
        rospy.wait_for_service(service, 20)
    turn = rospy.ServiceProxy('rotate_wrist', RotateWrist)
    wait_until(lambda: turn(-2.9).success, 20, 'the first turn', period_s=0.5)
    return turn


def fill(service):
    """Takes all places: with callers that were answered and keep their connection, then with callers that say nothing."""
    idle = [rospy.ServiceProxy(service, Trigger, persistent=True) for _ in range(PLACES)]
    assert all(proxy().success for proxy in idle)
    yield idle
    yield [MuteCaller(f'/{service}', f'/mute_{number}') for number in range(2 * PLACES)]


def test_a_motion_is_stopped_though_all_places_are_taken(turn):
    for kept in fill('stop_wrist'):
        tooks = []
        for _ in range(11):
            begun = time.monotonic()
            assert within(5, 'stop_wrist', rospy.ServiceProxy('stop_wrist', Trigger)).success
            tooks.append(time.monotonic() - begun)
        print(f'at rest, answered after {statistics.median(tooks):.3f} s, at most {max(tooks):.3f} s')
        # The median, since the machine may be busy with something else now and then.
        assert statistics.median(tooks) < 0.1
        target = 2.9
        from concurrent.futures import ThreadPoolExecutor
        with ThreadPoolExecutor() as pool:
            turned = pool.submit(turn, target)
            time.sleep(1)  # it takes five
            assert within(5, 'stop_wrist', rospy.ServiceProxy('stop_wrist', Trigger)).success
            response = turned.result(5)
        assert not response.success and 'stop_wrist' in response.error, response
        assert response.angle < target - 1
        assert within(20, 'rotate_wrist', lambda: turn(-2.9)).success
        del kept


def test_a_goal_is_cancelled_though_all_places_are_taken(launch):
    from actionlib_msgs.msg import GoalStatus, GoalStatusArray
    from deformable_cobot.srv import PlanViews
    graph = launch('sim.launch')
    graph.wait_for_service('scan_object', timeout_s=60)
    graph.hold('medium-can')
    client, wrist, statuses = make_client(), W2(), Listener('scan_object/status', GoalStatusArray)
    idle = [rospy.ServiceProxy('plan_views', PlanViews, persistent=True) for _ in range(PLACES)]
    assert all(proxy(views=3).error == '' for proxy in idle)
    mute = [MuteCaller(f'/{service}', f'/mute_{number}') for number in range(2 * PLACES)
            for service in ('scan_object', 'capture_views', 'rotate_wrist')]
    tooks = []
    for _ in range(5):
        send(client, 8)
        wrist.wait_for_motion()
        statuses.all()
        begun = time.monotonic()
        client.cancel_goal()
        statuses.next(5, accept=lambda array: any(
            status.status in (GoalStatus.PREEMPTING, GoalStatus.PREEMPTED) for status in array.status_list[-1:]))
        tooks.append(time.monotonic() - begun)
        state, _ = ended(client, timeout_s=5)
        assert state == 'PREEMPTED'
    print(f'cancelled after {statistics.median(tooks):.3f} s, at most {max(tooks):.3f} s')
    assert statistics.median(tooks) < 0.1
    del idle, mute
    send(client, 2)
    state, result = ended(client)
    assert (state, result.error) == ('SUCCEEDED', '')

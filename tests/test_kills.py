"""kill -9 of each node: roslaunch starts it again, and the next scan succeeds."""

import pytest

from graph import Listener
from processes import wait_until

pytestmark = [pytest.mark.built, pytest.mark.timeout(600)]

NODES = ('camera_mount', 'wrist_rotator', 'depth_threshold', 'view_capture', 'scan_server', 'icp_registration', 'roi_crop', 'classifier',
         'sim_baxter', 'sim_camera', 'robot_state_publisher')
# What scan_object may take altogether; its parts have shorter deadlines.
SCAN_DEADLINE_S = 60


def kill_and_wait(core, node):
    killed = core.kill(node)
    wait_until(lambda: core.process_of(node) not in (None, killed), 20, f'roslaunch starting {node} again')


def succeed(sim, node):
    """The next scan succeeds; a node that was just started may need a moment, which the caller of a service sees."""
    if node == 'sim_camera':
        sim.hold('medium-can')
    sim.wait_for_service('scan_object')
    wait_until(lambda: sim.scan().error == '', SCAN_DEADLINE_S, f'a scan after {node} was killed', period_s=0.5)


def test_idle(sim):
    for node in NODES:
        kill_and_wait(sim.core, node)
        succeed(sim, node)


def test_during_a_scan(sim):
    import rospy
    from deformable_cobot.msg import View
    from concurrent.futures import ThreadPoolExecutor
    views = Listener('views', View)
    with ThreadPoolExecutor() as pool:
        for node in NODES:
            views.all()
            scan = pool.submit(sim.scan, views=3, timeout_s=SCAN_DEADLINE_S)
            views.next(timeout_s=20)
            kill_and_wait(sim.core, node)
            try:
                response = scan.result(SCAN_DEADLINE_S)
                assert response.error or response.result.view_count == 3, node
            except rospy.ServiceException:
                assert node == 'scan_server', f'{node}: the caller was left without an answer'
            succeed(sim, node)

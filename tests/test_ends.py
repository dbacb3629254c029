"""Each node told to end at random moments of a scan or a sweep: exit code 0, no motion after that, and the next scan is right.

DEFORMABLE_COBOT_MOMENTS says how many moments for each node; each is one of three ways to tell it.
"""

import os
import random
import re
import signal
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from processes import wait_until
from test_action import W2

pytestmark = [pytest.mark.built, pytest.mark.timeout(3600)]

MOMENTS = int(os.environ.get('DEFORMABLE_COBOT_MOMENTS', 1))
# Until when after the begin of a scan the node is told to end; a scan of five views takes about this.
SCAN_S = 4.0
# From the order to the exit, and for roslaunch to notice.
END_MAX_S = 3.0 + 1.0
# Motion is ordered through these; it must be over when one of them is.
MOVERS = ('scan_server', 'view_capture', 'wrist_rotator')
NODES = MOVERS + ('camera_mount', 'depth_threshold', 'icp_registration', 'roi_crop', 'classifier', 'deformation')


@pytest.fixture
def sim(sim):
    """As everywhere, and ready to calibrate."""
    sim.wait_for_service('calibrate_camera_mount', timeout_s=60)
    return sim


def exits(graph, node):
    """What roslaunch says of each end of the node's process."""
    return re.findall(rf'\[{node}-\d+\] process has (finished cleanly|died .*)', graph.roslaunch.printed())


def ask(graph, what):
    """The error of a scan or a calibration, or what the caller of a node sees that is gone."""
    import rospy
    try:
        if what == 'calibrate_camera_mount':
            return graph.call(what, timeout_s=90, views=4, add=False, write=False).error
        if what == 'sweep_object':
            return graph.call(what, timeout_s=60, range=4.0).error
        return graph.scan(5).error
    except (rospy.ServiceException, TimeoutError) as error:
        return str(error)


def tell(graph, node, way):
    if way == 'rosnode kill':
        graph.core.output('rosnode', 'kill', f'/{node}')
    else:
        graph.core.kill(node, getattr(signal, way))


def check_end(graph, node, draw):
    wrist, way, delay_s = W2(), draw.choice(('SIGINT', 'SIGTERM', 'rosnode kill')), draw.uniform(0, SCAN_S)
    asked = 'calibrate_camera_mount' if node == 'camera_mount' else draw.choice(('scan_object', 'sweep_object'))
    before = exits(graph, node)
    with ThreadPoolExecutor() as pool:
        answer = pool.submit(ask, graph, asked)
        time.sleep(delay_s)  # the moment is the point
        tell(graph, node, way)
        ended = wait_until(lambda: exits(graph, node)[len(before):], END_MAX_S, f'the end of {node}')
        left_at = wrist.angle
        if node in MOVERS or node == 'camera_mount':
            # As long as motion that goes on would need, and before roslaunch's respawn: then whoever still waits is served.
            time.sleep(0.5)
            assert abs(wrist.angle - left_at) < 0.01, f'{node}, {way} {delay_s:.2f} s after {asked} began: the arm moves on'
        error = answer.result(90)
    case = f'{node}, {way} {delay_s:.2f} s after {asked} began: {ended[0]}; the caller was told {error!r}'
    print(case)
    assert ended == ['finished cleanly'], case
    graph.wait_for_service(asked)

    def succeeds():
        response = graph.scan(3)
        return response.error == '' and response.result.label == 'medium-can'
    wait_until(succeeds, 60, f'a right scan after {case}', period_s=0.5)


@pytest.mark.parametrize('node', NODES)
def test_told_to_end(sim, node):
    seed = random.randrange(2**32)
    print('seed', seed)
    draw = random.Random(seed)
    for _ in range(MOMENTS):
        check_end(sim, node, draw)

"""What RViz is given to draw."""

import pytest

from graph import Listener
from processes import wait_until

pytestmark = [pytest.mark.built, pytest.mark.timeout(240)]

VIEWS = 3


class Board:
    """A topic's markers as RViz has them."""

    def __init__(self, topic):
        import rospy
        from visualization_msgs.msg import MarkerArray
        self.markers = {}
        self.seen = set()
        self.subscriber = rospy.Subscriber(topic, MarkerArray, self._draw)

    def _draw(self, message):
        for marker in message.markers:
            key = (marker.ns, marker.id)
            assert marker.header.frame_id, 'RViz would carry out a deletion without a frame before what came earlier'
            if marker.action == marker.DELETE:
                self.markers.pop(key, None)
            else:
                assert marker.pose.orientation.w == 1 and marker.color.a > 0
                self.markers[key] = marker
                self.seen.add(key)

    def wait_for(self, keys):
        wait_until(lambda: set(self.markers) == set(keys), 10, f'markers {keys}')
        return [self.markers[key] for key in keys]


def test_a_scan_is_drawn_and_the_next_one_wipes_it(sim, executable):
    from deformable_cobot.msg import ObjectCloud, RegisteredCloud
    from sensor_msgs.msg import PointCloud2
    from visualization_msgs.msg import Marker
    sim.core.run(executable('scan_markers'))
    clouds, words = Board('scan_markers/clouds'), Board('scan_markers/words')
    region, removed = Listener('object/region', Marker), Listener('object/removed', PointCloud2)
    registered, cut = Listener('registered', RegisteredCloud), Listener('object', ObjectCloud)
    wait_until(lambda: '/scan_markers' in sim.core.nodes(), 20, 'scan_markers at the master')
    wait_until(lambda: all(board.subscriber.get_num_connections() for board in (clouds, words)), 20, 'the boards')
    response = sim.scan(views=VIEWS)
    assert response.error == ''

    names = [('views', index) for index in range(VIEWS)]
    *views, whole = clouds.wait_for(names + [('registered', 0), ('views caption', 0), ('registered caption', 0)])[:4]
    assert len({(view.color.r, view.color.g, view.color.b) for view in views}) == VIEWS
    assert all(len(marker.points) > 500 and marker.header.frame_id == 'base' for marker in (*views, whole))
    # The views stand to the left of the hand, the registered cloud to its right.
    middle = [sorted(point.y for point in marker.points)[len(marker.points) // 2] for marker in (views[0], whole)]
    assert middle[0] == pytest.approx(0.26, abs=0.05) and middle[1] == pytest.approx(-0.26, abs=0.05)
    [answer] = words.wait_for([('answer', 0)])
    assert answer.text.startswith('medium-can') and answer.text.endswith('known')
    assert answer.header.frame_id == 'left_hand'
    assert {('progress', 0), ('progress', 1)} <= words.seen, 'while the wrist turned'

    cylinder = region.next()
    assert (cylinder.header.frame_id, cylinder.scale.x) == ('left_hand', pytest.approx(0.18))
    whole, kept = (listener.next(accept=lambda message: message.complete) for listener in (registered, cut))
    count = whole.cloud.width - kept.cloud.width
    assert count > 1000
    removed.next(accept=lambda cloud: cloud.width == count)

    assert sim.scan(views=1).error == ''
    clouds.wait_for([('views', 0), ('registered', 0), ('views caption', 0), ('registered caption', 0)])


def test_a_sweep_is_drawn_while_the_wrist_turns(sim, executable):
    sim.core.run(executable('scan_markers'))
    clouds, words = Board('scan_markers/clouds'), Board('scan_markers/words')
    wait_until(lambda: all(board.subscriber.get_num_connections() for board in (clouds, words)), 20, 'the boards')
    response = sim.call('sweep_object', timeout_s=60, range=1.2)
    assert response.error == ''
    drawn = [('views', index) for index in range(response.result.view_count)]
    assert len(drawn) >= 8
    wait_until(lambda: set(drawn) <= set(clouds.markers), 10, 'all views')
    [answer] = words.wait_for([('answer', 0)])
    assert answer.text.startswith(response.result.label)
    assert ('progress', 0) in words.seen, 'while the wrist turned'

"""TF that is missing, stale or of another time: the scan ends with an error that says which, and the next one works."""

import copy
import re
import threading

import pytest

from camera import FRAME, Camera, camera_info, depth_image
from processes import wait_until

pytestmark = [pytest.mark.built, pytest.mark.timeout(180)]


class Transforms:
    """Publishes the hand and an upright base in the camera's frame at 50 Hz, `age_s` late, until closed."""

    def __init__(self, age_s=0.0):
        import rospy
        from tf2_msgs.msg import TFMessage
        self.publisher = rospy.Publisher('/tf', TFMessage, queue_size=10)
        self.age_s = age_s
        self.closed = threading.Event()
        self.thread = threading.Thread(target=self._publish, daemon=True)
        self.thread.start()

    def _publish(self):
        import rospy
        from geometry_msgs.msg import TransformStamped
        from tf2_msgs.msg import TFMessage
        while not self.closed.wait(0.02):
            hand = TransformStamped(child_frame_id='left_hand')
            hand.header.frame_id = FRAME
            hand.header.stamp = rospy.Time.now() - rospy.Duration(self.age_s)
            hand.transform.translation.z = 0.4
            # Up in the image is -y of the camera; the hand's z points there.
            hand.transform.rotation.x, hand.transform.rotation.w = 0.7071, 0.7071
            base = copy.deepcopy(hand)
            base.child_frame_id = 'base'
            self.publisher.publish(TFMessage([hand, base]))

    def close(self):
        self.closed.set()
        self.thread.join()
        self.publisher.unregister()


@pytest.fixture
def graph(launch):
    graph = launch('graph.launch', mount='false', rotator='false')
    Camera(depth_image(), camera_info())
    graph.wait_for_service('scan_object')
    return graph


def test_missing_tf_is_named(graph):
    error = graph.scan(views=1).error
    assert "TF has no frame 'base'" in error and 'robot_state_publisher' in error
    Transforms()
    # What comes after view_capture is another matter: a flat patch is no object.
    wait_until(lambda: 'TF' not in graph.scan(views=1).error, 20, 'a scan with TF')


def test_stale_tf_is_named_with_its_age(graph):
    stale = Transforms(age_s=30.0)
    error = graph.scan(views=1).error
    # It was waited for, for a second.
    assert re.search(r"TF of 'base' ends 2[89]\.", error) and 'is it still published?' in error, error
    stale.close()


def test_tf_ahead_of_the_camera_is_named(graph):
    """A computer whose clock is ahead: TF begins after the image was taken."""
    ahead = Transforms(age_s=-30.0)
    error = graph.scan(views=1).error
    assert "TF of 'base' begins" in error and 'clocks' in error, error
    ahead.close()

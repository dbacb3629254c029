"""A depth camera made by a test: it shows what the test says, and stands in for the wrist as well."""

import array
import threading

WIDTH, HEIGHT = 848, 480
FRAME = 'camera_depth_optical_frame'


def depth_image(encoding='16UC1', depth_m=0.4, step=None):
    """A patch as large as an object, bent like a can, before nothing."""
    from sensor_msgs.msg import Image
    type_code, of_metre = {'16UC1': ('H', 1000), '32FC1': ('f', 1.0), '8UC1': ('B', 255)}[encoding]
    number = int if type_code != 'f' else float
    rows = array.array(type_code, bytes(WIDTH * HEIGHT * array.array(type_code).itemsize))
    for row in range(180, 300):
        for column in range(390, 460):
            bend_m = 0.03 * ((column - 425) / 35) ** 2
            rows[row * WIDTH + column] = number((depth_m + bend_m) * of_metre)
    image = Image(width=WIDTH, height=HEIGHT, encoding=encoding, data=rows.tobytes())
    image.step = WIDTH * rows.itemsize if step is None else step
    return image


def camera_info():
    from sensor_msgs.msg import CameraInfo
    return CameraInfo(width=WIDTH, height=HEIGHT, distortion_model='plumb_bob', D=[0.0] * 5,
                      K=[418.3, 0, 424.2, 0, 418.3, 238.2, 0, 0, 1], R=[1, 0, 0, 0, 1, 0, 0, 0, 1],
                      P=[418.3, 0, 424.2, 0, 0, 418.3, 238.2, 0, 0, 0, 1, 0])


class Camera:
    """Publishes an image at 10 Hz, and answers `rotate_wrist`, from a thread until closed."""

    def __init__(self, image, info):
        import rospy
        from deformable_cobot.srv import RotateWrist, RotateWristResponse
        from sensor_msgs.msg import CameraInfo, Image
        self.messages = [
            (rospy.Publisher('camera/depth/image_rect_raw', Image, queue_size=1), image),
            (rospy.Publisher('camera/depth/camera_info', CameraInfo, queue_size=1), info),
        ]
        self.closed = threading.Event()
        self.service = rospy.Service('rotate_wrist', RotateWrist, lambda request: RotateWristResponse(
            success=True, angle=request.angle, at_rest=rospy.Time.now()))
        threading.Thread(target=self._show, daemon=True).start()

    def _show(self):
        import rospy
        while not self.closed.wait(0.1):
            stamp = rospy.Time.now()
            for publisher, message in self.messages:
                if message is not None:
                    message.header.stamp, message.header.frame_id = stamp, FRAME
                    publisher.publish(message)

    def close(self):
        self.closed.set()
        self.service.shutdown()

"""Depth images as cameras, drivers and bags publish them, and the points that become of them."""

import struct
import threading
import zlib

import pytest
from sensor_msgs.msg import CompressedImage, PointCloud2

from camera import HEIGHT, WIDTH, camera_info, depth_image
from graph import Listener
from processes import wait_until

pytestmark = pytest.mark.built

TOPICS = {'plain': 'camera/depth/image_rect_raw', 'packed': 'camera/depth/image_rect_raw/compressedDepth',
          'aligned': 'camera/aligned_depth_to_color/image_raw', 'info': 'camera/depth/camera_info'}


def words(image):
    return struct.unpack(f'<{WIDTH * HEIGHT}H', image.data)


def as_png(image):
    """What compressed_depth_image_transport makes of an image: a head of its own, then PNG of 16 bits."""
    def chunk(kind, data):
        return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))
    pixels = struct.pack(f'>{WIDTH * HEIGHT}H', *words(image))
    rows = b''.join(b'\0' + pixels[2 * WIDTH * row:][:2 * WIDTH] for row in range(HEIGHT))
    return (bytes(12) + b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', WIDTH, HEIGHT, 16, 0, 0, 0, 0))
            + chunk(b'IDAT', zlib.compress(rows)) + chunk(b'IEND', b''))


def as_rvl(image):
    """The same by RVL, which it does if asked to."""
    nibbles, depths, at, before = [], words(image), 0, 0

    def number(value):
        while value > 7:
            nibbles.append(value & 7 | 8)
            value >>= 3
        nibbles.append(value)
    while at < len(depths):
        for is_zero in (True, False):
            end = at
            while end < len(depths) and (depths[end] == 0) == is_zero:
                end += 1
            number(end - at)
            for depth in depths[at:end] if not is_zero else ():
                number((depth - before) << 1 if depth >= before else ((before - depth) << 1) - 1)
                before = depth
            at = end
    nibbles += [0] * (-len(nibbles) % 8)
    packed = (int(''.join(f'{nibble:x}' for nibble in nibbles[start:start + 8]), 16) for start in range(0, len(nibbles), 8))
    return bytes(12) + struct.pack('<2I', WIDTH, HEIGHT) + b''.join(struct.pack('<I', word) for word in packed)


class Show:
    """Publishes a message on each topic at 10 Hz until the end of the block."""

    def __init__(self, frame='camera_depth_optical_frame', **messages):
        import rospy
        self.frame = frame
        self.messages = [(rospy.Publisher(TOPICS[name], type(message), queue_size=1), message)
                         for name, message in messages.items()]
        self.closed = threading.Event()
        self.thread = threading.Thread(target=self._show, daemon=True)

    def _show(self):
        import rospy
        while not self.closed.wait(0.1):
            for publisher, message in self.messages:
                message.header.stamp, message.header.frame_id = rospy.Time.now(), self.frame
                publisher.publish(message)

    def __enter__(self):
        self.thread.start()

    def __exit__(self, *_):
        self.closed.set()
        self.thread.join()
        for publisher, _ in self.messages:
            publisher.unregister()


def cloud(accept=lambda cloud: True):
    return Listener('points', PointCloud2).next(timeout_s=30, accept=accept)


@pytest.fixture
def wanted(start):
    """The points of the plain image, and a running depth_threshold without a camera."""
    start('depth_threshold')
    with Show(plain=depth_image(), info=camera_info()):
        return cloud().data


@pytest.mark.parametrize('change', [dict(encoding='mono16'), dict(is_bigendian=1)], ids=str)
def test_whole_millimetres_have_several_names(wanted, change):
    image = depth_image()
    if 'is_bigendian' in change:
        image.data = struct.pack(f'>{WIDTH * HEIGHT}H', *words(image))
    for name, value in change.items():
        setattr(image, name, value)
    with Show('/camera_depth_optical_frame', plain=image, info=camera_info()):
        found = cloud()
    assert found.data == wanted and found.width > 1000


@pytest.mark.parametrize('pack, kind', [(as_png, 'compressedDepth'), (as_png, 'compressedDepth png'), (as_rvl, 'compressedDepth rvl')])
def test_packed_images_are_read_where_there_are_no_others(wanted, pack, kind):
    packed = CompressedImage(format=f'16UC1; {kind}', data=pack(depth_image()))
    with Show(packed=packed, info=camera_info()):
        assert cloud().data == wanted
    # The camera comes back: the plain ones are taken again.
    with Show(plain=depth_image(depth_m=0.5), info=camera_info()):
        cloud(lambda cloud: cloud.data != wanted)


def test_distortion_is_refused_by_name(start):
    node = start('depth_threshold', **{TOPICS['plain']: TOPICS['aligned']})
    info = camera_info()
    info.D = [0.1, -0.2, 0, 0, 0]
    listener = Listener('points', PointCloud2)
    with Show(aligned=depth_image(), info=info):
        wait_until(lambda: 'distortion [0.1, -0.2' in node.printed(), 20, 'the distortion by name')
    assert f'/{TOPICS["aligned"]} is not rectified' in node.printed()
    assert listener.messages.empty()

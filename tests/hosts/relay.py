"""A bad cable between two hosts: passes on what comes, late, and not all.

usage: relay.py PID_A NAME_A PID_B NAME_B    makes the device NAME in the network of each process, and joins the two
Each line of its input sets the share of frames that is lost and the delay of the others: LOSS DELAY_S
"""

import ctypes
import fcntl
import heapq
import itertools
import os
import random
import select
import struct
import sys
import threading
import time

CLONE_NEWNET = 0x40000000
TUNSETIFF = 0x400454ca
IFF_TAP_WITHOUT_HEADER = 0x0002 | 0x1000
FRAME_BYTES_MAX = 65536


def join_network(pid):
    """Moves this thread, and those that it starts, to the network of a process."""
    with open(f'/proc/{pid}/ns/net', 'rb') as network:
        if ctypes.CDLL(None, use_errno=True).setns(network.fileno(), CLONE_NEWNET) != 0:
            raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))


def open_tap(pid, name):
    """A device in the network of a process, as a file of frames."""
    opened = []

    def work():
        # The network is that of a thread.
        join_network(pid)
        tap = os.open('/dev/net/tun', os.O_RDWR | os.O_NONBLOCK)
        fcntl.ioctl(tap, TUNSETIFF, struct.pack('16sH14x', name.encode(), IFF_TAP_WITHOUT_HEADER))
        opened.append(tap)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    return opened[0]


def pump(taps, commands, draw):
    """Passes frames between the devices until `commands` end."""
    loss, delay_s = 0.0, 0.0
    late, number = [], itertools.count()
    while True:
        patience_s = max(0.0, late[0][0] - time.monotonic()) if late else None
        ready, _, _ = select.select([*taps, commands], [], [], patience_s)
        if commands in ready:
            line = commands.readline()
            if not line:
                return
            loss, delay_s = map(float, line.split())
        for tap in set(ready) & set(taps):
            frame = os.read(tap, FRAME_BYTES_MAX)
            if draw() >= loss:
                other = taps[1 - taps.index(tap)]
                heapq.heappush(late, (time.monotonic() + delay_s, next(number), other, frame))
        while late and late[0][0] <= time.monotonic():
            _, _, tap, frame = heapq.heappop(late)
            try:
                os.write(tap, frame)
            except OSError:  # the device is down, or its queue is full: the frame is lost
                pass


if __name__ == '__main__':
    pid_a, name_a, pid_b, name_b = sys.argv[1:]
    taps = [open_tap(int(pid_a), name_a), open_tap(int(pid_b), name_b)]
    seed = random.randrange(2**32)
    print(f'seed {seed}', flush=True)
    pump(taps, sys.stdin, random.Random(seed).random)

"""A hostile computer: connects to every port of the graph and misbehaves, until it is ended.

usage: stranger.py OWN_ADDRESS
"""

import pathlib
import random
import socket
import struct
import sys
import time
import xmlrpc.client

import rosgraph
from sensor_msgs.msg import JointState

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

from tcpros import BrokenPublisher  # noqa: E402

NAME = '/stranger'
TOPIC = '/robot/joint_states'
FOUR_GIB = struct.pack('<I', 2**32 - 1)


def ports(master):
    """Host and port of all topics, services and nodes, but those of roscore and the robot's C++ node."""
    publishers, _, services = master.getSystemState()
    nodes = {node for _, names in publishers for node in names} - {'/rosout', '/robot_state_publisher'}
    uris = {node: master.lookupNode(node) for node in nodes}
    for uri in uris.values():
        yield authority(uri)
    for topic, names in publishers:
        for node in set(names) & nodes:
            _, _, protocol = xmlrpc.client.ServerProxy(uris[node]).requestTopic(NAME, topic, [['TCPROS']])
            if protocol:
                yield protocol[1], protocol[2]
    for service, names in services:
        if set(names) & nodes and 'logger' not in service:
            yield authority(master.lookupService(service))


def authority(uri):
    host, port = uri.split('://')[1].strip('/').split(':')
    return host, int(port)


def main():
    seed = random.randrange(2**32)
    print('seed', seed, flush=True)
    draw = random.Random(seed)
    master = rosgraph.Master(NAME)
    held = []
    for end in set(ports(master)):
        for greeting in (b'', draw.randbytes(64), FOUR_GIB + draw.randbytes(4096)):
            connection = socket.create_connection(end, timeout=5)
            connection.sendall(greeting)
            held.append(connection)
    print(len(held), 'connections', flush=True)
    loud = BrokenPublisher(TOPIC, JointState, '/loud_stranger', sys.argv[1])
    mute = BrokenPublisher(TOPIC, JointState, '/mute_stranger', sys.argv[1], mute=True)
    while not (loud.connections and mute.connections):
        time.sleep(0.1)
    print('all is done', flush=True)
    while True:
        for connection in loud.connections:
            try:
                connection.sendall(FOUR_GIB + draw.randbytes(4096))
            except OSError:
                loud.connections.remove(connection)
        time.sleep(1)


if __name__ == '__main__':
    main()

"""Peers that speak the ROS wire protocols badly on purpose: what rospy would never do, the tests need."""

import socket
import struct
import threading
import xmlrpc.client
import xmlrpc.server

import rosgraph


def frame(payload):
    """A payload with its length, as it is sent."""
    return struct.pack('<I', len(payload)) + payload


def header(**fields):
    """A connection header."""
    return frame(b''.join(frame(f'{name}={value}'.encode()) for name, value in fields.items()))


def read_frame(connection):
    """The next length-prefixed block."""
    def exactly(count):
        data = b''
        while len(data) < count:
            piece = connection.recv(count - len(data))
            if not piece:
                raise ConnectionError('closed')
            data += piece
        return data
    return exactly(struct.unpack('<I', exactly(4))[0])


class BrokenPublisher:
    """Publishes whatever bytes it is told to, and drops links without a word to the master; `mute`: answers nobody."""

    def __init__(self, topic, kind, name='/broken_publisher', host='127.0.0.1', mute=False):
        self.topic, self.kind, self.name, self.mute = topic, kind, name, mute
        self.connections = []
        self.dialled = 0
        self.listener = socket.create_server((host, 0))
        self.api = xmlrpc.server.SimpleXMLRPCServer((host, 0), logRequests=False, allow_none=True)
        port = self.listener.getsockname()[1]
        self.api.register_function(lambda *_: (1, '', ['TCPROS', host, port]), 'requestTopic')
        self.api.register_function(lambda *_: (1, '', 1), 'getPid')
        self.uri = f'http://{host}:{self.api.server_address[1]}/'
        for work in (self.api.serve_forever, self._accept):
            threading.Thread(target=work, daemon=True).start()
        rosgraph.Master(name).registerPublisher(topic, kind._type, self.uri)

    def _accept(self):
        while True:
            connection, _ = self.listener.accept()
            if self.mute:
                self.connections.append(connection)
                continue
            try:
                read_frame(connection)
                connection.sendall(header(callerid=self.name, md5sum=self.kind._md5sum, type=self.kind._type,
                                          topic=self.topic, message_definition='', latching='0'))
            except (ConnectionError, OSError):
                continue
            self.dialled += 1
            self.connections.append(connection)

    def send(self, payload):
        """Sends one message of these bytes to all who listen."""
        for connection in self.connections:
            connection.sendall(frame(payload))

    def send_message(self, message):
        """Sends a well-formed message."""
        import io
        data = io.BytesIO()
        message.serialize(data)
        self.send(data.getvalue())

    def cut(self):
        """Closes all links; the master is told nothing."""
        for connection in self.connections:
            connection.shutdown(socket.SHUT_RDWR)
            connection.close()
        self.connections = []


class MuteService:
    """Offers a service, takes connections and never answers."""

    def __init__(self, name):
        self.listener = socket.create_server(('127.0.0.1', 0))
        self.connections = []
        threading.Thread(target=self._accept, daemon=True).start()
        uri = f'rosrpc://127.0.0.1:{self.listener.getsockname()[1]}'
        rosgraph.Master('/mute_service').registerService(name, uri, 'http://127.0.0.1:1/')

    def _accept(self):
        while True:
            connection, _ = self.listener.accept()
            self.connections.append(connection)
            threading.Thread(target=self._shake_hands, args=(connection,), daemon=True).start()

    @staticmethod
    def _shake_hands(connection):
        # A probe is answered, so that the caller takes the service for a living one; then silence.
        read_frame(connection)
        connection.sendall(header(callerid='/mute_service', md5sum='*', type='*'))


class StalledSubscriber:
    """Subscribes to a topic of one node and never reads a message."""

    def __init__(self, topic, kind, publisher, name='/stalled_subscriber'):
        uri = rosgraph.Master(name).lookupNode(publisher)
        _, _, (_, host, port) = xmlrpc.client.ServerProxy(uri).requestTopic(name, topic, [['TCPROS']])
        self.connection = socket.socket()
        # As little room as the system allows, so that it is soon full.
        self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)
        self.connection.connect((host, port))
        self.connection.sendall(header(callerid=name, topic=topic, type=kind._type, md5sum=kind._md5sum,
                                       message_definition=kind._full_text, tcp_nodelay='1'))
        read_frame(self.connection)


class MuteCaller:
    """Connects to a service and says nothing."""

    def __init__(self, service, name='/mute_caller'):
        host, port = rosgraph.Master(name).lookupService(service).split('//')[1].rstrip('/').split(':')
        self.connection = socket.create_connection((host, int(port)))

"""A ROS graph on a master of its own: roscore, roslaunch, and calls with deadlines. Used by the tests and the demo."""

import os
import queue
import signal
import subprocess
import threading

from processes import MARK, Program, free_port, kill_marked, marked_processes, wait_until

OBJECTS = ('medium-can', 'food-can', 'small-cup', 'medium-cup', 'large-cup', 'tiny-ball', 'small-ball', 'medium-ball')


# The folder in which the simulated robot records what it was told and did.
RECORD = 'DEFORMABLE_COBOT_RECORD'


class Core:
    """roscore on a free port, with logs in `folder`. Programs that it starts see only this master."""

    def __init__(self, folder):
        self.folder = folder
        self.mark = f'{os.environ.get(MARK, "")}{folder}'
        self.programs = []
        # Words of violations of the contract of motion that a test brings about by itself.
        self.excused = []
        port = free_port()
        self.environment = {
            **os.environ,
            MARK: self.mark,
            'ROS_MASTER_URI': f'http://127.0.0.1:{port}',
            'ROS_IP': '127.0.0.1',
            'ROS_HOME': str(folder),
            'ROS_LOG_DIR': str(folder / 'log'),
            'PYTHONUNBUFFERED': '1',
            RECORD: str(folder / 'record'),
        }
        self.environment.pop('ROS_HOSTNAME', None)
        self.environment.pop('ROS_NAMESPACE', None)
        self.port = port
        self.roscore = None

    def start(self):
        """Starts roscore, again after a stop, and waits until the master answers."""
        import rosgraph
        self.roscore = self.run('roscore', '-p', self.port)
        os.environ.update(self.environment)
        os.environ.pop('ROS_HOSTNAME', None)
        wait_until(lambda: rosgraph.is_master_online() or self._check_roscore(), 30, 'roscore')
        wait_until(lambda: '/rosout' in self.nodes(), 30, 'rosout')

    def _check_roscore(self):
        if not self.roscore.running():
            raise RuntimeError(f'roscore ended:\n{self.roscore.printed()}')

    def run(self, *command, stdin=subprocess.DEVNULL, **variables):
        """Starts a program on this master; `variables` are added to its environment."""
        log = self.folder / f'{len(self.programs)}-{os.path.basename(str(command[0]))}.log'
        program = Program(command, {**self.environment, **variables}, log, stdin)
        self.programs.append(program)
        return program

    def launch(self, file, **arguments):
        """Starts one of the package's launch files; returns the program."""
        words = [f'{name}:={value}' for name, value in arguments.items()]
        return self.run('roslaunch', '--sigint-timeout', 5, '--sigterm-timeout', 2, 'deformable_cobot', file, *words)

    def output(self, *command, timeout_s=30):
        """Runs a command-line tool to its end; returns what it printed. Fails if the tool does."""
        program = self.run(*command)
        code = program.wait(timeout_s)
        if code != 0:
            raise RuntimeError(f'{" ".join(program.command)} ended with {code}:\n{program.printed()}')
        return program.printed()

    def nodes(self):
        """Names of the nodes that the master knows."""
        import rosnode
        try:
            return rosnode.get_node_names()
        except (rosnode.ROSNodeIOException, OSError):
            return []

    def process_of(self, node):
        """Process id of a node that roslaunch started; None if it does not run."""
        word = f'__name:={node}'
        return next((pid for pid, words in marked_processes(self.mark).items() if word in words), None)

    def kill(self, node, number=signal.SIGKILL):
        """Sends a signal to a node; returns the id that its process had."""
        if number in (signal.SIGKILL, signal.SIGSTOP):
            self.excused.append('ends at speed')
        if node == 'sim_baxter' and number == signal.SIGSTOP:
            # It hears what it was told meanwhile when it goes on, just before what it is told then.
            self.excused.append('is not smooth')
        pid = self.process_of(node)
        os.kill(pid, number)
        return pid

    def violations(self):
        """What the commander of the simulated robot has done against the contract of motion (sim/baxter/src/contract.rs)."""
        return [line for file in sorted(self.folder.glob('record/*.violations')) for line in file.read_text().splitlines()
                if not any(words in line for words in self.excused)]

    def motion_of(self, arm='left'):
        """What the W2 of an arm was told and did: rows of time (s since the epoch), setpoint (rad or None), angle, velocity."""
        rows = [line.split(',') for file in sorted(self.folder.glob('record/*.csv'))
                for line in file.read_text().splitlines()[1:] if line.count(',') == 4]
        return [(float(time_s), float(setpoint) if setpoint else None, float(angle), float(velocity))
                for time_s, of, setpoint, angle, velocity in rows if of == arm]

    def stop(self):
        """Ends all that runs on this master, the latest first."""
        for program in reversed(self.programs):
            program.stop()
        kill_marked(self.mark)


def within(timeout_s, what, work):
    """The result of `work()`, done on another thread; fails when it takes longer."""
    outcome = queue.Queue()

    def do():
        try:
            outcome.put((work(), None))
        except Exception as error:  # handed to the caller below
            outcome.put((None, error))

    threading.Thread(target=do, daemon=True).start()
    try:
        value, error = outcome.get(timeout=timeout_s)
    except queue.Empty:
        raise TimeoutError(f'{what}: no answer within {timeout_s} s') from None
    if error is not None:
        raise error
    return value


class Graph:
    """The launched graph seen by a client: a rospy node of this process."""

    def __init__(self, core, file, **arguments):
        import rospy
        self.core = core
        self.roslaunch = core.launch(file, **arguments)
        # rospy keeps Ctrl-C to itself unless told not to.
        rospy.init_node('client', anonymous=True, disable_signals=True)

    def call(self, service, timeout_s=10, **fields):
        """Calls a service of the graph, waiting for it to appear first; `timeout_s` is for each."""
        import rospy
        self.wait_for_service(service, timeout_s)
        import rosservice
        kind = within(timeout_s, service, lambda: rosservice.get_service_class_by_name(rospy.resolve_name(service)))
        return within(timeout_s, service, lambda: rospy.ServiceProxy(service, kind)(**fields))

    def wait_for_service(self, service, timeout_s=30):
        """Waits until somebody answers at the service."""
        import rospy

        def offered():
            if not self.roslaunch.running():
                raise RuntimeError(f'roslaunch ended:\n{self.roslaunch.printed()}')
            try:
                rospy.wait_for_service(service, timeout=1)
            except rospy.ROSException:
                return False
            return True

        wait_until(offered, timeout_s, f'service {service}')

    def hold(self, name, squeeze_m=0.008, seed=1):
        """Puts an object into the simulated hand."""
        response = self.call('hold_object', object=name, squeeze=squeeze_m, seed=seed)
        if not response.success:
            raise RuntimeError(f'hold_object {name}: {response.error}')

    def scan(self, views=0, timeout_s=60):
        """Scans what the hand holds; returns the response."""
        return self.call('scan_object', timeout_s=timeout_s, views=views)


class Listener:
    """Collects what is published on a topic, each message with the time of its arrival where `clock` is given."""

    def __init__(self, topic, kind=None, clock=None):
        import rospy
        self.topic = topic
        self.messages = queue.Queue()
        self.clock = clock
        self.subscriber = rospy.Subscriber(topic, kind or rospy.AnyMsg, self._take)

    def _take(self, message):
        self.messages.put((self.clock(), message) if self.clock else message)

    def next(self, timeout_s=10, accept=lambda message: True):
        """The next message that is accepted; the others are dropped."""
        found = []

        def arrived():
            try:
                message = self.messages.get(timeout=0.2)
            except queue.Empty:
                return False
            if accept(message):
                found.append(message)
            return bool(found)

        wait_until(arrived, timeout_s, f'topic {self.topic}', period_s=0)
        return found[0]

    def all(self):
        """What has arrived and was not taken yet."""
        taken = []
        while not self.messages.empty():
            taken.append(self.messages.get())
        return taken

    def close(self):
        self.subscriber.unregister()

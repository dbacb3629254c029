"""A robot and three computers on this machine: each a network of its own, joined by a switch, with sshd and clock.

A host is a process that waits for the end of its input; all that belongs to it (its other processes, its network, its mounts)
ends with it, and it ends with the test, even if that is killed. Nothing of it has a name outside.
"""

import os
import pathlib
import shutil
import subprocess
import sys

from graph import Core
from processes import MARK, Program, kill_marked, marked_processes, wait_until
from relay import join_network

ROBOT, ARM, GRIPPER, MAIN = 'robot', 'arm', 'gripper', 'main'
ADDRESSES = {ROBOT: '10.0.0.1', ARM: '10.0.0.2', GRIPPER: '10.0.0.3', MAIN: '10.0.0.4'}
MASTER_PORT = 11311
# Of a motion in which setpoints suddenly failed to arrive (sim/baxter/src/contract.rs).
CUT = 'ends at speed'
NEEDED = ('unshare', 'nsenter', 'ip', 'sshd', 'ssh-keygen')

SSHD_CONFIG = '''\
ListenAddress {address}
HostKey {folder}/host_key
AuthorizedKeysFile {home}/.ssh/id_ed25519.pub
PasswordAuthentication no
KbdInteractiveAuthentication no
PermitRootLogin prohibit-password
StrictModes no
UsePAM no
PidFile none
SetEnv {variables}
'''


def missing():
    """Why this machine cannot be several hosts; empty if it can."""
    lacking = [name for name in NEEDED if not shutil.which(name, path=f'{os.environ["PATH"]}:/usr/sbin:/sbin')]
    if lacking:
        return f'{", ".join(lacking)} not found; make test-hosts installs what is missing'
    if os.geteuid() != 0:
        return 'network namespaces need root'
    # The cables between the hosts are TAP devices.
    tried = subprocess.run(['unshare', '--net', '--pid', '--fork', '--mount-proc', 'ip', 'tuntap', 'add', 'dev', 'probe',
                            'mode', 'tap'], stderr=subprocess.PIPE, text=True)
    return f'namespaces cannot be made here: {tried.stderr.strip()}' if tried.returncode else ''


def ip(*words):
    subprocess.run(['ip', *map(str, words)], check=True)


class Namespace:
    """Network, processes and mounts apart from those of the machine, until stopped."""

    def __init__(self):
        # The shell adopts and buries what others leave behind.
        self.process = subprocess.Popen(
            ['unshare', '--net', '--pid', '--fork', '--kill-child', '--mount-proc', 'bash', '-c', 'echo; read -r _'],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True)
        self.process.stdout.readline()
        self.pid = self.process.pid
        self.run('ip', 'link', 'set', 'lo', 'up')

    def enter(self, *command):
        """The command that runs `command` in here."""
        folder = f'/proc/{self.pid}/ns'
        return ['nsenter', f'--net={folder}/net', f'--mount={folder}/mnt', f'--pid={folder}/pid_for_children', *command]

    def run(self, *command):
        """Runs a command in here to its end; fails if it does."""
        subprocess.run(self.enter(*map(str, command)), check=True)

    def stop(self):
        """Ends all in here at once, as if the power went off."""
        self.process.kill()
        self.process.wait()
        self.process.stdin.close()
        self.process.stdout.close()


class Switch(Namespace):
    """Joins the hosts. Puts on the list `excused` what a cut cable makes of a motion."""

    def __init__(self, excused):
        super().__init__()
        self.excused = excused
        self.run('ip', 'link', 'add', 'switch', 'type', 'bridge')
        self.run('ip', 'link', 'set', 'switch', 'up')

    def plug_in(self, name, host, cable=None):
        """Lays a cable from `host`, where it is `eth0`: a good one, or one of another kind."""
        if cable is None:
            ip('link', 'add', 'eth0', 'netns', host.pid, 'type', 'veth', 'peer', 'name', name, 'netns', self.pid)
        else:
            cable(host.pid, 'eth0', self.pid, name)
        # A computer keeps its hardware address when it is switched off and on.
        hardware = f'02:00:00:00:00:0{ADDRESSES[name][-1]}'
        host.run('ip', 'link', 'set', 'eth0', 'address', hardware)
        host.run('ip', 'address', 'add', f'{ADDRESSES[name]}/24', 'dev', 'eth0')
        host.run('ip', 'link', 'set', 'eth0', 'up')
        self.run('ip', 'link', 'set', name, 'master', 'switch', 'up')

    def set_link(self, name, state):
        """Cuts (`down`) or restores (`up`) the cable of a host."""
        self.excused.append(CUT)
        self.run('ip', 'link', 'set', name, state)


class BadCable:
    """A cable that loses and delays what goes through it, if told to."""

    def __init__(self, *ends):
        self.process = subprocess.Popen([sys.executable, pathlib.Path(__file__).with_name('relay.py'), *map(str, ends)],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        print('bad cable:', self.process.stdout.readline())

    def set(self, loss=0.0, delay_s=0.0):
        """Loses this share of the frames, either way, and delivers the others so much later."""
        self.process.stdin.write(f'{loss} {delay_s}\n')
        self.process.stdin.flush()

    def stop(self):
        self.process.stdin.close()
        self.process.stdout.close()
        self.process.wait()


class Lab(Core):
    """Robot and computers. The master runs on the robot; this process becomes one on the main computer."""

    def __init__(self, folder, badly_wired=None):
        super().__init__(folder)
        self.badly_wired, self.cable = badly_wired, None
        self.environment.update(ROS_MASTER_URI=f'http://{ADDRESSES[ROBOT]}:{MASTER_PORT}', ROS_IP=ADDRESSES[MAIN],
                                HOME=str(folder / 'home'))
        self.hosts = {}
        self.switch = None
        self.robot = None

    def start(self):
        """Switches all on, and starts the simulated robot."""
        self._make_keys()
        self.switch = Switch(self.excused)
        for name in ADDRESSES:
            self.power_on(name)
        join_network(self.hosts[MAIN].pid)
        os.environ.update(self.environment)
        os.environ.pop('ROS_HOSTNAME', None)
        self.start_robot()

    def start_robot(self):
        """Starts the master and the robot, again after a stop."""
        self.robot = self.launch_on(ROBOT, 'sim_robot.launch')
        wait_until(lambda: self._alive(self.robot) and '/sim_baxter' in self.nodes(), 30, 'the robot')

    @staticmethod
    def _alive(program):
        if not program.running():
            raise RuntimeError(f'{program.command} ended:\n{program.printed()}')
        return True

    def _make_keys(self):
        ssh = self.folder / 'home' / '.ssh'
        ssh.mkdir(parents=True, mode=0o700)
        generate = ['ssh-keygen', '-q', '-t', 'ed25519', '-N', '', '-f']
        subprocess.run([*generate, ssh / 'id_ed25519'], check=True)
        subprocess.run([*generate, self.folder / 'host_key'], check=True)
        key = ' '.join((self.folder / 'host_key.pub').read_text().split()[:2])
        (ssh / 'known_hosts').write_text(''.join(f'{address} {key}\n' for address in ADDRESSES.values()))

    def power_on(self, name):
        """Makes a host, reachable by ssh unless it is the robot."""
        host = self.hosts[name] = Namespace()
        if name == self.badly_wired:
            self.switch.plug_in(name, host, self._lay_bad_cable)
        else:
            self.switch.plug_in(name, host)
        if name != ROBOT:
            self._start_sshd(name)

    def _lay_bad_cable(self, *ends):
        # Setpoints that are late or lost are no fault of who sent them.
        self.excused += [CUT, 'velocity', 'acceleration', 'jerk']
        self.cable = BadCable(*ends)

    def power_off(self, name):
        self.excused.append(CUT)
        self.hosts.pop(name).stop()

    def _start_sshd(self, name):
        # What a login has of the tests' environment; ROS_MASTER_URI comes from roslaunch, ROS_IP from the env-loader.
        wanted = ('ROS_HOME', 'ROS_LOG_DIR', 'PYTHONUNBUFFERED', 'RUST_LOG')
        variables = {MARK: f'{self.mark}:{name}',
                     **{key: self.environment[key] for key in wanted if key in self.environment}}
        config = self.folder / f'sshd-{name}.conf'
        config.write_text(SSHD_CONFIG.format(
            address=ADDRESSES[name], folder=self.folder, home=self.folder / 'home',
            variables=' '.join(f'{key}={value}' for key, value in variables.items())))
        # sshd wants a folder below /run, which is this host's own.
        self.hosts[name].run('mount', '-t', 'tmpfs', 'tmpfs', '/run')
        self.hosts[name].run('mkdir', '/run/sshd')
        self.run_on(name, '/usr/sbin/sshd', '-D', '-e', '-f', config)

    def run_on(self, name, *command, **variables):
        """Starts a program on a host."""
        environment = {'ROS_IP': ADDRESSES[name], MARK: f'{self.mark}:{name}', **variables}
        log = self.folder / f'{len(self.programs)}-{name}-{os.path.basename(str(command[0]))}.log'
        program = Program(self.hosts[name].enter(*map(str, command)), {**self.environment, **environment}, log)
        self.programs.append(program)
        return program

    def run(self, *command, **variables):
        return self.run_on(MAIN, *command, **variables)

    def launch_on(self, name, file, **arguments):
        """Starts one of the package's launch files on a host, as a person there would."""
        words = [f'{key}:={value}' for key, value in arguments.items()]
        return self.run_on(name, 'roslaunch', '--sigint-timeout', 5, '--sigterm-timeout', 2, 'deformable_cobot', file, *words)

    def launch(self, file, **arguments):
        return self.launch_on(MAIN, file, **arguments)

    def output_on(self, name, *command, timeout_s=30, **variables):
        """Runs a program on a host to its end; returns what it printed. Fails if the program does."""
        program = self.run_on(name, *command, **variables)
        code = program.wait(timeout_s)
        if code != 0:
            raise RuntimeError(f'{program.command} ended with {code}:\n{program.printed()}')
        return program.printed()

    def names(self, begin):
        """Names of the nodes that the master knows and that begin so."""
        return [name for name in self.nodes() if name.startswith(begin)]

    def nodes_on(self, name):
        """Names of the nodes that run on a host."""
        words = [word for words in marked_processes(f'{self.mark}:{name}').values() for word in words]
        return {word.removeprefix('__name:=') for word in words if word.startswith('__name:=')}

    def memory(self, node):
        """Resident memory of a node, in bytes."""
        with open(f'/proc/{self.process_of(node)}/statm') as file:
            return int(file.read().split()[1]) * os.sysconf('SC_PAGE_SIZE')

    def stop(self):
        """Switches all off."""
        for name in list(self.hosts):
            self.power_off(name)
        if self.cable:
            self.cable.stop()
        if self.switch:
            self.switch.stop()
        for program in self.programs:
            program.stop()
        kill_marked(self.mark)

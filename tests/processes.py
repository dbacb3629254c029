"""Programs that a test starts: in a process group of their own, with a log, stopped for certain."""

import os
import random
import signal
import socket
import subprocess
import time

# Every program started here, and all that it starts in turn, carries this variable; by it they are found again.
MARK = 'DEFORMABLE_COBOT_RUN'


# Below those that Linux gives to outgoing connections (net.ipv4.ip_local_port_range), one of which might take a port that was just free.
PORTS = range(12000, 32000)


def free_port():
    """A TCP port of this computer that nobody listens on, and that nobody gets by chance."""
    while True:
        # Of the system, not of this process's state: tests are forks of one process.
        port = random.SystemRandom().choice(PORTS)
        with socket.socket() as probe:
            try:
                probe.bind(('127.0.0.1', port))
                return port
            except OSError:
                continue


def wait_until(condition, timeout_s, what, period_s=0.05):
    """Returns the condition's first true value; fails with `what` when there is none in time."""
    deadline = time.monotonic() + timeout_s
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > deadline:
            raise TimeoutError(f'{what}: not within {timeout_s} s')
        time.sleep(period_s)


class Program:
    """One running program; what it prints goes to `log`. It can be typed to where `stdin` is a pipe."""

    def __init__(self, command, environment, log, stdin=subprocess.DEVNULL):
        self.command = [str(word) for word in command]
        self.log = log
        with open(log, 'wb') as output:
            self.process = subprocess.Popen(self.command, env=environment, stdin=stdin, stdout=output,
                                            stderr=subprocess.STDOUT, start_new_session=True)

    def running(self):
        return self.process.poll() is None

    def printed(self):
        return self.log.read_text(errors='replace')

    def type(self, text):
        """Types to it."""
        self.process.stdin.write(text.encode())
        self.process.stdin.flush()

    def wait(self, timeout_s):
        """Waits for its end; returns its exit code."""
        return self.process.wait(timeout_s)

    def stop(self, timeout_s=20):
        """Asks it to end as Ctrl-C does; kills its group if that does not help. Returns its exit code."""
        for number, patience_s in ((signal.SIGINT, timeout_s), (signal.SIGTERM, 2), (signal.SIGKILL, 2)):
            if not self.running():
                break
            os.killpg(self.process.pid, number)
            try:
                self.process.wait(patience_s)
            except subprocess.TimeoutExpired:
                pass
        return self.process.returncode


def marked_processes(mark):
    """Ids and command lines, as lists of words, of the programs whose mark begins with this one."""
    wanted = f'{MARK}={mark}'.encode()
    found = {}
    for entry in os.listdir('/proc'):
        if not entry.isdigit():
            continue
        try:
            with open(f'/proc/{entry}/environ', 'rb') as environ:
                if not any(variable.startswith(wanted) for variable in environ.read().split(b'\0')):
                    continue
            with open(f'/proc/{entry}/cmdline', 'rb') as cmdline:
                words = cmdline.read().decode(errors='replace').split('\0')[:-1]
        except OSError:  # ended meanwhile, or not ours
            continue
        if words:  # a zombie has none
            found[int(entry)] = words
    return found


def kill_marked(mark):
    """Kills what is left of a run; a process's environment is that of its start, so never the caller."""
    for process in marked_processes(mark):
        try:
            os.kill(process, signal.SIGKILL)
        except ProcessLookupError:
            pass

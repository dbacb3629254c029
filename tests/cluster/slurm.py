"""A Slurm cluster of this one machine: munged, slurmctld and slurmd with folders, ports and a key of their own."""

import os
import secrets
import socket
import subprocess

from processes import MARK, Program, free_port, kill_marked, wait_until

START_S = 20

# No cgroups and no accounting: a container has neither. The node may have more CPUs than the machine.
CONFIG = '''\
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller_port}
SlurmdPort={node_port}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/builtin
SchedulerParameters=batch_sched_delay=0,sched_min_interval=0
SlurmdParameters=config_overrides
MailProg=/bin/true
MpiDefault=none
ReturnToService=2
InactiveLimit=0
KillWait=5
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
'''


class Slurm:
    """The cluster, with all its files in `folder`. Clients see it by `environment`."""

    def __init__(self, folder, cpus):
        self.folder = folder
        self.mark = f'{os.environ.get(MARK, "")}{folder}'
        self.environment = {**os.environ, MARK: self.mark, 'SLURM_CONF': str(folder / 'slurm.conf')}
        self.programs = []
        for name in ('state', 'spool'):
            (folder / name).mkdir()
        key = folder / 'munge.key'
        key.write_bytes(secrets.token_bytes(128))
        key.chmod(0o600)
        (folder / 'slurm.conf').write_text(CONFIG.format(
            host=socket.gethostname().split('.')[0], folder=folder, cpus=cpus, controller_port=free_port(),
            node_port=free_port()))

    def start(self):
        """Starts the daemons, and waits until the node is idle."""
        folder, config = self.folder, self.folder / 'slurm.conf'
        munged = self.run('/usr/sbin/munged', '--foreground', '--force', f'--socket={folder}/munge.socket',
                          f'--key-file={folder}/munge.key', f'--pid-file={folder}/munged.pid',
                          f'--seed-file={folder}/munged.seed', f'--log-file={folder}/munged.log')
        wait_until(lambda: self.alive(munged) and (folder / 'munge.socket').exists(), START_S, 'munged')
        self.run('/usr/sbin/slurmctld', '-D', '-f', config)
        self.run('/usr/sbin/slurmd', '-D', '-f', config)
        wait_until(lambda: self.alive(*self.programs) and self.node_state() == 'idle', START_S, 'an idle node')

    def run(self, *command):
        """Starts one of the daemons."""
        log = self.folder / f'{os.path.basename(command[0])}.printed'
        program = Program(command, self.environment, log)
        self.programs.append(program)
        return program

    def alive(self, *programs):
        """True; fails where one of them has ended."""
        for program in programs:
            assert program.running(), f'{program.command[0]} ended:\n{program.printed()}'
        return True

    def node_state(self):
        done = subprocess.run(['sinfo', '--noheader', '--format=%T'], env=self.environment, text=True, timeout=START_S,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        return done.stdout.strip()

    def submit(self, *arguments, timeout_s=20, **variables):
        """sbatch with these arguments. Returns its exit code, which with --wait is the job's, and what it printed."""
        done = subprocess.run(['sbatch', *map(str, arguments)], env={**self.environment, **variables}, text=True,
                              cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, timeout=timeout_s)
        return done.returncode, done.stdout.strip()

    def printed(self):
        """The logs of all daemons and jobs."""
        logs = [*(program.log for program in self.programs), *self.folder.glob('*.log')]
        return '\n'.join(f'--- {log.name}\n{log.read_text(errors="replace")}' for log in logs)

    def stop(self):
        """Ends the daemons and all that they started."""
        for program in reversed(self.programs):
            program.stop(timeout_s=5)
        kill_marked(self.mark)

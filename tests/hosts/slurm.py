"""Slurm on hosts of a network: one that controls, and nodes. Takes Debian's slurmctld, slurmd and slurm-client."""

import os
import subprocess
import time

_CONFIGURATION = """\
ClusterName=tests
SlurmctldHost={head}
SlurmUser=root
SlurmdUser=root
AuthType=auth/none
CredType=cred/none
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=2
MailProg=/bin/true
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/%n.log
NodeName={nodes} CPUs=2 RealMemory=8000
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE
"""


class Slurm:
    """A controller on one host, and nodes on others, until the context ends.

    Parameters
    ----------
    network : Network
    head : str
        Host of the controller.
    nodes : list of str
    folder : Path
        Holds its files. All hosts see it.
    environment : dict
        Of the commands that submit, and so of the jobs.
    """

    def __init__(self, network, head, nodes, folder, environment):
        self._network, self._head, self._nodes, self._folder = network, head, nodes, folder
        self._environment = environment | {"SLURM_CONF": str(folder / "slurm.conf")}
        self._daemons = []

    def __enter__(self):
        (self._folder / "state").mkdir()
        text = _CONFIGURATION.format(head=self._head, nodes=",".join(self._nodes), folder=self._folder)
        (self._folder / "slurm.conf").write_text(text)
        # Hosts of this kind have no control groups; this plugin takes that.
        (self._folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\n")
        try:
            self._start(self._head, ["slurmctld", "-D"])
            for node in self._nodes:
                (self._folder / f"spool-{node}").mkdir()
                self._start(node, ["slurmd", "-D", "-N", node])
            self._wait_for(lambda: self.call("sinfo", "--noheader", "--format", "%T", check=False) == "idle")
        except BaseException:
            self._kill()
            raise
        return self

    def __exit__(self, *_):
        try:
            self.call("scancel", "--user", "root")
            self._wait_for(lambda: not self.call("squeue", "--noheader"))
        finally:
            self._kill()

    def _kill(self):
        for daemon in self._daemons:
            daemon.kill()
            daemon.wait(10)

    def _start(self, host, command):
        with (self._folder / f"{host}.out").open("wb") as log:
            daemon = subprocess.Popen(
                self._network.on(host, command), env=self._environment, stdout=log, stderr=log, start_new_session=True
            )
        self._daemons.append(daemon)

    def _wait_for(self, holds, seconds=60):
        patience = time.monotonic() + seconds
        while not holds():
            assert time.monotonic() < patience, (self._folder / "slurmctld.log").read_text()[-3000:]
            time.sleep(0.3)

    def call(self, *command, host=None, check=True):
        """Output of a command, on the controller's host where no other is named; fails where the command does."""
        command = self._network.on(host or self._head, command)
        answer = subprocess.run(
            command, env=self._environment, cwd=self._folder, capture_output=True, text=True, timeout=120
        )
        assert not check or answer.returncode == 0, answer.stdout + answer.stderr
        return answer.stdout.strip()

    def submit(self, *arguments):
        """Number of a job that `sbatch` takes."""
        return self.call("sbatch", "--parsable", *arguments)

    def state(self, job):
        """State of a job, empty once Slurm has forgotten it."""
        return self.call("squeue", "--noheader", "--states", "all", "--format", "%T", "--jobs", job)

    def seconds_left(self, job):
        """Seconds until the time of a job that runs is up."""
        end = self.call("squeue", "--noheader", "--format", "%e", "--jobs", job)
        return int(subprocess.check_output(["date", "+%s", "--date", end])) - time.time()


def environment_of_jobs(root):
    """What a user has in the environment who submits jobs."""
    return {
        "PATH": os.environ["PATH"] + ":/usr/sbin",
        "HOME": os.environ["HOME"],
        "PYTHONPATH": str(root),
        "LANG": "C.UTF-8",
    }

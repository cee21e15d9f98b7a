"""A scheduler and workers of their own, as on several machines, brought back by a supervisor when they end."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
from collections import Counter

import psutil

from tests.running_service import free_port

ENVIRONMENT = {"DASK_DISTRIBUTED__WORKER__PRELOAD": '["tests.faults.preload"]'}


class Supervised:
    """A command that is started again whenever it ends, whatever its exit code."""

    def __init__(self, command, log, environment):
        self.command, self.log, self.environment = command, log, environment
        self.process = self._start()

    def _start(self):
        with open(self.log, "ab") as log:
            return subprocess.Popen(self.command, stdout=log, stderr=log, env=os.environ | self.environment)

    def kill(self):
        self.process.send_signal(signal.SIGKILL)

    def revive(self):
        if self.process.poll() is not None:
            self.process = self._start()

    def end(self):
        self.process.kill()
        self.process.wait(10)


class Farm:
    """Scheduler and workers; `address` is what ``RATTLE_SCHEDULER`` takes."""

    def __init__(self, folder, starts, workers=2):
        port, environment = free_port(), ENVIRONMENT | {"RATTLE_STARTS": str(starts)}
        self.address = f"tcp://127.0.0.1:{port}"
        scheduler = ["scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard"]
        worker = ["worker", self.address, "--host", "127.0.0.1", "--nthreads", "1", "--no-nanny", "--no-dashboard"]
        worker += ["--local-directory", str(folder)]

        def supervised(arguments):
            return Supervised([sys.executable, "-m", "dask", *arguments], folder / "farm.log", environment)

        self.scheduler = supervised(scheduler)
        self.workers = [supervised(worker) for _ in range(workers)]
        self._ended = threading.Event()
        self._supervisor = threading.Thread(target=self._supervise)

    def _supervise(self):
        while not self._ended.wait(0.2):
            for each in (self.scheduler, *self.workers):
                each.revive()

    def __enter__(self):
        self._supervisor.start()
        return self

    def __exit__(self, *_):
        self._ended.set()
        self._supervisor.join()
        for each in (*self.workers, self.scheduler):
            each.end()


def local_workers(service):
    """Process numbers of the embedded workers of a running service."""
    found, runner = [], service.runner()
    with contextlib.suppress(psutil.NoSuchProcess):
        for child in runner.children() if runner is not None else ():
            with contextlib.suppress(psutil.NoSuchProcess):
                if any("spawn_main" in part for part in child.cmdline()):
                    found.append(child.pid)
    return found


def kill(pids):
    """SIGKILL; those that are gone already do not count."""
    killed = 0
    for pid in pids:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
            killed += 1
    return killed


def starts(path):
    """How often each tile was started."""
    lines = path.read_text().splitlines() if path.exists() else []
    return Counter(int(line.split()[1]) for line in lines)


def begun(service, job):
    """Wait until a job has mapped a tile."""
    service.wait(job["id"], lambda job: job["progress"] and job["progress"]["tiles_done"] >= 1)


def has_mapped(job, share):
    """Whether a job has mapped such a share of its tiles."""
    return job["progress"] and job["progress"]["tiles_done"] >= share * job["progress"]["tiles_total"]


def store_of(service, job):
    """Folder of a job's store."""
    return service.data / "results" / f"{job['id']}.zarr"

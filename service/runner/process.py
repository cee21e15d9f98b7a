"""The runner process, which runs jobs beside the process that handles requests.

Creating stores and driving tasks keep a processor busy while small jobs arrive, and Python lets one thread of a process
compute at a time. In a single process, fifteen small jobs a second delayed every response by seconds. Both processes
read the jobs from the database. Two pipes between them carry hints only.
"""

import contextlib
import logging
import multiprocessing
import os
import signal
import threading
import time
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess

from service.logs import write_logs
from service.records.engine import open_database
from service.records.jobs import Jobs
from service.runner import metrics as run_metrics
from service.runner.retention import Retention
from service.runner.runner import Runner
from service.settings import Settings
from worker.cluster.connection import ReconnectingCluster

_log = logging.getLogger("rattle.runner")
# Responses come first. A small job's store takes half a second of processor time; at niceness 2 the server process got
# little more than half of its core meanwhile. At a higher niceness the runner is slow to stop on a busy machine.
_NICENESS = 7
_REPORT_SECONDS = 0.5
# An older report means that the process hangs.
_REPORT_VALID_SECONDS = 3.0
_STOP_SECONDS = 10.0
_PAUSE_SECONDS = 1.0


class RunnerProcess:
    """Keeps a runner process alive, from the server process.

    Guarantees. A runner that ends is started again. It continues its jobs at once, because it sees that the owner of
    their leases is dead. However this process ends, the runner stops and its jobs go back to the queue. No call waits
    for the runner.

    Parameters
    ----------
    settings : Settings
    """

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._stopping = threading.Event()
        self._commands: Connection | None = None
        self._process: SpawnProcess | None = None
        self._report: tuple[int, bytes] = (0, b"")
        self._reported = -_REPORT_VALID_SECONDS
        self._keeping = threading.Thread(target=self._keep, name="rattle-runner", daemon=True)

    def start(self) -> None:
        """Start the process."""
        self._keeping.start()

    def stop(self) -> None:
        """Stop the process. Running jobs go back to the queue."""
        self._stopping.set()
        self._hang_up()
        self._keeping.join(_STOP_SECONDS)
        if (process := self._process) is not None:
            process.kill()

    def wake(self) -> None:
        """Announce that a job has been submitted."""
        self._send(None)

    def cancel(self, job_id: str) -> None:
        """Announce that a job was cancelled. If it runs in another replica, that one reads it from the database."""
        self._send(job_id)

    def workers(self) -> int:
        """Number of workers that the scheduler knows; 0 if it or the runner process does not answer."""
        return self._report[0] if time.monotonic() - self._reported < _REPORT_VALID_SECONDS else 0

    def metrics(self) -> bytes:
        """The runner's metrics in Prometheus' text format, at most half a second old."""
        return self._report[1]

    def _send(self, job_id: str | None) -> None:
        # A hint may be lost, as when the process hangs and the pipe is full: the runner polls the database, too.
        with contextlib.suppress(OSError):
            if (commands := self._commands) is not None:
                commands.send(job_id)

    def _hang_up(self) -> None:
        commands, self._commands = self._commands, None
        if commands is not None:
            commands.close()

    def _keep(self) -> None:
        while not self._stopping.is_set():
            try:
                self._run_once()
            except OSError:
                _log.exception("the runner process could not be started")
            if not self._stopping.is_set():
                _log.error("the runner process has ended; starting it again")
                self._stopping.wait(_PAUSE_SECONDS)

    def _run_once(self) -> None:
        """Run one process to its end."""
        context = multiprocessing.get_context("spawn")
        commands_there, commands = context.Pipe(duplex=False)
        reports, reports_there = context.Pipe(duplex=False)
        # A message shorter than a page is written as a whole or not at all, without waiting.
        os.set_blocking(commands.fileno(), False)
        process = context.Process(
            target=_run_jobs, args=(self._settings, commands_there, reports_there), name="rattle-runs"
        )
        process.start()
        self._process = process
        for theirs in (commands_there, reports_there):
            theirs.close()
        self._commands = commands
        if self._stopping.is_set():
            self._hang_up()
        with reports, contextlib.suppress(EOFError, OSError):
            while True:
                self._report, self._reported = reports.recv(), time.monotonic()
        self._hang_up()
        process.join()


def _run_jobs(settings: Settings, commands: Connection, reports: Connection) -> None:
    """Run jobs until the other end of `commands` is closed, as it is when its process dies."""
    # Signals reach the whole process group. The server process handles them, and closes the pipe.
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: None)
    os.nice(_NICENESS)
    log = write_logs(settings.log_format, settings.log_level)
    engine, sessions = open_database(settings.database)
    cluster = ReconnectingCluster(
        settings.scheduler, settings.workers, settings.certificates, _Compiling(), run_metrics.task_retried
    )
    cluster.open()
    runner = Runner(Jobs(sessions, settings.quotas), cluster, settings.results, settings.concurrent_jobs)
    runner.start()
    Retention(runner.jobs, runner.jobs.reads, settings.results, settings.keep_days, settings.keep_gb).start()
    threading.Thread(target=_report, args=(runner, reports), name="rattle-reports", daemon=True).start()
    with contextlib.suppress(EOFError):
        while True:
            job_id = commands.recv()
            runner.wake() if job_id is None else runner.cancel(job_id)
    runner.stop()
    cluster.drop()
    engine.dispose()
    log.stop()
    os._exit(0)  # everything that matters is closed; closing Dask as well would take seconds


class _Compiling:
    """Logs how many kernels have been compiled: at first, after each quarter, and at the end."""

    def __init__(self) -> None:
        self._quarters = -1

    def __call__(self, done: int, total: int) -> None:
        if (quarters := 4 * done // total) > self._quarters:
            self._quarters = quarters
            _log.info("compiling kernels, the first time only: %d of %d", done, total)


def _report(runner: Runner, reports: Connection) -> None:
    with contextlib.suppress(OSError):  # the other process has ended
        while True:
            reports.send((runner.workers(), run_metrics.exposition()))
            time.sleep(_REPORT_SECONDS)

"""The process that runs jobs, beside the one that answers.

Creating stores and driving tasks cost a processor for as long as small jobs come, and Python lets one thread of a
process compute at a time: in one process with the answers, fifteen small jobs a second made each answer wait for
seconds. Both know the jobs from the database; between the two processes there are only hints, two pipes of them.
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
from service.runner.runner import Runner
from service.settings import Settings
from worker.cluster.reconnecting_cluster import LastingCluster

_log = logging.getLogger("rattle.runner")
# Whoever asks is answered first: a small job's store takes a processor for half a second, and at 2 the one that answers
# got little more than half of its core meanwhile. A process that yields more takes long to stop on a busy machine.
_NICENESS = 7
_TELL_SECONDS = 0.5
# News that are older tell of a process that hangs.
_NEWS_SECONDS = 3.0
_STOP_SECONDS = 10.0
_PAUSE_SECONDS = 1.0


class RunnerProcess:
    """Keeps a process that runs jobs, as one of the service that answers.

    Guarantees. One that ends is started again, and goes on with its jobs at once: its leases are seen to be a dead
    one's. When this process ends, however it does, the other one stops and gives its jobs back. No call waits for it.

    Parameters
    ----------
    settings : Settings
    """

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._stopping = threading.Event()
        self._orders: Connection | None = None
        self._process: SpawnProcess | None = None
        self._news: tuple[int, bytes] = (0, b"")
        self._told = -_NEWS_SECONDS
        self._keeping = threading.Thread(target=self._keep, name="rattle-runner", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._keeping.start()

    def stop(self) -> None:
        """Stop: running jobs go back to queued."""
        self._stopping.set()
        self._hang_up()
        self._keeping.join(_STOP_SECONDS)
        if (process := self._process) is not None:
            process.kill()

    def ring(self) -> None:
        """Say that a job has been submitted."""
        self._order(None)

    def cancel(self, job_id: str) -> None:
        """Say that a job was cancelled; where it runs elsewhere, it is noticed there."""
        self._order(job_id)

    def workers(self) -> int:
        """Workers that the scheduler knows; 0 where it, or the process, does not answer."""
        return self._news[0] if time.monotonic() - self._told < _NEWS_SECONDS else 0

    def metrics(self) -> bytes:
        """What the process counts, as Prometheus reads it; half a second old."""
        return self._news[1]

    def _order(self, job_id: str | None) -> None:
        # A hint that is lost, as where the process hangs and the pipe is full, is made up for by the database.
        with contextlib.suppress(OSError):
            if (orders := self._orders) is not None:
                orders.send(job_id)

    def _hang_up(self) -> None:
        orders, self._orders = self._orders, None
        if orders is not None:
            orders.close()

    def _keep(self) -> None:
        while not self._stopping.is_set():
            try:
                self._run_once()
            except OSError:
                _log.exception("no process for jobs could be started")
            if not self._stopping.is_set():
                _log.error("the process that runs jobs has ended; starting it again")
                self._stopping.wait(_PAUSE_SECONDS)

    def _run_once(self) -> None:
        """Run one process to its end."""
        context = multiprocessing.get_context("spawn")
        orders_there, orders = context.Pipe(duplex=False)
        news, news_there = context.Pipe(duplex=False)
        # What is shorter than a page is written whole or not at all, and never waited for.
        os.set_blocking(orders.fileno(), False)
        process = context.Process(target=_run_jobs, args=(self._settings, orders_there, news_there), name="rattle-runs")
        process.start()
        self._process = process
        for theirs in (orders_there, news_there):
            theirs.close()
        self._orders = orders
        if self._stopping.is_set():
            self._hang_up()
        with news, contextlib.suppress(EOFError, OSError):
            while True:
                self._news, self._told = news.recv(), time.monotonic()
        self._hang_up()
        process.join()


def _run_jobs(settings: Settings, orders: Connection, news: Connection) -> None:
    """Run jobs until the other end of `orders` is closed, as it is when the process that holds it dies."""
    for asked in (signal.SIGTERM, signal.SIGINT):  # told to the whole group, and passed on by the process that answers
        signal.signal(asked, lambda *_: None)
    os.nice(_NICENESS)
    write_logs(settings.log_format, settings.log_level)
    engine, sessions = open_database(settings.database)
    cluster = LastingCluster(settings.scheduler, settings.workers, settings.certificates, run_metrics.task_retried)
    cluster.open()
    runner = Runner(Jobs(sessions, settings.quotas), cluster, settings.results, settings.concurrent_jobs)
    runner.start()
    threading.Thread(target=_tell, args=(runner, news), name="rattle-news", daemon=True).start()
    with contextlib.suppress(EOFError):
        while True:
            job_id = orders.recv()
            runner.ring() if job_id is None else runner.cancel(job_id)
    runner.stop()
    cluster.drop()
    engine.dispose()
    os._exit(0)  # all that matters is in order; what Dask would still wait for is not


def _tell(runner: Runner, news: Connection) -> None:
    with contextlib.suppress(OSError):  # nobody listens any more
        while True:
            news.send((runner.workers(), run_metrics.exposition()))
            time.sleep(_TELL_SECONDS)

"""Takes queued jobs in order and runs them on the cluster, one at a time."""

import dataclasses
import logging
import threading
import time
from datetime import UTC, datetime
from typing import Any

from service import metrics
from service.errors import kind_of
from service.job_record import JobRecord, JobState
from service.jobs import Jobs
from service.logs import about_job
from worker.cluster import Client, count_workers
from worker.errors import JobCancelled, WorkerError
from worker.job_kinds import JOB_KINDS
from worker.progress import Progress, Stage
from worker.result_files import result_location

_log = logging.getLogger("rattle.runner")
# Other replicas submit to the same database, and nobody rings here for them.
_POLL_SECONDS = 1.0
_PROGRESS_SECONDS = 0.25
_STOP_SECONDS = 4.0
_ANSWER_SECONDS = 2.0


class Runner:
    """A thread that runs jobs.

    Guarantees. A job that this runner has claimed ends in a final state, or goes back to queued when the runner is
    stopped under it; cancelling is noticed within a fifth of a second, and tiles stop between two bands.

    Parameters
    ----------
    jobs : Jobs
    client : Client
        Of the Dask scheduler.
    results : str
        Folder of the Zarr stores.
    """

    def __init__(self, jobs: Jobs, client: Client, results: str) -> None:
        self.jobs, self.client, self.results = jobs, client, results
        self._bell = threading.Event()
        self._stopping = threading.Event()
        self._lock = threading.Lock()
        self._cancel: dict[str, threading.Event] = {}
        self._thread = threading.Thread(target=self._work, name="rattle-runner", daemon=True)

    def start(self) -> None:
        """Recover jobs that a crash has left, and begin."""
        self.jobs.recover()
        self._thread.start()

    def stop(self) -> None:
        """Stop: the running job goes back to queued."""
        self._stopping.set()
        self._bell.set()
        with self._lock:
            for cancel in self._cancel.values():
                cancel.set()
        self._thread.join(_STOP_SECONDS)

    def ring(self) -> None:
        """Say that a job has been submitted."""
        self._bell.set()

    def cancel(self, job_id: str) -> None:
        """Tell the running job, if it is this one, to stop."""
        with self._lock:
            if job_id in self._cancel:
                self._cancel[job_id].set()

    def workers(self) -> int:
        """Workers that the scheduler knows; 0 where it does not answer."""
        return count_workers(self.client, _ANSWER_SECONDS)

    def _work(self) -> None:
        while not self._stopping.is_set():
            self._bell.clear()
            try:
                record = self.jobs.claim()
            except Exception:
                _log.exception("the database did not answer; trying again")
                record = None
            if record is None:
                self._bell.wait(_POLL_SECONDS)
                continue
            with about_job(record.id):
                self._run(record)

    def _run(self, record: JobRecord) -> None:
        cancel = threading.Event()
        with self._lock:
            self._cancel[record.id] = cancel
        if self._stopping.is_set() or self.jobs.get(record.id).state == JobState.CANCELLING:
            cancel.set()
        _log.info("runs: %s of %s", record.kind, record.submitter)
        if record.progress is None:
            metrics.job_started((datetime.now(UTC) - record.created.replace(tzinfo=UTC)).total_seconds())
        try:
            self._compute(record, cancel)
        finally:
            with self._lock:
                del self._cancel[record.id]

    def _compute(self, record: JobRecord, cancel: threading.Event) -> None:
        try:
            kind = JOB_KINDS[record.kind]
            location, report = result_location(self.results, record.id), _Throttled(self.jobs, record.id)
            kind.run(kind.from_request(record.request), location, self.client, report=report, cancel=cancel)
        except JobCancelled:
            self._stopped(record.id)
        except Exception as error:
            if not isinstance(error, WorkerError):
                _log.exception("job failed")
            told = {"kind": kind_of(error), "detail": f"{error}" if isinstance(error, WorkerError) else repr(error)}
            self._end(record.id, JobState.FAILED, error=told)
        else:
            self._end(record.id, JobState.SUCCEEDED)

    def _stopped(self, job_id: str) -> None:
        if self.jobs.move(job_id, JobState.CANCELLING, JobState.CANCELLED):
            _log.info("ends: %s", JobState.CANCELLED)
            metrics.job_ended(JobState.CANCELLED)
        else:
            self.jobs.move(job_id, JobState.RUNNING, JobState.QUEUED)

    def _end(self, job_id: str, state: JobState, **values: Any) -> None:
        # Somebody may have asked for cancellation after the last tile: the result is there, and that is what counts.
        if not self.jobs.move(job_id, JobState.RUNNING, state, **values):
            self.jobs.move(job_id, JobState.CANCELLING, state, **values)
        _log.info("ends: %s", state)
        metrics.job_ended(state)


class _Throttled:
    """Writes progress to the job's record a few times a second; a new stage at once."""

    def __init__(self, jobs: Jobs, job_id: str) -> None:
        self.jobs, self.job_id = jobs, job_id
        self.stage: Stage | None = None
        self.written = 0.0
        self.pace = metrics.Pace()

    def __call__(self, progress: Progress) -> None:
        self.pace(progress)
        now = time.monotonic()
        if progress.stage == self.stage and now - self.written < _PROGRESS_SECONDS:
            return
        self.stage, self.written = progress.stage, now
        self.jobs.record_progress(self.job_id, dataclasses.asdict(progress))

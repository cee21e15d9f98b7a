"""Runs jobs on the cluster: several at once, by turns of their submitters, under leases."""

import collections
import dataclasses
import itertools
import logging
import threading
import time
from datetime import UTC, datetime
from typing import Any

from sqlalchemy.exc import SQLAlchemyError

from service.errors import kind_of
from service.logs import about_job
from service.records.job_record import JobRecord, JobState
from service.records.jobs import Jobs, Whose
from service.records.lease import Lease
from service.records.replica import replica_name
from service.runner import metrics as run_metrics
from worker.cluster.driver import Driver
from worker.cluster.reconnecting_cluster import LastingCluster
from worker.errors import ClusterFailed, JobCancelled, LeaseLost, WorkerError
from worker.kinds import JOB_KINDS
from worker.progress import Progress, Stage
from worker.stores.result_files import result_location

_log = logging.getLogger("rattle.runner")
# Other replicas submit to the same database, and nobody rings here for them.
_POLL_SECONDS = 0.5
# How soon a cancellation that another replica was told of is noticed; a lease lasts many times longer.
_BEAT_SECONDS = 0.5
_LOOK_FOR_DEAD_SECONDS = 2.0
_PROGRESS_SECONDS = 0.25
_STOP_SECONDS = 4.0
# A job that loses the cluster so often without having come any further is to blame itself.
_LOSSES = 5


Ends = dict[JobState, JobState]
"""What becomes of a job that ends in some way: the state it is in, and the one it then has."""
_STOPPED: Ends = {JobState.CANCELLING: JobState.CANCELLED, JobState.RUNNING: JobState.QUEUED}
_FAILED: Ends = {each: JobState.FAILED for each in (JobState.RUNNING, JobState.CANCELLING)}
# Somebody may have asked for cancellation after the last tile: the result is there, and that is what counts.
_SUCCEEDED: Ends = {each: JobState.SUCCEEDED for each in (JobState.RUNNING, JobState.CANCELLING)}


class Runner:
    """Threads that run jobs: one that claims them, one that keeps their leases, and one for each job.

    Guarantees. A job that this runner has claimed ends in a final state, or goes back to queued when the runner is
    stopped or the cluster is lost under it, or is left to another replica when its lease is lost; then nothing more is
    written. Cancelling is noticed within half a second, and tiles stop between two bands. Replicas share the jobs of
    one database; those of a dead one are taken over when its leases run out, or at once where it is seen to be dead.

    Parameters
    ----------
    jobs : Jobs
    cluster : LastingCluster
    results : str
        Folder of the Zarr stores.
    most : int
        Jobs that run at once. Of several places the last one is kept for small jobs, the one before it for those and
        for submitters that have nothing running.
    """

    def __init__(self, jobs: Jobs, cluster: LastingCluster, results: str, most: int) -> None:
        self.jobs, self.cluster, self.results, self.most = jobs, cluster, results, most
        self._name = replica_name()
        self._claims = itertools.count(1)
        self._bell = threading.Event()
        self._stopping = threading.Event()
        self._lock = threading.Lock()
        self._leases: dict[str, Lease] = {}
        self._threads: dict[str, threading.Thread] = {}
        self._losses: collections.Counter[str] = collections.Counter()
        self._looked_for_dead = -_LOOK_FOR_DEAD_SECONDS
        self._claiming = threading.Thread(target=self._claim_jobs, name="rattle-claims", daemon=True)
        self._beating = threading.Thread(target=self._keep_leases, name="rattle-leases", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._claiming.start()
        self._beating.start()

    def stop(self) -> None:
        """Stop: running jobs go back to queued."""
        self._stopping.set()
        self._bell.set()
        patience = time.monotonic() + _STOP_SECONDS
        self._claiming.join(_STOP_SECONDS)
        for lease in self._held():
            lease.cancel.set()
        for thread in list(self._threads.values()):
            thread.join(max(0.0, patience - time.monotonic()))

    def ring(self) -> None:
        """Say that a job has been submitted."""
        self._bell.set()

    def cancel(self, job_id: str) -> None:
        """Tell a job to stop, if it runs here; if elsewhere, it is noticed there."""
        with self._lock:
            if job_id in self._leases:
                self._leases[job_id].cancel.set()

    def workers(self) -> int:
        """Workers that the scheduler knows; 0 where it does not answer."""
        return self.cluster.workers()

    def _held(self) -> list[Lease]:
        with self._lock:
            return list(self._leases.values())

    def _claim_jobs(self) -> None:
        while not self._stopping.is_set():
            self._bell.clear()
            try:
                claimed = self._claim()
            except SQLAlchemyError:
                _log.exception("the database did not answer; trying again")
                claimed = False
            if not claimed:
                self._bell.wait(_POLL_SECONDS)

    def _claim(self) -> bool:
        """Begin one more job, if there is room, a cluster, and a job."""
        running = [lease.record for lease in self._held()]
        if time.monotonic() - self._looked_for_dead >= _LOOK_FOR_DEAD_SECONDS:
            self.jobs.free_the_dead()
            self._looked_for_dead = time.monotonic()
        if len(running) >= self.most > 0:
            return False
        driver = self.cluster.driver()
        if driver is None or self.most == 0:
            return False
        asked = time.monotonic()
        owner, ours = f"{self._name}/{next(self._claims)}", [record.id for record in running]
        record = self.jobs.claim(owner, but=ours, large=self._large(running))
        if record is None:
            return False
        lease = Lease(record, asked)
        thread = threading.Thread(target=self._run, args=(lease, driver), name=f"rattle-{record.id}", daemon=True)
        with self._lock:
            self._leases[record.id], self._threads[record.id] = lease, thread
        thread.start()
        return True

    def _large(self, running: list[JobRecord]) -> Whose:
        """Whose large jobs there is a place for, beside those that run."""
        left = self.most - sum(not record.small for record in running)
        if left <= 1 < self.most:
            return Whose.NOBODYS
        return Whose.NEWCOMERS if left == 2 < self.most else Whose.ANYONES

    def _keep_leases(self) -> None:
        while not self._stopping.wait(_BEAT_SECONDS):
            leases, asked = self._held(), time.monotonic()
            try:
                states = self.jobs.renew([lease.owner for lease in leases]) if leases else {}
            except SQLAlchemyError:
                _log.exception("leases could not be renewed; trying again")
                continue
            for lease in leases:
                # One that has run out is not taken up again: its driver may have stopped already.
                if lease.owner in states and not lease.lost:
                    lease.renewed(asked, states[lease.owner])
                elif not lease.ending:
                    lease.lose()

    def _run(self, lease: Lease, driver: Driver) -> None:
        with about_job(lease.record.id):
            self._run_told(lease, driver)

    def _run_told(self, lease: Lease, driver: Driver) -> None:
        record = lease.record
        _log.info("runs: %s of %s", record.kind, record.submitter)
        if record.progress is None:
            run_metrics.job_started((datetime.now(UTC) - record.created.replace(tzinfo=UTC)).total_seconds())
        try:
            ends, values = self._compute(lease, driver)
            if not lease.lost:
                self._record_end(lease, ends, values)
            if lease.lost:
                run_metrics.lease_lost()
                _log.warning("job %s was taken over by another replica, or may be: it is left alone", lease.record.id)
        finally:
            with self._lock:
                del self._leases[lease.record.id], self._threads[lease.record.id]
            self._bell.set()

    def _compute(self, lease: Lease, driver: Driver) -> tuple[Ends, dict[str, Any]]:
        record, report = lease.record, _Throttled(self.jobs, lease)
        try:
            kind = JOB_KINDS[record.kind]
            location = result_location(self.results, record.store or record.id)
            job = kind.from_request(record.request)
            kind.run(job, location, driver, report=report, cancel=lease.cancel, fence=lease.check)
        except (JobCancelled, LeaseLost):
            return _STOPPED, {}
        except Exception as error:
            lost = isinstance(error, ClusterFailed) or driver.client.status != "running"
            if lost and self._may_go_on(record.id, report.came_further):
                _log.warning("job %s is queued again: %s", record.id, error)
                return _STOPPED, {}
            if not isinstance(error, WorkerError):
                _log.exception("job failed")
            told = {"kind": kind_of(error), "detail": f"{error}" if isinstance(error, WorkerError) else repr(error)}
            return _FAILED, {"error": told}
        return _SUCCEEDED, {}

    def _may_go_on(self, job_id: str, came_further: bool) -> bool:
        """Whether a job that has lost the cluster is queued again."""
        self._losses[job_id] = 1 if came_further else self._losses[job_id] + 1
        return self._losses[job_id] < _LOSSES

    def _record_end(self, lease: Lease, ends: Ends, values: dict[str, Any]) -> None:
        lease.ending = True
        while not lease.lost:
            try:
                for expected, state in ends.items():
                    if self.jobs.move(lease.record.id, expected, state, owner=lease.owner, **values):
                        self._tell_end(lease, state)
                        return
                lease.lose()
            except SQLAlchemyError:
                _log.exception("the end of job %s could not be recorded; trying again", lease.record.id)
                time.sleep(_POLL_SECONDS)

    def _tell_end(self, lease: Lease, state: JobState) -> None:
        if state.final:
            _log.info("ends: %s", state)
            self._losses.pop(lease.record.id, None)
            run_metrics.job_ended(state)


class _Throttled:
    """Writes progress to the job's record a few times a second; a new stage at once."""

    def __init__(self, jobs: Jobs, lease: Lease) -> None:
        self.jobs, self.lease = jobs, lease
        self.stage: Stage | None = None
        self.written = 0.0
        self.begun: tuple[Stage, int] | None = None
        self.came_further = False
        self.pace = run_metrics.Pace()

    def __call__(self, progress: Progress) -> None:
        self.pace(progress)
        reached = progress.stage, progress.tiles_done
        self.begun = self.begun or reached
        self.came_further |= reached != self.begun
        now = time.monotonic()
        if progress.stage == self.stage and now - self.written < _PROGRESS_SECONDS:
            return
        self.stage, self.written = progress.stage, now
        try:
            self.jobs.record_progress(self.lease.record.id, dataclasses.asdict(progress), self.lease.owner)
        except SQLAlchemyError:  # the next one will do; and if the database stays away, the lease runs out
            _log.exception("progress of job %s could not be recorded", self.lease.record.id)

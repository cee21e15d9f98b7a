"""Runs jobs on the cluster under leases: several at a time, with submitters taking turns."""

import collections
import dataclasses
import itertools
import logging
import threading
import time
from datetime import UTC, datetime
from typing import Any

from service.logs import about_job
from service.problems import kind_of, without_paths
from service.records.engine import DatabaseError
from service.records.job_record import JobRecord, JobState
from service.records.jobs import Jobs, LargeJobsOf
from service.records.lease import Lease
from service.records.replica import replica_name
from service.runner import metrics as run_metrics
from worker.cluster.connection import ReconnectingCluster
from worker.cluster.driver import Driver
from worker.errors import ClusterFailed, JobCancelled, LeaseLost, WorkerError
from worker.kinds import KINDS
from worker.progress import Progress, Stage
from worker.run import run_job
from worker.storage.location import remove_rootless, result_location

_log = logging.getLogger("rattle.runner")
# Jobs submitted to other replicas are found by polling.
_POLL_SECONDS = 0.5
# How soon a cancellation sent to another replica is noticed. A lease lasts many times longer.
_RENEW_SECONDS = 0.5
_CHECK_DEAD_SECONDS = 2.0
_PROGRESS_SECONDS = 0.25
_STOP_SECONDS = 4.0
# A job that loses the cluster this often without progress is itself the cause.
_LOSSES = 5


Ends = dict[JobState, JobState]
"""New state of a job that stops running, by its state at that moment."""
_STOPPED: Ends = {JobState.CANCELLING: JobState.CANCELLED, JobState.RUNNING: JobState.QUEUED}
_FAILED: Ends = {each: JobState.FAILED for each in (JobState.RUNNING, JobState.CANCELLING)}
# A cancellation may arrive after the last tile. The result is complete, so the job has succeeded.
_SUCCEEDED: Ends = {each: JobState.SUCCEEDED for each in (JobState.RUNNING, JobState.CANCELLING)}


class Runner:
    """Threads that run jobs: one claims them, one renews their leases, and each job has its own.

    Guarantees. A claimed job ends in a final state; or it goes back to the queue, if the runner stops or the cluster is
    lost; or it is left to another replica, if its lease is lost, and nothing more is written. A cancellation is noticed
    within half a second, and tiles stop between two bands. Replicas share the jobs of one database. The jobs of a dead
    replica are taken over when its leases run out, or at once if this machine can see that it is dead.

    Parameters
    ----------
    jobs : Jobs
    cluster : ReconnectingCluster
    results : str
        Folder of the Zarr stores.
    most : int
        Number of slots: jobs that run at a time. If there are several, the last one is reserved for small jobs, and the
        one before it for small jobs and for submitters that have nothing running.
    """

    def __init__(self, jobs: Jobs, cluster: ReconnectingCluster, results: str, most: int) -> None:
        self.jobs, self.cluster, self.results, self.most = jobs, cluster, results, most
        self._name = replica_name()
        self._claims = itertools.count(1)
        self._wake = threading.Event()
        self._stopping = threading.Event()
        self._lock = threading.Lock()
        self._leases: dict[str, Lease] = {}
        self._threads: dict[str, threading.Thread] = {}
        self._losses: collections.Counter[str] = collections.Counter()
        self._checked_dead = -_CHECK_DEAD_SECONDS
        self._claiming = threading.Thread(target=self._claim_jobs, name="rattle-claims", daemon=True)
        self._renewing = threading.Thread(target=self._keep_leases, name="rattle-leases", daemon=True)

    def start(self) -> None:
        """Start the threads."""
        self._claiming.start()
        self._renewing.start()

    def stop(self) -> None:
        """Stop the threads. Running jobs go back to the queue."""
        self._stopping.set()
        self._wake.set()
        deadline = time.monotonic() + _STOP_SECONDS
        self._claiming.join(_STOP_SECONDS)
        for lease in self._held():
            lease.cancel.set()
        for thread in list(self._threads.values()):
            thread.join(max(0.0, deadline - time.monotonic()))

    def wake(self) -> None:
        """Announce that a job has been submitted."""
        self._wake.set()

    def cancel(self, job_id: str) -> None:
        """Stop a job if it runs here. If it runs elsewhere, that replica reads the cancellation from the database."""
        with self._lock:
            if job_id in self._leases:
                self._leases[job_id].cancel.set()

    def workers(self) -> int:
        """Number of workers that the scheduler knows; 0 if it does not answer."""
        return self.cluster.workers()

    def _held(self) -> list[Lease]:
        with self._lock:
            return list(self._leases.values())

    def _claim_jobs(self) -> None:
        while not self._stopping.is_set():
            self._wake.clear()
            try:
                claimed = self._claim()
            except DatabaseError:
                _log.exception("the database did not answer; trying again")
                claimed = False
            if not claimed:
                self._wake.wait(_POLL_SECONDS)

    def _claim(self) -> bool:
        """Start one more job if there is a free slot, a cluster and a job. Returns whether one was started."""
        running = [lease.record for lease in self._held()]
        if time.monotonic() - self._checked_dead >= _CHECK_DEAD_SECONDS:
            self.jobs.end_dead_leases()
            self._checked_dead = time.monotonic()
        if len(running) >= self.most > 0:
            return False
        driver = self.cluster.driver()
        if driver is None or self.most == 0:
            return False
        asked = time.monotonic()
        owner, own = f"{self._name}/{next(self._claims)}", [record.id for record in running]
        record = self.jobs.claim(owner, exclude=own, large=self._large(running))
        if record is None:
            return False
        lease = Lease(record, asked)
        thread = threading.Thread(target=self._run, args=(lease, driver), name=f"rattle-{record.id}", daemon=True)
        with self._lock:
            self._leases[record.id], self._threads[record.id] = lease, thread
        thread.start()
        return True

    def _large(self, running: list[JobRecord]) -> LargeJobsOf:
        """Submitters whose large jobs may start, given the jobs that run."""
        left = self.most - sum(not record.small for record in running)
        if left <= 1 < self.most:
            return LargeJobsOf.NOBODY
        return LargeJobsOf.IDLE if left == 2 < self.most else LargeJobsOf.ANYONE

    def _keep_leases(self) -> None:
        while not self._stopping.wait(_RENEW_SECONDS):
            leases, asked = self._held(), time.monotonic()
            try:
                states = self.jobs.renew([lease.owner for lease in leases]) if leases else {}
            except DatabaseError:
                _log.exception("leases could not be renewed; trying again")
                continue
            for lease in leases:
                # A lease that has run out is not renewed: its driver may have stopped already.
                if lease.owner in states and not lease.lost:
                    lease.renewed(asked, states[lease.owner])
                elif not lease.ending:
                    lease.release()

    def _run(self, lease: Lease, driver: Driver) -> None:
        with about_job(lease.record.id):
            self._run_claimed(lease, driver)

    def _run_claimed(self, lease: Lease, driver: Driver) -> None:
        record = lease.record
        _log.info("started: %s of %s", record.kind, record.submitter)
        if record.progress is None:
            run_metrics.job_started((datetime.now(UTC) - record.created.replace(tzinfo=UTC)).total_seconds())
        try:
            ends, values = self._compute(lease, driver)
            if not lease.lost:
                self._record_end(lease, ends, values)
            if lease.lost:
                run_metrics.lease_lost()
                _log.warning(
                    "job %s may have been taken over by another replica: its end is not recorded here", lease.record.id
                )
        finally:
            with self._lock:
                del self._leases[lease.record.id], self._threads[lease.record.id]
            self._wake.set()

    def _compute(self, lease: Lease, driver: Driver) -> tuple[Ends, dict[str, Any]]:
        record, report = lease.record, _Throttled(self.jobs, lease)
        try:
            location = result_location(self.results, record.store or record.id)
            job = KINDS[record.kind].job_class.trusted(record.request, record.digest)
            lease.check()
            remove_rootless(location)
            run_job(job, location, driver, report=report, cancel=lease.cancel, fence=lease.check)
        except (JobCancelled, LeaseLost):
            return _STOPPED, {}
        except Exception as error:
            lost = isinstance(error, ClusterFailed) or driver.client.status != "running"
            if lost and self._may_retry(record.id, report.advanced):
                _log.warning("job %s is queued again: %s", record.id, error)
                return _STOPPED, {}
            if not isinstance(error, WorkerError):
                _log.exception("job failed")
            detail = str(error) if isinstance(error, WorkerError) else repr(error)
            return _FAILED, {"error": {"kind": kind_of(error), "detail": without_paths(detail, self.results)}}
        finally:
            report.pace.end()
        return _SUCCEEDED, {}

    def _may_retry(self, job_id: str, advanced: bool) -> bool:
        """Whether a job that has lost the cluster goes back to the queue."""
        self._losses[job_id] = 1 if advanced else self._losses[job_id] + 1
        return self._losses[job_id] < _LOSSES

    def _record_end(self, lease: Lease, ends: Ends, values: dict[str, Any]) -> None:
        lease.ending = True
        while not lease.lost:
            try:
                for expected, state in ends.items():
                    if self.jobs.transition(lease.record.id, expected, state, owner=lease.owner, **values):
                        self._note_end(lease, state)
                        return
                lease.release()
            except DatabaseError:
                _log.exception("the end of job %s could not be recorded; trying again", lease.record.id)
                time.sleep(_POLL_SECONDS)

    def _note_end(self, lease: Lease, state: JobState) -> None:
        if state.final:
            _log.info("ended: %s", state)
            self._losses.pop(lease.record.id, None)
            run_metrics.job_ended(state)


class _Throttled:
    """Writes a job's progress to its record, a few times a second, and each new stage at once."""

    def __init__(self, jobs: Jobs, lease: Lease) -> None:
        self.jobs, self.lease = jobs, lease
        self.stage: Stage | None = None
        self.written = 0.0
        self.first: tuple[Stage, int] | None = None
        self.advanced = False
        self.pace = run_metrics.Pace()

    def __call__(self, progress: Progress) -> None:
        if progress.stage is not Stage.COMPILING:  # in which nothing advances
            self.pace(progress)
            reached = progress.stage, progress.tiles_done
            self.first = self.first or reached
            self.advanced |= reached != self.first
        now = time.monotonic()
        if progress.stage == self.stage and now - self.written < _PROGRESS_SECONDS:
            return
        self.stage, self.written = progress.stage, now
        try:
            self.jobs.record_progress(self.lease.record.id, dataclasses.asdict(progress), self.lease.owner)
        except DatabaseError:  # the next report will do; if the database stays away, the lease runs out
            _log.exception("progress of job %s could not be recorded", self.lease.record.id)

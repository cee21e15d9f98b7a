"""A job that this replica has claimed, and how long it may believe so."""

import threading
import time

from service.records.job_record import JobRecord, JobState
from service.records.jobs import LEASE_SECONDS
from worker.errors import LeaseLost

# A replica stops writing so long before another one may begin: what it had begun to write has been written by then.
_MARGIN_SECONDS = 5.0


class Lease:
    """One claim of a job.

    Guarantees. `check` passes only while no other replica can have taken the job over: time is counted by this
    machine's own clock from a moment before the database renewed the lease, so it runs out here first, also where this
    process was stopped for a while, or cannot reach the database.

    Parameters
    ----------
    record : JobRecord
        As claimed.
    asked : float
        Time before it was, of `time.monotonic`.
    """

    def __init__(self, record: JobRecord, asked: float) -> None:
        assert record.lease_owner is not None
        self.record, self.owner = record, record.lease_owner
        self.cancel = threading.Event()
        self.ending = False
        """Whether its job's end is being recorded, after which the database knows of no lease."""
        self._good_until = asked + LEASE_SECONDS - _MARGIN_SECONDS
        self._lost = False

    @property
    def lost(self) -> bool:
        """Whether another replica may have the job."""
        return self._lost or time.monotonic() > self._good_until

    def check(self) -> None:
        """Fence of the job's driver.

        Raises
        ------
        LeaseLost
        """
        if self.lost:
            raise LeaseLost(f"job {self.record.id} may be another replica's by now")

    def renewed(self, asked: float, state: JobState) -> None:
        """Note that the database has renewed it, and what the job's state is."""
        self._good_until = asked + LEASE_SECONDS - _MARGIN_SECONDS
        if state == JobState.CANCELLING:
            self.cancel.set()

    def lose(self) -> None:
        """Give it up, and stop the driver."""
        self._lost = True
        self.cancel.set()

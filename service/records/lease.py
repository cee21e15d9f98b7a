"""A job that this replica has claimed, and the time until which the claim holds."""

import threading
import time

from service.records.job_record import JobRecord, JobState
from service.records.jobs import LEASE_SECONDS
from worker.errors import LeaseLost

# A replica stops writing this long before another may begin, so that writes under way are finished by then.
_MARGIN_SECONDS = 5.0


class Lease:
    """One claim of a job.

    Guarantees. `check` passes only while no other replica can have taken the job over. Time is measured with this
    machine's clock, from a moment before the database renewed the lease. So the lease runs out here first, even if this
    process was paused or cannot reach the database.

    Parameters
    ----------
    record : JobRecord
        As claimed.
    asked : float
        Time of `time.monotonic` before it was claimed.
    """

    def __init__(self, record: JobRecord, asked: float) -> None:
        assert record.lease_owner is not None
        self.record, self.owner = record, record.lease_owner
        self.cancel = threading.Event()
        self.ending = False
        """Whether the end of the job is being recorded, after which the database holds no lease."""
        self._good_until = asked + LEASE_SECONDS - _MARGIN_SECONDS
        self._lost = False

    @property
    def lost(self) -> bool:
        """Whether another replica may have taken over the job."""
        return self._lost or time.monotonic() > self._good_until

    def check(self) -> None:
        """Fence of the job's driver: raise once another replica may have the job.

        Raises
        ------
        LeaseLost
        """
        if self.lost:
            raise LeaseLost(f"job {self.record.id} may have been taken over by another replica")

    def renewed(self, asked: float, state: JobState) -> None:
        """Extend the lease, as the database has, and stop the driver if the job is being cancelled."""
        self._good_until = asked + LEASE_SECONDS - _MARGIN_SECONDS
        if state == JobState.CANCELLING:
            self.cancel.set()

    def release(self) -> None:
        """Give up the lease, and stop the driver."""
        self._lost = True
        self.cancel.set()

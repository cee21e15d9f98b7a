"""Deletes results that nobody has read for long, and the longest unread ones where all together take too much room."""

import logging
import threading
from datetime import UTC, datetime, timedelta

from service.records.engine import DatabaseError
from service.records.jobs import Jobs
from service.records.reads import Ended, Reads
from service.runner import metrics as run_metrics
from worker.errors import WorkerError
from worker.storage.location import bytes_of_result, remove_result, result_location

_log = logging.getLogger("rattle.retention")
_EVERY_SECONDS = 600.0
# A result that was read within this time is being read: a reader of chunks comes back for the next.
_BEING_READ = timedelta(hours=1)
_GIGABYTE = 10**9


class Retention:
    """Deletes jobs that have ended, with their results, as ``DELETE /v1/jobs/ID`` does.

    Guarantees. A job that is queued or runs is never deleted, nor a store that such a job goes on from. A result that
    was read within the last hour, through any replica, stays, whatever the limits.

    Parameters
    ----------
    jobs : Jobs
    reads : Reads
    results : str
        Folder of all results.
    keep_days : float or None
        Results that were neither finished nor read for so many days are deleted.
    keep_gb : float or None
        Results of ended jobs may take so many gigabytes (1e9 bytes). Beyond, the longest unread are deleted.
    """

    def __init__(
        self, jobs: Jobs, reads: Reads, results: str, keep_days: float | None, keep_gb: float | None
    ) -> None:  # fmt: skip
        self._jobs, self._reads, self._results = jobs, reads, results
        self._age = None if keep_days is None else timedelta(days=keep_days)
        self._bytes = None if keep_gb is None else keep_gb * _GIGABYTE
        self._sizes: dict[str, int] = {}

    def start(self) -> None:
        """Look every ten minutes, if there is a limit, until the process ends."""
        if self._age is not None or self._bytes is not None:
            threading.Thread(target=self._keep_looking, name="rattle-retention", daemon=True).start()

    def _keep_looking(self) -> None:
        stopping = threading.Event()
        while True:
            try:
                self.look()
            except (DatabaseError, WorkerError):
                _log.exception("old results could not be deleted; trying again")
            stopping.wait(_EVERY_SECONDS)

    def look(self, now: datetime | None = None) -> list[str]:
        """Delete what is too old or too much.

        Parameters
        ----------
        now : datetime, optional

        Returns
        -------
        list of str
            Ids of the deleted jobs.
        """
        now = now or datetime.now(UTC)
        self._reads.forget_deleted()
        ended, deleted = self._reads.ended(), []
        if self._age is not None:
            old = [each for each in ended if now - each.used > self._age]
            deleted += [each.id for each in old if self._delete(each, now) is not None]
        if self._bytes is not None:
            left = [each for each in ended if each.id not in deleted]
            taken = sum(self._size(store) for store in {each.store for each in left})
            for each in left:
                if taken <= self._bytes:
                    break
                if (freed := self._delete(each, now)) is not None:
                    taken -= freed
                    deleted.append(each.id)
        return deleted

    def _size(self, store: str) -> int:
        """Bytes of a store, which no longer changes."""
        if store not in self._sizes:
            self._sizes[store] = bytes_of_result(result_location(self._results, store))
        return self._sizes[store]

    def _delete(self, ended: Ended, now: datetime) -> int | None:
        """Delete one job, unless it is being read: the bytes that this frees, or None."""
        last = self._reads.last(ended.id)
        if last is not None and now - last < _BEING_READ:
            return None
        freed = 0
        if (store := self._jobs.release_store(ended.id)) is not None:
            freed = self._size(store)
            remove_result(result_location(self._results, store))
        self._jobs.delete(ended.id)
        self._sizes.pop(ended.store, None)
        run_metrics.result_deleted()
        _log.info("deleted job %s, which nobody has read since %s", ended.id, f"{ended.used:%Y-%m-%d %H:%M}")
        return freed

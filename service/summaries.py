"""Summaries of results as they are sent, kept while they hold: to read one from its store costs ten status reads."""

import threading
import time
from collections import OrderedDict
from dataclasses import dataclass, field

from service.conditional import etag_of
from service.job_record import JobRecord, JobState
from service.result_view import place_of_result, result_view

# As often as a driver writes down what it has done.
_WHILE_IT_RUNS_SECONDS = 0.5
_MOST, _MOST_BYTES = 1000, 1 << 25


@dataclass
class _Kept:
    """One summary, of a job in a state; its lock lets one thread read the store for all who ask."""

    lock: threading.Lock = field(default_factory=threading.Lock)
    state: JobState | None = None
    until: float = 0.0
    told: tuple[str, str] = "", ""

    def holds(self, record: JobRecord) -> bool:
        """Whether it is still what the store would say."""
        return self.state == record.state and (record.state is JobState.SUCCEEDED or time.monotonic() < self.until)


class Summaries:
    """The summaries that were asked for last.

    Guarantees. What is told of a job in a final state is that of its end, however soon it is asked; what is told of
    one that runs is at most half a second old. Memory is bounded.

    Parameters
    ----------
    results : str
        Folder of the Zarr stores.
    """

    def __init__(self, results: str) -> None:
        self._results = results
        self._lock = threading.Lock()
        self._kept: OrderedDict[str, _Kept] = OrderedDict()

    def at_hand(self, record: JobRecord) -> tuple[str, str] | None:
        """What `of` would say, where that takes no reading."""
        with self._lock:
            kept = self._kept.get(record.id)
            if kept is not None:
                self._kept.move_to_end(record.id)
        # Its own lock is not waited for, as another thread may hold it while it reads the store.
        return kept.told if kept is not None and kept.holds(record) else None

    def of(self, record: JobRecord) -> tuple[str, str]:
        """Summary of a job's result as JSON, and its ETag.

        Raises
        ------
        NotReady, StoreConflict, StoreFailed
        """
        with self._lock:
            kept = self._kept.setdefault(record.id, _Kept())
            self._kept.move_to_end(record.id)
            if len(self._kept) > _MOST:
                self._kept.popitem(last=False)
        with kept.lock:
            if not kept.holds(record):
                self._read(kept, record)
                self._make_room()
            return kept.told

    def _read(self, kept: _Kept, record: JobRecord) -> None:
        begin = time.monotonic()
        location = place_of_result(record, self._results)
        view = result_view(record.kind, location, f"/v1/jobs/{record.id}/result.zarr")
        body = view.model_dump_json()
        kept.told = body, etag_of(body)
        kept.state, kept.until = record.state, begin + _WHILE_IT_RUNS_SECONDS

    def _make_room(self) -> None:
        with self._lock:
            while len(self._kept) > 1 and sum(len(each.told[0]) for each in self._kept.values()) > _MOST_BYTES:
                self._kept.popitem(last=False)

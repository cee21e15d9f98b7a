"""Summaries of results as they are sent, kept while they hold: to read one from its store costs ten status reads."""

import threading
import time
from typing import NamedTuple

from service.answers.conditional import Told, told
from service.answers.kept_answers import MOST_BYTES, KeptAnswers
from service.answers.result_view import place_of_result, result_view
from service.records.job_record import JobRecord, JobState

# As often as a driver writes down what it has done.
_WHILE_IT_RUNS_SECONDS = 0.5
_READERS = 64


class _Moment(NamedTuple):
    """What a job was when its store was read, and until when that holds if it was not final."""

    state: JobState
    until: float

    def holds(self, record: JobRecord) -> bool:
        """Whether the store would still say the same."""
        return self.state == record.state and (record.state is JobState.SUCCEEDED or time.monotonic() < self.until)


class Summaries:
    """The summaries that were asked for last.

    Guarantees. What is told of a job in a final state is that of its end, however soon it is asked; what is told of
    one that runs is at most half a second old. Memory is bounded.

    Parameters
    ----------
    results : str
        Folder of the Zarr stores.
    most_bytes : int
        That are kept.
    """

    def __init__(self, results: str, most_bytes: int = MOST_BYTES) -> None:
        self._results = results
        self._kept: KeptAnswers[_Moment] = KeptAnswers(most_bytes)
        self._reading = [threading.Lock() for _ in range(_READERS)]

    def at_hand(self, record: JobRecord) -> Told | None:
        """What `of` would say, where that takes no reading."""
        kept = self._kept.get(record.id)
        return kept[1] if kept is not None and kept[0].holds(record) else None

    def of(self, record: JobRecord) -> Told:
        """Summary of a job's result as JSON, and its ETag.

        Raises
        ------
        NotReady, StoreConflict, StoreFailed
        """
        # One thread reads the store for all who ask, and seldom makes those wait who ask for another one.
        with self._reading[hash(record.id) % _READERS]:
            return self.at_hand(record) or self._read(record)

    def _read(self, record: JobRecord) -> Told:
        until = time.monotonic() + _WHILE_IT_RUNS_SECONDS
        location = place_of_result(record, self._results)
        view = result_view(record.kind, location, f"/v1/jobs/{record.id}/result.zarr")
        return self._kept.keep(record.id, _Moment(record.state, until), told(view.model_dump_json()))

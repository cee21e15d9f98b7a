"""Answers that were asked for last, kept so that they need not be made again."""

import contextlib
import threading
from typing import Generic, TypeVar

from cachetools import LRUCache

from service.answers.conditional import Told

_State = TypeVar("_State")
MOST_BYTES = 1 << 25
# An answer of a hundred bytes takes more than those.
_BYTES_BESIDES = 1024


class KeptAnswers(Generic[_State]):
    """Answers about jobs, each with the state of the job that it was made of. Many threads may share one.

    Parameters
    ----------
    most_bytes : int
        What was asked for long ago makes room beyond that.
    """

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        self._lock = threading.Lock()
        self._kept: LRUCache[str, tuple[_State, Told]] = LRUCache(most_bytes, getsizeof=_size)

    def get(self, job_id: str) -> tuple[_State, Told] | None:
        """What was kept last about a job, and of which state."""
        with self._lock:
            return self._kept.get(job_id)

    def keep(self, job_id: str, state: _State, answer: Told) -> Told:
        """Keep an answer, unless it alone is larger than all may be; the same answer."""
        with self._lock, contextlib.suppress(ValueError):
            self._kept[job_id] = state, answer
        return answer


def _size(kept: tuple[object, Told]) -> int:
    return _BYTES_BESIDES + len(kept[1].body)

"""Cyclic garbage is looked for less often while libraries and kernels are loaded."""

import contextlib
import gc
import threading
from collections.abc import Iterator

# Objects that come before garbage is looked for, in place of Python's 700 or 2,000.
_OBJECTS_A_COLLECTION = 100_000


class _UnderWay:
    """How many contexts there are, in all threads, and the caller's thresholds."""

    def __init__(self) -> None:
        self.lock, self.number = threading.Lock(), 0
        self.thresholds = gc.get_threshold()


_under_way = _UnderWay()


@contextlib.contextmanager
def fewer_collections() -> Iterator[None]:
    """Look for cyclic garbage less often: of the seconds that libraries and kernels take to load it would take a fifth.

    The caller's thresholds are back when the last of these contexts ends. A caller whose threshold is higher, or who
    has switched it off, keeps that.
    """
    with _under_way.lock:
        _under_way.number += 1
        if _under_way.number == 1:
            _under_way.thresholds = first, *others = gc.get_threshold()
            gc.set_threshold(max(first, _OBJECTS_A_COLLECTION) if first else 0, *others)
    try:
        yield
    finally:
        with _under_way.lock:
            _under_way.number -= 1
            if not _under_way.number:
                gc.set_threshold(*_under_way.thresholds)

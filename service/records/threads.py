"""Threads for the most frequent database queries: few of them, or none.

FastAPI runs plain functions in forty threads. Once responses are late, all forty query at once, and spend more time on
the GIL and on new connections than on responses. A service at 300 requests a second then fell to 200, and stayed
there (`docs/decisions/0025-reads-in-the-loop.md`).
"""

from collections.abc import Callable
from typing import TypeVar, TypeVarTuple

from anyio import CapacityLimiter, to_thread

_T = TypeVar("_T")
_Ts = TypeVarTuple("_Ts")
_READING, _WRITING = 4, 4


class DatabaseThreads:
    """Runs functions in a few threads. Those that only read share no threads with those that may wait for a writer.

    It must be created where an event loop runs.

    Parameters
    ----------
    near : bool
        Whether the database is a local file. SQLite's readers never wait, and a read takes half a millisecond, as long
        as a switch to a thread and back. So reads run in the event loop.
    """

    def __init__(self, near: bool) -> None:
        self._near = near
        self._reading, self._writing = CapacityLimiter(_READING), CapacityLimiter(_WRITING)

    async def read(self, function: Callable[[*_Ts], _T], *arguments: *_Ts) -> _T:
        """Result of a function that only reads the database."""
        if self._near:
            return function(*arguments)
        return await to_thread.run_sync(function, *arguments, limiter=self._reading)

    async def read_many(self, function: Callable[[*_Ts], _T], *arguments: *_Ts) -> _T:
        """Result of a function that reads many records, which takes longer than a switch to a thread."""
        return await to_thread.run_sync(function, *arguments, limiter=self._reading)

    async def write(self, function: Callable[[*_Ts], _T], *arguments: *_Ts) -> _T:
        """Result of a function that may write to the database."""
        return await to_thread.run_sync(function, *arguments, limiter=self._writing)

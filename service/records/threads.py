"""Where the most frequent requests ask the database: in few threads, or in none.

FastAPI runs plain functions in forty threads. Once answers are late, forty of them ask at once, and spend more time on
taking Python's lock from each other, and on opening connections, than on answers: a service that answered 300 requests
a second fell to 200 at a hiccup, and stayed there (`docs/decisions/0025-reads-in-the-loop.md`).
"""

from collections.abc import Callable
from typing import TypeVar, TypeVarTuple

from anyio import CapacityLimiter, to_thread

_T = TypeVar("_T")
_Ts = TypeVarTuple("_Ts")
_READING, _WRITING = 4, 4


class DatabaseThreads:
    """Runs functions in few threads, those that only read apart from those that may wait for a writer.

    To be made where an event loop runs.

    Parameters
    ----------
    near : bool
        Whether the database is a file of this process: SQLite's readers wait for nobody, and what is read there in half
        a millisecond is read at once, as the way to a thread and back costs as much.
    """

    def __init__(self, near: bool) -> None:
        self._near = near
        self._reading, self._writing = CapacityLimiter(_READING), CapacityLimiter(_WRITING)

    async def read(self, function: Callable[[*_Ts], _T], *arguments: *_Ts) -> _T:
        """What a function returns that only reads."""
        if self._near:
            return function(*arguments)
        return await to_thread.run_sync(function, *arguments, limiter=self._reading)

    async def write(self, function: Callable[[*_Ts], _T], *arguments: *_Ts) -> _T:
        """What a function returns that may write."""
        return await to_thread.run_sync(function, *arguments, limiter=self._writing)

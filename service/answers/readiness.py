"""Whether what the service needs is there, asked so that nobody waits long for the answer."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from anyio import to_thread

_T = TypeVar("_T")
_PATIENCE_SECONDS = 3.0
_PAUSE_SECONDS = 0.1


class Probe(Generic[_T]):
    """A question that may hang, as one to a scheduler that is there but stopped.

    Guarantees. An answer comes within three seconds; one thread at the most is kept waiting, however often it is asked.

    Parameters
    ----------
    ask : callable
    failed : object
        The answer in place of one that does not come.
    """

    def __init__(self, ask: Callable[[], _T], failed: _T) -> None:
        self._ask, self._failed = ask, failed
        self._asking: asyncio.Task[_T] | None = None

    async def __call__(self) -> _T:
        """Ask, or wait for the answer to who has asked before."""
        if self._asking is None or self._asking.done():
            self._asking = asyncio.create_task(self._asked())
        try:
            return await asyncio.wait_for(asyncio.shield(self._asking), _PATIENCE_SECONDS)
        except TimeoutError:
            return self._failed

    async def _asked(self) -> _T:
        return await to_thread.run_sync(self._ask, abandon_on_cancel=True)


@dataclass(frozen=True)
class Probes:
    """Whether the database answers, and how many workers there are."""

    database: Probe[bool]
    workers: Callable[[], int]

    async def until_ready(self) -> None:
        """Wait until the database answers, and there is a worker."""
        while not (self.workers() and await self.database()):
            await asyncio.sleep(_PAUSE_SECONDS)

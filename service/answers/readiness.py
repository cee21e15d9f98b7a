"""Whether the service has what it needs. The answer takes seconds at most, even if a part hangs."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from anyio import to_thread

_T = TypeVar("_T")
_TIMEOUT_SECONDS = 3.0
_PAUSE_SECONDS = 0.1


class Probe(Generic[_T]):
    """A check that may hang, for example on a database server that is paused.

    Guarantees. A call returns within three seconds. However many calls there are, at most one thread waits.

    Parameters
    ----------
    ask : callable
    failed : object
        Result if the check does not return in time.
    """

    def __init__(self, ask: Callable[[], _T], failed: _T) -> None:
        self._ask, self._failed = ask, failed
        self._asking: asyncio.Task[_T] | None = None

    async def __call__(self) -> _T:
        """Run the check, or wait for the one that is already running."""
        if self._asking is None or self._asking.done():
            self._asking = asyncio.create_task(self._asked())
        try:
            return await asyncio.wait_for(asyncio.shield(self._asking), _TIMEOUT_SECONDS)
        except TimeoutError:
            return self._failed

    async def _asked(self) -> _T:
        return await to_thread.run_sync(self._ask, abandon_on_cancel=True)


@dataclass(frozen=True)
class Probes:
    """Whether the database answers, and the number of workers."""

    database: Probe[bool]
    workers: Callable[[], int]

    async def until_ready(self) -> None:
        """Wait until the database answers, and there is a worker."""
        while not (self.workers() and await self.database()):
            await asyncio.sleep(_PAUSE_SECONDS)

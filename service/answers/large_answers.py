"""A few places for answers that grow with a job: pictures, tables, outlines, overlays, tiles, motions.

Each may take a hundred megabytes while it is made. A place is held until the client has the answer.
"""

import asyncio
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from rattle_kernels.numerics.compiled_apart import compiled_apart
from service.errors import TooMuch

_PLACES, _MOST_WAITING, _WAITING_SECONDS = 4, 64, 20.0


class LargeAnswers:
    """Places for large answers. It must be used from one event loop.

    Guarantees. Four are made and sent at a time, and 64 wait. Kernels that they need first are compiled in another
    process.
    """

    def __init__(self) -> None:
        self._stopped = threading.Event()
        self._places = asyncio.Semaphore(_PLACES)
        self._inside = 0

    def close(self) -> None:
        """Wait for no kernel any more: the service stops."""
        self._stopped.set()

    def _leave(self) -> None:
        if self._stopped.is_set():
            raise TooMuch("the service is stopping: try again when it is back", 5)

    @asynccontextmanager
    async def place(self) -> AsyncIterator[None]:
        """Wait for a place, and hold it.

        Raises
        ------
        TooMuch
            If too many wait, or none becomes free.
        """
        if self._inside >= _PLACES + _MOST_WAITING:
            raise TooMuch(f"{_MOST_WAITING} large answers are waited for: try again in a second", 1)
        self._inside += 1
        try:
            try:
                async with asyncio.timeout(_WAITING_SECONDS):
                    await self._places.acquire()
            except TimeoutError:
                raise TooMuch(
                    f"{_PLACES} large answers have been made for {_WAITING_SECONDS:g} s: try again", 5
                ) from None
            try:
                # Threads take this context with them.
                with compiled_apart(self._leave):
                    yield
            finally:
                self._places.release()
        finally:
            self._inside -= 1

"""A few places for answers that grow with a job: pictures, tables, outlines, overlays, tiles, motions.

Each may take a hundred megabytes while it is made. A place is held until the client has the answer.
"""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from service.errors import TooMuch

_PLACES, _MOST_WAITING, _WAITING_SECONDS = 4, 64, 20.0


class LargeAnswers:
    """Places for large answers. It must be used from one event loop.

    Guarantees. Four are made and sent at a time, and 64 wait.
    """

    def __init__(self) -> None:
        self._places = asyncio.Semaphore(_PLACES)
        self._inside = 0

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
                yield
            finally:
                self._places.release()
        finally:
            self._inside -= 1

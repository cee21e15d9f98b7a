"""Loaded by every worker of the fault tests: writes down which tiles are started, and knows a tile that kills.

Named in ``DASK_DISTRIBUTED__WORKER__PRELOAD``; the service knows nothing of it.
"""

import os
import signal
from functools import wraps

from worker.basins import tasks

POISON = 0.6180339887
"""Damping of an oscillator whose tiles kill their worker."""


def _written_down(function, path):
    """A task that first writes a line into a file that outlives the worker: which tile it starts."""
    file = os.open(path, os.O_APPEND | os.O_CREAT | os.O_WRONLY)

    @wraps(function)
    def map_tile(location, digest, number):
        os.write(file, f"{os.getpid()} {number}\n".encode())
        return function(location, digest, number)

    return map_tile


def _poisoned(function):
    def map_bands(oscillator, *arguments, **options):
        if oscillator.damping == POISON:
            os.kill(os.getpid(), signal.SIGKILL)
        return function(oscillator, *arguments, **options)

    return map_bands


async def dask_setup(worker):
    """Install both."""
    tasks.map_bands = _poisoned(tasks.map_bands)
    if path := os.environ.get("RATTLE_STARTS"):
        tasks.map_tile = _written_down(tasks.map_tile, path)

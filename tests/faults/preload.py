"""Loaded by every worker of the fault tests: writes down which tasks are started, and knows a tile that kills.

Named in ``DASK_DISTRIBUTED__WORKER__PRELOAD``; the service knows nothing of it.
"""

import os
import signal

from distributed import WorkerPlugin

from worker.basins import tasks

POISON = 0.6180339887
"""Damping of an oscillator whose tiles kill their worker."""


class StartsLog(WorkerPlugin):
    """One line for each start of a task, in a file that outlives the worker."""

    def __init__(self, path):
        self.file = os.open(path, os.O_APPEND | os.O_CREAT | os.O_WRONLY)

    def transition(self, key, start, finish, **_):
        if finish == "executing":
            os.write(self.file, f"{os.getpid()} {key}\n".encode())


def _poisoned(function):
    def map_cells(oscillator, *arguments, **options):
        if oscillator.damping == POISON:
            os.kill(os.getpid(), signal.SIGKILL)
        return function(oscillator, *arguments, **options)

    return map_cells


async def dask_setup(worker):
    """Install both."""
    tasks.map_cells = _poisoned(tasks.map_cells)
    if path := os.environ.get("RATTLE_STARTS"):
        await worker.plugin_add(StartsLog(path), name="starts-log")

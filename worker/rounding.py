"""What is computed for one store is rounded in one way: with fused multiply-add (FMA) throughout, or without.

A processor without it gives other bytes, so a tile that is computed again would differ from what others were made of.
A store notes how it was begun. The driver looks before it goes on, as it computes itself (it continues attractors from
basin to basin), and each worker when it opens the store for a task: a list of workers that is requested when a job
begins would miss those that join later.
"""

import logging
import os
import socket
from typing import Any

from rattle_kernels.numerics.fused_multiply_add import fuses_multiply_add
from worker.errors import StoreConflict, UnlikeWorkers

_log = logging.getLogger("rattle.rounding")
FUSED = "fused_multiply_add"
"""Attribute of a store: whether it is computed with FMA."""


def warn_if_unfused() -> None:
    """Say where the kernels of this process are compiled without FMA."""
    if not fuses_multiply_add():
        _log.warning(
            "this processor has no fused multiply-add (FMA), or NUMBA_CPU_NAME names one without it: results differ in "
            "their bytes from those of processors that have it, and a cluster of both kinds is refused"
        )


def demand_same_rounding(
    location: str, attributes: dict[str, Any], error: type[StoreConflict | UnlikeWorkers] = UnlikeWorkers
) -> None:
    """Refuse to compute for a store that was begun in the other way. One from before it was noted is taken.

    Parameters
    ----------
    location : str
    attributes : dict
        Of the store.
    error : type
        What is raised.

    Raises
    ------
    UnlikeWorkers, StoreConflict
    """
    fused = fuses_multiply_add()
    if attributes.get(FUSED, fused) != fused:
        begun, here = ("without", "with") if fused else ("with", "without")
        raise error(
            f"{location} was begun {begun} fused multiply-add (FMA), and process {os.getpid()} on "
            f"{socket.gethostname()} computes {here} it, so their results differ: the cluster needs processors of one "
            "kind, or one NUMBA_CPU_NAME for all; or choose another place, or remove the store"
        )

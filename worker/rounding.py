"""What is computed for one store is rounded in one way: with fused multiply-add (FMA) throughout, or without.

A processor without it gives other bytes, so a tile that is computed again would differ from what others were made of.
A store notes how it was begun, and workers compute as their driver does (`worker.cluster.calls`).
"""

import logging
from typing import Any

from rattle_kernels.numerics.fused_multiply_add import fuses_multiply_add
from worker.errors import StoreConflict

_log = logging.getLogger("rattle.rounding")
FUSED = "fused_multiply_add"
"""Attribute of a store: whether it is computed with FMA."""


def with_or_without(fused: bool) -> str:
    """The way of computing, as messages say it."""
    return "with" if fused else "without"


def warn_if_unfused() -> None:
    """Say where the kernels of this process are compiled without FMA."""
    if not fuses_multiply_add():
        _log.warning(
            "this processor has no fused multiply-add (FMA), or NUMBA_CPU_NAME names one without it: results differ in "
            "their bytes from those of processors that have it, and a cluster of both kinds is refused"
        )


def demand_same_rounding(location: str, attributes: dict[str, Any]) -> None:
    """Refuse to go on with a store that was begun in the other way.

    Parameters
    ----------
    location : str
    attributes : dict
        Of the store. One that was begun before this was noted says nothing, and is taken.

    Raises
    ------
    StoreConflict
    """
    fused = fuses_multiply_add()
    if attributes.get(FUSED, fused) != fused:
        raise StoreConflict(
            f"{location} was begun {with_or_without(not fused)} fused multiply-add (FMA), and this processor computes "
            f"{with_or_without(fused)} it: go on with one of the same kind, choose another place, or remove the store"
        )

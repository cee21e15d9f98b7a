"""Workers compute as their driver does, or not at all: with fused multiply-add (FMA), or without.

The driver computes, too (it continues attractors from panel to panel), so its own way counts. Every task carries it,
and a worker of the other kind refuses, also one that has joined since the job began: no list of workers is as new.
"""

from collections.abc import Callable
from typing import Any

from distributed import get_worker

from rattle_kernels.numerics.fused_multiply_add import fuses_multiply_add
from worker.errors import UnlikeWorkers
from worker.rounding import with_or_without


def compute_alike(fused: bool, function: Callable[..., Any], *arguments: Any) -> Any:
    """Run a task on a worker, if that one computes as the driver does.

    Parameters
    ----------
    fused : bool
        Whether the driver computes with FMA.
    function : callable
    *arguments
        Of the function.

    Raises
    ------
    UnlikeWorkers
    """
    if fuses_multiply_add() != fused:
        raise UnlikeWorkers(
            f"worker {get_worker().address} computes {with_or_without(not fused)} fused multiply-add (FMA), and the "
            f"driver {with_or_without(fused)} it, so their results differ: the cluster needs processors of one kind, "
            "or one NUMBA_CPU_NAME for all"
        )
    return function(*arguments)

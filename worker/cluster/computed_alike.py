"""A worker runs a task only if it computes as the driver does: both with fused multiply-add (FMA), or both without.

The driver also computes: it continues attractors from basin to basin. So every task carries the driver's setting, and
the worker checks it. A check of the list of workers would miss those that join after the job has begun.
"""

from typing import Any

from distributed import get_worker

from rattle_kernels.numerics.fused_multiply_add import fuses_multiply_add
from worker.errors import UnlikeWorkers
from worker.rounding import with_or_without


def compute_alike(call: tuple[Any, ...]) -> Any:
    """Run a task on a worker, if the worker computes as the driver does.

    Parameters
    ----------
    call : tuple
        Whether the driver computes with FMA, the function, and its arguments.

    Raises
    ------
    UnlikeWorkers
    """
    fused, function, *arguments = call
    if fuses_multiply_add() != fused:
        raise UnlikeWorkers(
            f"worker {get_worker().address} computes {with_or_without(not fused)} fused multiply-add (FMA), and the "
            f"driver {with_or_without(fused)} it, so their results differ: the cluster needs processors of one kind, "
            "or one NUMBA_CPU_NAME for all"
        )
    return function(*arguments)

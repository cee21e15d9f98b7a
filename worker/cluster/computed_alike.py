"""A worker runs tasks only if it computes as the driver does: both with fused multiply-add (FMA), or both without.

The driver also computes: it continues attractors from basin to basin. So every call carries the driver's setting, and
the worker checks it. A check of the list of workers would miss those that join after the job has begun.
"""

import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from typing import Any, NamedTuple

from distributed import get_worker, secede

from rattle_kernels.numerics.compiled_apart import compiled_apart
from rattle_kernels.numerics.fused_multiply_add import fuses_multiply_add
from worker.cluster.compiling import telling_of_compilation
from worker.cluster.task import stop_if_cancelled
from worker.errors import UnlikeWorkers
from worker.rounding import with_or_without


class Call(NamedTuple):
    """Tasks of one function that travel to a worker together.

    ``fused`` is whether the driver computes with FMA. Each of ``tasks`` holds a number and further arguments. All run
    inside ``within()``.
    """

    fused: bool
    function: Callable[..., Any]
    location: str
    digest: str
    tasks: Sequence[tuple[Any, ...]]
    within: Callable[[], AbstractContextManager[None]]


class Receipts(NamedTuple):
    """What the tasks of a call returned, and the seconds that they took together."""

    values: list[Any]
    seconds: float


def compute_alike(call: Call) -> Receipts:
    """Run the tasks of a call on a worker, one after another, if the worker computes as the driver does.

    Parameters
    ----------
    call : Call

    Returns
    -------
    Receipts

    Raises
    ------
    UnlikeWorkers
    """
    if fuses_multiply_add() != call.fused:
        raise UnlikeWorkers(
            f"worker {get_worker().address} computes {with_or_without(not call.fused)} fused multiply-add (FMA), and "
            f"the driver {with_or_without(call.fused)} it, so their results differ: the cluster needs processors of "
            "one kind, or one NUMBA_CPU_NAME for all"
        )
    begin = time.perf_counter()
    values = []
    address = call.location, call.digest
    with telling_of_compilation(address), compiled_apart(stop_if_cancelled), call.within():
        for task in call.tasks:
            stop_if_cancelled()
            values.append(call.function(call.location, call.digest, *task))
        seconds = time.perf_counter() - begin
        # What is left to do is to wait for the disk. This thread's place is free meanwhile for the next call.
        secede()
    return Receipts(values, seconds)

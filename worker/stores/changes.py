"""Births and deaths of solutions from one value along an axis of a sweep to the next."""

from typing import Any

import numpy as np

from rattle_kernels import AttractorKind
from worker.jobs.basin_job import BasinJob
from worker.stores.layout import ChangeKind
from worker.stores.solution_table import SolutionTable

_FIELDS = 6


def list_changes(job: BasinJob, table: SolutionTable) -> tuple[np.ndarray, ...]:
    """Births and deaths between neighbouring complete basins, along each axis.

    Parameters
    ----------
    job : BasinJob
    table : SolutionTable

    Returns
    -------
    tuple of ndarray, one length
        Columns as in `layout.CHANGES`: kind, solution, name of the axis, its value before and after, and the value
        of the other axis (NaN if there is none).
    """
    motions = np.array([motion.kind != AttractorKind.UNDECIDED for motion in table.motions], bool)
    there = (np.isfinite(table.share) & motions).reshape(*job.sweep_shape, len(table.motions))
    known = table.complete.reshape(job.sweep_shape)
    rows = [row for axis in range(len(job.axes)) for row in _along(job, axis, there, known)]
    columns = list(zip(*rows, strict=True)) if rows else [()] * _FIELDS
    types: tuple[Any, ...] = (np.int8, np.int16, np.dtypes.StringDType(), np.float64, np.float64, np.float64)
    return tuple(np.array(column, dtype) for column, dtype in zip(columns, types, strict=True))


def _along(job: BasinJob, axis: int, there: np.ndarray, known: np.ndarray) -> list[tuple[object, ...]]:
    there, known = np.moveaxis(there, axis, 0), np.moveaxis(known, axis, 0)
    changed = (there[1:] != there[:-1]) & (known[1:] & known[:-1])[..., None]
    steps, beside = job.axes[axis], [other for at, other in enumerate(job.axes) if at != axis]
    rows: list[tuple[object, ...]] = []
    for place in np.argwhere(changed).tolist():
        step, *other, solution = place
        kind = ChangeKind.BIRTH if there[step + 1, *other, solution] else ChangeKind.DEATH
        value = beside[0].values[other[0]] if beside else np.nan
        rows.append((kind, solution, steps.name, steps.values[step], steps.values[step + 1], value))
    return rows

"""Births and deaths of solutions from one value of a swept parameter to the next."""

from typing import Any

import numpy as np

from rattle_kernels import AttractorKind
from worker.jobs.basin_job import BasinJob
from worker.stores.layout import ChangeKind
from worker.stores.solution_table import SolutionTable

_FIELDS = 6


def list_changes(job: BasinJob, table: SolutionTable) -> tuple[np.ndarray, ...]:
    """Births and deaths between neighbouring complete basins, along each swept parameter.

    Parameters
    ----------
    job : BasinJob
    table : SolutionTable

    Returns
    -------
    tuple of ndarray, one length
        Columns as in `layout.CHANGES`: kind, solution, parameter, its value before and after, and the value of the
        other swept parameter (NaN if there is none).
    """
    motions = np.array([motion.kind != AttractorKind.UNDECIDED for motion in table.motions], bool)
    there = (np.isfinite(table.share) & motions).reshape(*job.sweep_shape, len(table.motions))
    known = table.complete.reshape(job.sweep_shape)
    rows = [row for axis in range(len(job.vary)) for row in _along(job, axis, there, known)]
    columns = list(zip(*rows, strict=True)) if rows else [()] * _FIELDS
    types: tuple[Any, ...] = (np.int8, np.int16, np.dtypes.StringDType(), np.float64, np.float64, np.float64)
    return tuple(np.array(column, dtype) for column, dtype in zip(columns, types, strict=True))


def _along(job: BasinJob, axis: int, there: np.ndarray, known: np.ndarray) -> list[tuple[object, ...]]:
    there, known = np.moveaxis(there, axis, 0), np.moveaxis(known, axis, 0)
    changed = (there[1:] != there[:-1]) & (known[1:] & known[:-1])[..., None]
    swept, beside = job.vary[axis], [other for at, other in enumerate(job.vary) if at != axis]
    rows: list[tuple[object, ...]] = []
    for place in np.argwhere(changed).tolist():
        step, *other, solution = place
        kind = ChangeKind.BIRTH if there[step + 1, *other, solution] else ChangeKind.DEATH
        value = beside[0].values[other[0]] if beside else np.nan
        rows.append((kind, solution, swept.parameter, swept.values[step], swept.values[step + 1], value))
    return rows

"""A large basin as a dataset of one of its levels: fewer cells, each with its own labels, and the same motions."""

from pathlib import Path
from typing import Any

import xarray as xr

from worker.errors import InvalidJob
from worker.stores.layout import MAPPED
from worker.stores.new_store import tiling_of
from worker.stores.pyramid import ATTRIBUTE, LABELS, Level, levels_of
from worker.views.reading import job_of, open_group_of, open_store

LEVEL = "level"
"""Attribute of a dataset of a level: its number."""


def levels_in(dataset: xr.Dataset) -> tuple[Level, ...]:
    """Levels of a basin or a sweep, the basin itself first.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a basin's store.

    Returns
    -------
    tuple of Level
    """
    if "tile_state" not in dataset:
        return ()
    job = job_of(dataset)
    levels = levels_of(job, tiling_of(job))
    return levels if ATTRIBUTE in dataset.attrs else levels[:1]


def _demand_level(dataset: xr.Dataset, level: int) -> Level:
    if ATTRIBUTE not in dataset.attrs:
        raise InvalidJob(f"there is no level {level}: only basins of more than 4,000 cells a side have levels")
    levels = levels_in(dataset)
    if not 0 < level < len(levels):
        raise InvalidJob(f"there is no level {level}: this result has levels from 0 to {len(levels) - 1}")
    return levels[level]


def open_level(location: str | Path, level: int, storage_options: dict[str, Any] | None = None) -> xr.Dataset:
    """Open one level of a large basin, or of a sweep of such.

    Parameters
    ----------
    location : str or path
    level : int
        0 is the result itself, as from `open_store`.
    storage_options : dict, optional
        Both as for `open_store`.

    Returns
    -------
    xarray.Dataset
        Without images and landing points, which levels do not have. Shares remain those of all cells.

    Raises
    ------
    InvalidJob
        If there is no such level.
    StoreConflict, StoreFailed, OSError
        As for `open_store`.
    """
    dataset = open_store(location, storage_options)
    if level == 0:
        return dataset
    own = _demand_level(dataset, level)
    labels = open_group_of(str(location), storage_options, own.group)
    every = slice(None, None, own.every)
    rest = dataset.drop_vars([variable.name for variable in MAPPED]).isel(time=every, velocity=every)
    cells = {variable.name: labels[variable.name].variable for variable in LABELS}
    return rest.assign(cells).assign_attrs({LEVEL: level})


def demand_all_cells(dataset: xr.Dataset) -> None:
    """Refuse a dataset of a level, whose cells are not those that the request names.

    Parameters
    ----------
    dataset : xarray.Dataset

    Raises
    ------
    InvalidJob
    """
    if LEVEL in dataset.attrs:
        raise InvalidJob(
            f"a measure needs all cells, and this is level {dataset.attrs[LEVEL]}: open the result without a level"
        )

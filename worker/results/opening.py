"""A basin in a notebook, as an xarray dataset, by path or over HTTP.

    basin = open_basin("basin.zarr")            # or "http://127.0.0.1:8000/v1/jobs/ID/result.zarr"
    basin_entropy(basin.solution)               # the measures of `rattle_kernels` accept its arrays
    integrity_factor(basin.solution, job_of(basin).grid, velocity_scale=1.0)
    least_disturbance(job_of(basin).oscillator, attractors_of(basin), basin.solution, job_of(basin).grid)
    basin_of(sweep, damping=0.6)                # one basin of a sweep, for any of the above

`worker.results.figure` draws it.
"""

import contextlib
import itertools
import json
from collections.abc import Iterable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from rattle_kernels import Attractor, AttractorKind
from worker.additions import additions
from worker.errors import InvalidJob, StoreConflict, as_store_failure
from worker.gear_pair import MACHINE, GearPair
from worker.jobs.basin_job import BasinJob, basin_job
from worker.jobs.design import SweepAxis, changes_at
from worker.machine_series import MACHINES, MachineSeries, machine_of
from worker.pictures.symbols import in_words
from worker.storage.location import files_at, storage_at
from worker.stores.layout import ENDS, LAYOUT_VERSION, MAPPED, MEASURED, MOTIONS, READABLE_LAYOUTS
from worker.stores.new_store import tiling_of
from worker.stores.pyramid import ATTRIBUTE, LABELS, Level, levels_of
from worker.stores.solution_table import ends_in

# Largest result, in bytes, whose arrays are read in one piece. A larger one has Dask arrays, whose library takes a
# fifth of a second to load.
_ONE_PIECE = 200_000_000
# Most cells each way of what is shown in a notebook.
_MOST_CELLS = 1000
LEVEL = "level"
"""Attribute of a dataset of a level: its number."""


def open_basin(location: str | Path) -> xr.Dataset:
    """Open a basin's store, finished or not.

    Parameters
    ----------
    location : str or path
        As for `open_store`.

    Returns
    -------
    xarray.Dataset

    Raises
    ------
    StoreConflict
        If there is no basin's store of this layout.
    OSError
        If an address does not answer.
    """
    dataset = open_store(location)
    if dataset.attrs.get("layout_version") not in READABLE_LAYOUTS:
        raise StoreConflict(f"{location} is no basin store of layout {LAYOUT_VERSION}")
    return dataset


def open_store(location: str | Path, storage_options: dict[str, Any] | None = None) -> xr.Dataset:
    """Open a store of any kind, finished or not.

    Parameters
    ----------
    location : str or path
        A folder, ``s3://bucket/prefix``, or the address of a service's ``result.zarr``. Its metadata may be
        consolidated (as this project's stores are, and as HTTP needs) or plain.
    storage_options : dict, optional
        Of an address: ``headers`` of its requests.

    Returns
    -------
    xarray.Dataset
        Read lazily; ``worker.stores.layout`` says what each variable means. The arrays of a large result are Dask
        arrays, read tile by tile. Of a machine it has SI units as well.

    Raises
    ------
    StoreConflict
        If there is no store.
    StoreFailed
        If a folder or S3 cannot be read.
    OSError
        If an address does not answer, or refuses.
    """
    dataset = open_group_of(str(location), storage_options)
    if "layout_version" not in dataset.attrs:
        raise StoreConflict(f"{location} is no store of this project")
    labelled, machine = _labelled(dataset), machine_of(json.loads(dataset.attrs["request"]))
    opened = labelled if machine is None else machine.with_units(labelled)
    opened.encoding["source"] = str(location)  # as xarray has it for files
    return opened


def machine_in(dataset: xr.Dataset) -> GearPair | MachineSeries | None:
    """The machine of a dataset that has units, or the machines of a sweep's; None if it is of the model alone."""
    alone, listed = dataset.attrs.get(MACHINE), dataset.attrs.get(MACHINES)
    if listed is not None and "request" in dataset.attrs:
        return _series(listed, dataset.attrs["request"])
    return None if alone is None else GearPair(**json.loads(alone))


@lru_cache(maxsize=16)
def _series(machines: str, request: str) -> MachineSeries | None:
    """Machines along the coordinate of a sweep, as long as a dataset is still that of the sweep."""
    design = json.loads(request).get("design")
    return None if design is None else MachineSeries.of_result(machines, design)


def open_group_of(
    location: str, storage_options: dict[str, Any] | None = None, group: str | None = None
) -> xr.Dataset:  # fmt: skip
    """Open a group of a store as it is, by default its root. Parameters and errors are those of `open_store`."""
    with _as_refusal(location) if is_address(location) else as_store_failure(location):
        try:
            return _open(location, storage_options, group)
        except (FileNotFoundError, KeyError, ValueError) as error:
            raise StoreConflict(
                f"{location} is no basin store, and none of an analysis: nothing there that Zarr can open"
            ) from (error if Path(location).exists() else None)


def _labelled(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset with its parameters as attributes, and names as coordinates, by which motions are selected.

    Attributes are numbers and text alone: netCDF knows no others.
    """
    request = json.loads(dataset.attrs["request"])
    vary = request.get("vary", [])
    swept = [each["parameter"] for each in (vary if isinstance(vary, list) else [vary])]
    design = request.get("design")
    if design is not None and design["name"] in dataset.variables:
        dataset = _with_machines(dataset, design)
        swept = [*design["parameters"]]
    parameters = {name: value for name, value in request.get("oscillator", {}).items() if name not in swept}
    given = (dataset.attrs | parameters).items()  # an unfinished result has no time at which it was finished
    attributes = {name: _plain(value) for name, value in given if value is not None}
    for parameter in swept:
        if parameter in dataset.variables:
            dataset[parameter].attrs["long_name"] = in_words(parameter)
    if "name" in dataset.data_vars:
        dataset = dataset.set_coords("name")
        if dataset["name"].dims == ("attractor",):
            dataset = dataset.assign_coords(attractor=dataset["name"].variable)  # values alone would load dask.array
    dataset.attrs = attributes
    return dataset


def _with_machines(dataset: xr.Dataset, design: dict[str, Any]) -> xr.Dataset:
    """The dataset with the numbers of its machines along their coordinate."""
    name = design["name"]
    dataset[name].attrs["long_name"] = name.replace("_", " ")
    if "units" in design:
        dataset[name].attrs["units"] = design["units"]
    numbers = design["parameters"].items()
    return dataset.assign_coords({each: (name, values, {"long_name": in_words(each)}) for each, values in numbers})


def _plain(value: Any) -> Any:
    """An attribute as netCDF takes it."""
    if isinstance(value, bool):
        return int(value)
    if isinstance(value, dict) or (isinstance(value, list) and any(isinstance(each, dict) for each in value)):
        return json.dumps(value)
    return value


def is_address(location: str) -> bool:
    """Whether a location is the address of a service's store."""
    return location.startswith(("http://", "https://"))


@contextlib.contextmanager
def _as_refusal(address: str) -> Iterator[None]:
    """Name the address that refuses, as an error of the system like that of one that does not answer."""
    from aiohttp import ClientResponseError  # takes a fifth of a second to load

    try:
        yield
    except ClientResponseError as error:
        hint = ": give a key of the service" if error.status in (401, 403) else ""
        raise PermissionError(f"{address} answered {error.status} {error.message}{hint}") from error


def _open(location: str, storage_options: dict[str, Any] | None, group: str | None) -> xr.Dataset:
    store = files_at(location, storage_options) if is_address(location) else storage_at(location).zarr
    dataset = _opened(store, group, None)
    dataset = dataset if dataset.nbytes <= _ONE_PIECE else _opened(store, group, {})
    for addition in additions():
        dataset = addition.opened(dataset, lambda group: _opened(store, group, {}))
    return dataset


def _opened(store: Any, group: str | None, chunks: dict[str, int] | None) -> xr.Dataset:
    try:
        return xr.open_zarr(store, group, consolidated=True, chunks=chunks)
    except ValueError:  # plain metadata: slower, one request an array
        return xr.open_zarr(store, group, consolidated=False, chunks=chunks)


def job_of(dataset: xr.Dataset) -> BasinJob:
    """Job of a dataset from `open_basin`: its oscillator, grid and iterations."""
    return _job(dataset.attrs["request"], dataset.attrs.get("request_sha256"))


@lru_cache(maxsize=16)
def _job(request: str, digest: str | None) -> BasinJob:
    return basin_job(json.loads(request), digest)


def basin_of(dataset: xr.Dataset, **values: float) -> xr.Dataset:
    """One basin of a sweep, as if opened alone. Solutions keep their numbers from the sweep.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `open_basin`.
    **values : float
        The value along every axis: ``basin_of(sweep, damping=0.6)``. A single basin takes no values.

    Returns
    -------
    xarray.Dataset
        Its ``share`` is NaN for solutions of other basins that this one lacks; ``share.notnull()`` selects its own.

    Raises
    ------
    InvalidJob
        If a parameter is missing or not swept, or a value is not among those swept.
    """
    job = job_of(dataset)
    names = [axis.name for axis in job.axes]
    if sorted(values) != sorted(names):
        raise InvalidJob(f"swept is {', '.join(names) or 'nothing'}: give one value of each, and of nothing else")
    place = {axis.name: _index_of(axis, values[axis.name]) for axis in job.axes}
    changes = changes_at(job.axes, tuple(place.values()))
    at = {axis.name: axis.values[place[axis.name]] for axis in job.axes} | changes
    oscillator = job.oscillator.at(**changes)
    series = machine_in(dataset)
    pair = series.pairs[next(iter(place.values()))] if isinstance(series, MachineSeries) else None
    alone = BasinJob(
        oscillator=oscillator, grid=job.grid, iterations=job.iterations, sample=job.sample,
        machine=None if pair is None else pair.as_request,
    )  # fmt: skip
    request = {"request": json.dumps(alone.request()), "request_sha256": alone.digest}
    basin = dataset.isel(place).assign_attrs(request | at)
    if pair is not None:
        del basin.attrs[MACHINES]
        basin = basin.assign_attrs({MACHINE: str(pair)})
    return basin


def basin_at(dataset: xr.Dataset, job: BasinJob, number: int) -> xr.Dataset:
    """The arrays of one basin of a job's dataset, by its number."""
    return dataset.isel({axis.name: at for axis, at in zip(job.axes, job.place_of(number), strict=True)})


def _index_of(axis: SweepAxis, value: float) -> int:
    near = np.flatnonzero(np.isclose(axis.values, value, rtol=1e-9, atol=0.0))
    if not near.size:
        raise InvalidJob(f"{axis.name} takes the values {', '.join(f'{at:g}' for at in axis.values)}")
    return int(near[0])


def attractors_of(dataset: xr.Dataset) -> tuple[Attractor, ...]:
    """Catalogue of attractors that ``solution`` indexes; empty before assembly.

    Solutions that a basin of a sweep lacks are listed without points, so numbers and colours are those of the sweep.
    """
    if "kind" not in dataset:
        return ()
    names = [variable.name for variable in (*MOTIONS[:4], *MEASURED[1:])]
    rows = zip(*(dataset[name].values.tolist() for name in names), strict=True)
    # Those at the end may have their place, and not yet their motions.
    numbers = itertools.takewhile(lambda row: row[0] != MOTIONS[0].fill, rows)
    points = zip(dataset.attractor_time.values, dataset.attractor_velocity.values, strict=True)
    ends: Iterable[tuple[tuple[int, float], ...]]
    ends = map(ends_in, dataset[ENDS.name].values) if ENDS.name in dataset else itertools.repeat(())
    return tuple(
        Attractor(
            AttractorKind(kind), m, upper, lower, exponent, error, t[np.isfinite(t)], v[np.isfinite(v)], life, end
        )
        for (kind, m, upper, lower, exponent, error, life), (t, v), end in zip(numbers, points, ends, strict=False)
    )


def thinned(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset with at most 1000 cells each way: every n-th stands for its neighbours, as labels have no mean.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of one basin. That of a sample stays as it is.

    Returns
    -------
    xarray.Dataset
        Shares remain those of all cells.
    """
    every = slice(None, None, max(1, -(-max(dataset.solution.shape) // _MOST_CELLS)))
    return dataset.isel(time=every, velocity=every) if "velocity" in dataset.dims else dataset


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

"""Layout of a new store: every array at full length, except those of solutions, whose number is not known yet."""

import asyncio
import json
import warnings
from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
import zarr
from zarr.abc.store import Store
from zarr.core.buffer import default_buffer_prototype
from zarr.core.sync import sync
from zarr.errors import ZarrUserWarning
from zarr.storage import MemoryStore

from rattle_kernels.basins.tiles import Tiling, cut, cut_row
from worker.additions import asked_of
from worker.fence import Fence, unfenced
from worker.jobs.basin_job import BasinJob
from worker.jobs.swept_parameter import SweptParameter
from worker.storage.checked_chunks import METADATA
from worker.storage.chunks import CODECS, CONFIG
from worker.storage.folder import synced_together
from worker.storage.location import storage_at
from worker.stores import layout
from worker.stores.layout import Places, TileState, Variable
from worker.stores.provenance import new_store_attributes
from worker.stores.pyramid import Level, levels_of, multiscales

# Consolidated metadata are Zarr-Python's own, not yet in the specification. Other readers ignore them. Silenced for the
# process: `catch_warnings` of one thread undoes that of another, such as that of Numba where it compiles meanwhile.
warnings.filterwarnings("ignore", "Consolidated metadata is currently not", ZarrUserWarning)
# Files and folders on the way: of a cancelled job some tasks still write while its metadata are collected.
warnings.filterwarnings("ignore", "Object at .* is not recognized as a component", ZarrUserWarning)

# Arrays that are written whole are small, except the image set of a map of 1e8 cells.
_LONGEST_CHUNK = 1 << 22
# Chunks of a basin's attractors.
ATTRACTORS_A_CHUNK, _POINTS_A_CHUNK = 32, 4096


def places_of(job: BasinJob) -> Places:
    """Arrays of a job's cells, or of its sample's points."""
    return layout.CELLS if job.sample is None else layout.SAMPLE


def tiling_of(job: BasinJob) -> Tiling:
    """Tiling of a job's basins. It depends on the request alone."""
    return (cut if job.sample is None else cut_row)(job.grid, job.applications, job.basins)


def consolidate(location: str, fence: Fence = unfenced) -> None:
    """Collect all metadata at the root, so that readers get them in one read. Called after every change of metadata."""
    zarr.consolidate_metadata(storage_at(location, fence).zarr, zarr_format=3)


def create_array(
    group: Any, job: BasinJob, variable: Variable, shape: tuple[int, ...], chunks: tuple[int, ...] | None = None
) -> Any:
    """Create one array. If `chunks` is given, each chunk holds one basin; otherwise it holds all basins.

    Parameters
    ----------
    group : zarr.Group
    job : BasinJob
    variable : Variable
    shape, chunks : tuple of int
        Along the variable's own dimensions. The dimensions of the axes of a sweep come first.
    """
    basins = job.sweep_shape if variable.per_basin else ()
    of_basins = tuple(1 for _ in basins) if chunks else basins
    own = chunks or tuple(min(max(1, length), _LONGEST_CHUNK) for length in shape)
    return group.create_array(
        variable.path, shape=basins + shape, chunks=of_basins + own, dtype=variable.dtype, fill_value=variable.fill,
        dimension_names=tuple(axis.name for axis in job.axes if variable.per_basin) + variable.dims,
        attributes=variable.attrs(), config=CONFIG, compressors=CODECS,
    )  # fmt: skip


def create_store(location: str, job: BasinJob, fence: Fence = unfenced) -> None:
    """Create a new store. The attributes that identify it as a store are written last.

    Zarr makes its arrays in memory, and their files are then written all at once: one by one they took twice as long.
    """
    planned = _planned(job)
    begun = zarr.create_group(storage_at(location, fence).zarr, zarr_format=3, overwrite=True)
    with synced_together(location):
        sync(_copy_all_but(METADATA, planned, begun.store))
        write_coordinates(begun, job, levels_of(job, tiling_of(job)))
    sync(_copy(METADATA, planned, begun.store))


def new_metadata(job: BasinJob) -> dict[str, Any]:
    """Metadata of every array and group of a new store, by path."""
    root = sync(_planned(job).get(METADATA, default_buffer_prototype()))
    nodes: dict[str, Any] = json.loads(root.to_bytes())["consolidated_metadata"]["metadata"]
    return nodes


def _planned(job: BasinJob) -> MemoryStore:
    """A new store without coordinates, in memory."""
    planned = MemoryStore()
    group = zarr.create_group(planned, zarr_format=3)
    levels = levels_of(job, tiling_of(job))
    tile = _create_arrays(group, job)
    for level in levels[1:]:
        _create_level(group, job, level)
    title = "Basins of attraction of a rattling gear pair"
    born = new_store_attributes(title, job.request(), job.digest)
    # In one write: `attrs.update` writes once per attribute.
    group.update_attributes(born | {"tile_cells": list(tile)} | multiscales(levels, len(job.axes)))
    zarr.consolidate_metadata(planned, zarr_format=3)
    return planned


async def _copy_all_but(last: str, source: MemoryStore, target: Store) -> None:
    paths = [path async for path in source.list() if path != last]
    await asyncio.gather(*(_copy(path, source, target) for path in paths))


async def _copy(path: str, source: MemoryStore, target: Store) -> None:
    await target.set(path, await source.get(path, default_buffer_prototype()))


def _create_arrays(group: Any, job: BasinJob) -> tuple[int, ...]:
    """Create all arrays. Return the shape of a tile."""
    tiling, places = tiling_of(job), places_of(job)
    sampled = job.sample is not None
    shape: tuple[int, ...] = (job.grid.time_cells,) if sampled else job.grid.shape
    tile = (tiling.tile_columns,) if sampled else (tiling.tile_rows, tiling.tile_columns)
    added = [variable for addition in asked_of(job) for variable in addition.arrays()]
    for variable in (*places.mapped, *places.labelled, places.solution, places.own_solution, *added):
        create_array(group, job, variable, shape, tile)
    ledger = create_array(group, job, places.ledger, tiling.shape[1:] if sampled else tiling.shape)
    ledger[...] = np.full(ledger.shape, TileState.PENDING, np.uint8)
    _create_axes(group, job)
    _create_coordinates(group, job, tiling)
    _create_assembly(group, job)
    _create_solutions(group, job)
    return tile


def _create_axes(group: Any, job: BasinJob, within: str = "") -> None:
    for axis in job.axes:
        said = "swept parameter" if isinstance(axis, SweptParameter) else "coordinate of the machines of a design"
        named = Variable(axis.name, (axis.name,), np.float64, np.inf, said, {}, False, within)
        create_array(group, job, named, (axis.size,))


def _create_level(group: Any, job: BasinJob, level: Level) -> None:
    """Create the arrays of a level, which opens by itself."""
    grid, tile = level.tiling.grid, (level.tiling.tile_rows, level.tiling.tile_columns)
    for variable in level.labels:
        create_array(group, job, variable, grid.shape, tile)
    for variable, cells in zip(level.coordinates, (grid.time_cells, grid.velocity_cells), strict=True):
        create_array(group, job, variable, (cells,))
    _create_axes(group, job, level.group)


def _create_coordinates(group: Any, job: BasinJob, tiling: Tiling) -> None:
    if job.sample is not None:
        for variable in layout.SAMPLE_COORDINATES:
            create_array(group, job, variable, (job.sample.points,), (tiling.tile_columns,))
    else:
        for variable, cells in zip(layout.COORDINATES, (job.grid.time_cells, job.grid.velocity_cells), strict=True):
            create_array(group, job, variable, (cells,))
        create_array(group, job, layout.GRAZING, (job.grid.time_cells,), (job.grid.time_cells,))


def write_coordinates(group: Any, job: BasinJob, levels: Sequence[Level]) -> None:
    """Write what follows from the request alone: values along the axes of a sweep, coordinates of cells or points."""
    for level, axis in product(levels, job.axes):
        group[level.own_path(axis.name)][...] = np.array(axis.values)
    if job.sample is None:
        centres = job.grid.time_centres(), job.grid.velocity_centres()
        for level in levels:
            for variable, values in zip(level.coordinates, centres, strict=True):
                group[variable.path][...] = values[:: level.every]
        return
    arrays, tiling = [group[variable.path] for variable in layout.SAMPLE_COORDINATES], tiling_of(job)
    for number in tiling.numbers_of(0):
        columns = tiling.tile(number).columns
        for array, values in zip(arrays, job.sample.departures(job.grid, *columns), strict=True):
            array[slice(*columns)] = values


def _create_assembly(group: Any, job: BasinJob) -> None:
    if job.sample is None:
        words = -(-job.grid.cells // 64)
        create_array(group, job, layout.IMAGE_WORDS, (words,), (min(words, _LONGEST_CHUNK),))
        for variable in layout.IMAGE_SET:
            length = job.grid.cells + 1
            create_array(group, job, variable, (length,), (min(length, _LONGEST_CHUNK),))
    create_array(group, job, layout.IMAGE_COUNTS, (3,))


def _create_solutions(group: Any, job: BasinJob) -> None:
    for variable in layout.MOTIONS + layout.measured(job.sample.scramblings if job.sample else None):
        basins = job.sweep_shape if variable.per_basin else ()
        group.create_array(
            variable.path, shape=(*basins, 0), chunks=(*basins, ATTRACTORS_A_CHUNK), dtype=variable.dtype,
            fill_value=variable.fill, attributes=variable.attrs(), config=CONFIG, compressors=CODECS,
            dimension_names=tuple(axis.name for axis in job.axes if variable.per_basin) + variable.dims,
        )  # fmt: skip
    for variable in layout.POINTS:
        create_array(group, job, variable, (0, 0), (ATTRACTORS_A_CHUNK, _POINTS_A_CHUNK))
    create_array(group, job, layout.ENDS, (0, 0), (ATTRACTORS_A_CHUNK, ATTRACTORS_A_CHUNK))

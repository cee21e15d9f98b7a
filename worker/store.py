"""The Zarr store of one job: the only module that speaks to Zarr.

Guarantees. One tile is one chunk of every array and one writer writes it, so writers never meet. Chunks are replaced as
a whole (temporary file and rename), so a killed writer leaves the old chunk or the new one. Chunks equal to the fill
value are written, too. The ledger and the metadata have one writer, the driver; metadata are consolidated anew whenever
they change (three times a job), so that readers that trust the root, such as those over HTTP, which cannot list a
folder, see all there is at any moment.
"""

import contextlib
import hashlib
import json
import shutil
import subprocess
import warnings
from collections.abc import Iterator
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import zarr
from zarr.errors import ZarrUserWarning

from rattle_kernels import Attractor, AttractorKind, CellGroups, grazing_velocity, with_counts
from worker import layout
from worker.basin_job import BasinJob
from worker.errors import StoreConflict, StoreFailed
from worker.layout import TileState, Variable
from worker.tiles import Tile, Tiling, cut

# Not kept by Zarr: a handle opened without it would delete chunks that equal the fill value.
_CONFIG = {"write_empty_chunks": True}
# Arrays that are written whole are small, but for the image set of a map of 1e8 cells.
_LONGEST_CHUNK = 1 << 22
_PACKAGES = ("gear-rattle", "numpy", "numba", "zarr", "dask", "distributed")


@contextlib.contextmanager
def _told_as_store_failure(location: str) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise StoreFailed(f"the store {location} cannot be read or written: {reason}") from error


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def _git_revision() -> str | None:
    command = ["git", "-C", str(Path(__file__).parent), "rev-parse", "HEAD"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=5)
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()


class BasinStore:
    """A job's store, open for reading and writing.

    Parameters
    ----------
    location : str
        A folder, or a URL that Zarr understands.

    Raises
    ------
    StoreConflict
        Where the location holds something else than a basin's store.
    StoreFailed
        Where it cannot be read.
    """

    def __init__(self, location: str) -> None:
        self.location = location
        with _told_as_store_failure(location):
            try:
                self._group = zarr.open_group(location, mode="r+", zarr_format=3, use_consolidated=False)
            except (FileNotFoundError, NotADirectoryError, ValueError) as error:
                raise StoreConflict(f"{location} is no basin store: nothing there that Zarr can open") from error
        if self._group.attrs.get("layout_version") != layout.LAYOUT_VERSION:
            raise StoreConflict(f"{location} is no basin store of layout {layout.LAYOUT_VERSION}")
        self.job = BasinJob.from_request(json.loads(str(self._group.attrs["request"])))
        self.tiling = cut(self.job.grid, self.job.iterations)
        # Arrays of cells never change their shape: their handles are kept, as opening one costs half as much as a tile.
        self._handles: dict[str, Any] = {}

    @classmethod
    def create_or_resume(cls, location: str, job: BasinJob) -> "BasinStore":
        """Store of `job` at `location`: the one that is there, or a new one.

        Raises
        ------
        StoreConflict
            Where the location holds another job's store, or something else.
        StoreFailed
            Where it cannot be written.
        """
        if not holds_basin(location):
            if "://" not in location and Path(location).exists() and _holds_something(Path(location)):
                raise StoreConflict(f"{location} exists and is no basin store: choose another place, or remove it")
            with _told_as_store_failure(location):
                _create(location, job)
        store = cls(location)
        if store.job.digest != job.digest:
            raise StoreConflict(
                f"{location} holds the store of another request: choose another place, or remove it\n"
                f"it holds {json.dumps(store.job.request())}"
            )
        return store

    def _array(self, variable: Variable, group: str = "") -> Any:
        return self._group[f"{group}/{variable.name}" if group else variable.name].with_config(_CONFIG)

    def _cells(self, variable: Variable) -> Any:
        if variable.name not in self._handles:
            self._handles[variable.name] = self._array(variable)
        return self._handles[variable.name]

    @property
    def complete(self) -> bool:
        """Whether the job has finished and every array is whole."""
        return bool(self._group.attrs["complete"])

    def write_tile(self, variables: tuple[Variable, ...], tile: Tile, values: tuple[np.ndarray, ...]) -> None:
        """Write one tile of some variables."""
        with _told_as_store_failure(self.location):
            for variable, value in zip(variables, values, strict=True):
                self._cells(variable)[slice(*tile.rows), slice(*tile.columns)] = value

    def read_tile(self, variables: tuple[Variable, ...], tile: Tile) -> tuple[np.ndarray, ...]:
        """Read one tile of some variables."""
        with _told_as_store_failure(self.location):
            return tuple(
                np.asarray(self._cells(variable)[slice(*tile.rows), slice(*tile.columns)]) for variable in variables
            )

    def read_ledger(self) -> np.ndarray:
        """State of each tile, flat, as `TileState` codes."""
        with _told_as_store_failure(self.location):
            return np.asarray(self._array(layout.LEDGER)[...]).ravel()

    def write_ledger(self, states: np.ndarray) -> None:
        """Replace the ledger (driver only)."""
        with _told_as_store_failure(self.location):
            self._array(layout.LEDGER)[...] = states.reshape(self.tiling.shape)

    def write_image_counts(self, counts: dict[str, int]) -> None:
        """Note how many cells have each reserved image (driver only)."""
        with _told_as_store_failure(self.location):
            self._group.attrs["image_counts"] = counts

    def write_image_set(self, groups: CellGroups) -> None:
        """Write Hsu's numbers on the image set, for tiles to look up."""
        with _told_as_store_failure(self.location):
            group = self._group.require_group(layout.IMAGE_SET_GROUP)
            values_of = (groups.members.words, groups.group, groups.step, groups.period_of_group)
            for variable, values in zip(layout.IMAGE_SET, values_of, strict=True):
                _write_whole(group, variable, values)

    def read_image_set(self) -> CellGroups:
        """Read Hsu's numbers on the image set."""
        with _told_as_store_failure(self.location):
            words, *numbers = (
                np.asarray(self._array(variable, layout.IMAGE_SET_GROUP)[...]) for variable in layout.IMAGE_SET
            )
            return CellGroups(with_counts(words), *numbers)

    def write_attractors(self, attractors: tuple[Attractor, ...], shares: np.ndarray) -> None:
        """Write the catalogue, and the meaning of ``solution`` (driver only)."""
        names = [attractor.name for attractor in attractors]
        points = max(1, max(attractor.time.size for attractor in attractors))
        padded = np.full((2, len(attractors), points), np.nan)
        for i, attractor in enumerate(attractors):
            padded[0, i, : attractor.time.size] = attractor.time
            padded[1, i, : attractor.time.size] = attractor.velocity
        columns = [np.array(column) for column in list(zip(*attractors, strict=True))[:6]]
        values = [*columns, shares, np.array(names, dtype=np.dtypes.StringDType()), *padded]
        with _told_as_store_failure(self.location):
            for variable, value in zip(layout.ATTRACTORS, values, strict=True):
                _write_whole(self._group, variable, value)
            self._group["solution"].attrs.update(
                {"flag_values": list(range(len(names))), "flag_meanings": " ".join(_words(names))}
            )
            self._group.attrs["catalogue_sha256"] = _catalogue_hash(self.job, attractors)
            _consolidate(self.location)

    def read_attractors(self) -> tuple[Attractor, ...]:
        """Read the catalogue; empty before assembly."""
        if "kind" not in self._group:
            return ()
        with _told_as_store_failure(self.location):
            kind, periods, upper, lower, exponent, error, _, _, time, velocity = (
                np.asarray(self._array(variable)[...]) for variable in layout.ATTRACTORS
            )
        return tuple(
            Attractor(
                AttractorKind(int(kind[i])), int(periods[i]), int(upper[i]), int(lower[i]), float(exponent[i]),
                float(error[i]), time[i][np.isfinite(time[i])], velocity[i][np.isfinite(velocity[i])],
            )
            for i in range(kind.size)
        )  # fmt: skip

    @property
    def catalogue_sha256(self) -> str:
        """Hash of the catalogue that was written last."""
        return str(self._group.attrs["catalogue_sha256"])

    def read_shares(self) -> np.ndarray:
        """Share of the cells of each attractor; NaN until every tile is labelled."""
        return np.asarray(self._group["share"][...])

    def finish(self, seconds: dict[str, float]) -> None:
        """Mark the store complete and consolidate its metadata (driver only)."""
        with _told_as_store_failure(self.location):
            self._group.attrs.update({"complete": True, "finished": _now(), "seconds": seconds})
            self.sweep_orphans()
            _consolidate(self.location)

    @property
    def attributes(self) -> dict[str, Any]:
        """Attributes of the store."""
        return dict(self._group.attrs)

    def sweep_orphans(self) -> None:
        """Remove temporary files that killed writers left behind."""
        if "://" not in self.location:
            for orphan in Path(self.location).rglob("*.partial"):
                orphan.unlink(missing_ok=True)


def _catalogue_hash(job: BasinJob, attractors: tuple[Attractor, ...]) -> str:
    """Hash of a job's catalogue: what labels are looked up in is the same wherever it is the same."""
    digest = hashlib.sha256(job.digest.encode())
    for attractor in attractors:
        digest.update(attractor.name.encode() + attractor.time.tobytes() + attractor.velocity.tobytes())
    return digest.hexdigest()


def _words(names: list[str]) -> list[str]:
    """CF flag meanings: blank-separated words, one of them for each solution, so names that recur are numbered."""
    words = [name.replace(" ", "_") for name in names]
    return [word if words.count(word) == 1 else f"{word}_{words[: i + 1].count(word)}" for i, word in enumerate(words)]


def _consolidate(location: str) -> None:
    """Gather all metadata at the root, where readers find them in one piece; done after every change of them."""
    with warnings.catch_warnings():
        # Consolidated metadata are Zarr-Python's own, not yet part of the specification: other readers ignore them.
        warnings.simplefilter("ignore", ZarrUserWarning)
        zarr.consolidate_metadata(location, zarr_format=3)


def _write_whole(group: Any, variable: Variable, values: np.ndarray) -> None:
    """Create (or replace) an array that one writer writes at once."""
    array = group.create_array(
        variable.name, shape=values.shape, chunks=tuple(min(max(1, length), _LONGEST_CHUNK) for length in values.shape),
        dtype=variable.dtype, fill_value=variable.fill, dimension_names=variable.dims, attributes=variable.attrs(),
        overwrite=True, config=_CONFIG,
    )  # fmt: skip
    array[...] = values.astype(variable.dtype) if variable.dtype is not str else values


def _create(location: str, job: BasinJob) -> None:
    """Lay out a new store; the attributes that make it one are written last."""
    tiling = cut(job.grid, job.iterations)
    group = zarr.create_group(location, zarr_format=3, overwrite=True)
    for variable in layout.MAPPED + layout.LABELLED:
        group.create_array(
            variable.name, shape=job.grid.shape, chunks=(tiling.tile_rows, tiling.tile_columns), dtype=variable.dtype,
            fill_value=variable.fill, dimension_names=variable.dims, attributes=variable.attrs(), config=_CONFIG,
        )  # fmt: skip
    for variable, centres in zip(
        layout.COORDINATES, (job.grid.time_centres(), job.grid.velocity_centres()), strict=True
    ):
        _write_whole(group, variable, centres)
    _write_whole(group, layout.GRAZING, grazing_velocity(job.oscillator, job.grid.time_centres()))
    _write_whole(group, layout.LEDGER, np.full(tiling.shape, TileState.PENDING))
    group.attrs.update(_birth_certificate(job, tiling))
    _consolidate(location)


def _birth_certificate(job: BasinJob, tiling: Tiling) -> dict[str, Any]:
    return {
        "Conventions": "CF-1.11",
        "title": "Basins of attraction of a rattling gear pair",
        "request": json.dumps(job.request()),
        "request_sha256": job.digest,
        "layout_version": layout.LAYOUT_VERSION,
        "tile_cells": [tiling.tile_rows, tiling.tile_columns],
        "versions": {package: version(package) for package in _PACKAGES},
        "git_revision": _git_revision(),
        "started": _now(),
        "finished": None,
        "complete": False,
    }


def holds_basin(location: str) -> bool:
    """Whether a basin's store lies at a location: its attributes are the last thing that is created."""
    with _told_as_store_failure(location):
        try:
            group = zarr.open_group(location, mode="r", zarr_format=3, use_consolidated=False)
        except (FileNotFoundError, NotADirectoryError, ValueError):
            return False
        return "layout_version" in group.attrs


def _holds_something(path: Path) -> bool:
    """Whether a path is a file, or a folder with anything but the beginnings of a store in it."""
    if not path.is_dir():
        return True
    return any(path.iterdir()) and not (path / "zarr.json").exists()


def result_location(folder: str, job_id: str) -> str:
    """Place of a job's store in a folder of results."""
    return f"{folder.rstrip('/')}/{job_id}.zarr"


def remove_result(location: str) -> None:
    """Remove a store, whole or not; nothing happens where there is none.

    Raises
    ------
    StoreFailed
        Where it cannot be removed.
    """
    if Path(location).exists():
        with _told_as_store_failure(location):
            shutil.rmtree(location)


def file_of_store(location: str, path: str) -> Path | None:
    """File of a store by its path within, or none; a path that leads out of the store is none of its files."""
    root = Path(location).resolve()
    try:
        file = (root / path).resolve()
        return file if file.is_relative_to(root) and file.is_file() else None
    except (OSError, ValueError):  # a name that no file can have
        return None

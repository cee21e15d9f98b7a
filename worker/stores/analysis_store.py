"""The Zarr store of an analysis: parts as they are computed, and the tables that are assembled from them.

Guarantees. Each part is written by one task, which marks it complete once all its columns are written. A part without
the mark is ignored and computed again. Only the driver writes tables. It writes them whole, when the work ends or is
stopped. A complete store has no parts, and the same bytes however often the work was interrupted.
"""

import json
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any

import numpy as np
import zarr

from worker.errors import StoreConflict, StoreFailed, as_store_failure
from worker.fence import Fence, unfenced
from worker.jobs.job import AnalysisJob
from worker.kinds import KINDS
from worker.rounding import demand_same_rounding
from worker.storage.chunks import CODECS, CONFIG
from worker.storage.folder import synced_together
from worker.storage.location import storage_at
from worker.stores.layout import Columns, Variable
from worker.stores.new_store import consolidate
from worker.stores.opening import (
    attributes_of,
    check_same_request,
    create_unless_there,
    open_store_at,
    opened_for_tasks,
    opened_once,
    trusted_job,
)
from worker.stores.provenance import new_store_attributes, now

ANALYSIS_LAYOUT_VERSION = 3
# Chunks of layouts 1 and 2 are compressed by Zstandard, those of layout 1 without checksums.
_READABLE_LAYOUTS = (1, 2, ANALYSIS_LAYOUT_VERSION)
PARTS = "parts"
"""Group of the parts of an unfinished analysis."""
_WHOLE = "whole"
_LONGEST_CHUNK = 1 << 20


class AnalysisStore:
    """Store of one analysis, open for reading and writing. Those who only read, and tasks, share one: see `open`.

    Parameters
    ----------
    location : str
        Location as in `worker.storage.location`.
    fence : Fence
        The driver's fence.

    Raises
    ------
    StoreConflict
        If the location holds no analysis.
    StoreFailed
        If it cannot be read.
    """

    def __init__(self, location: str, fence: Fence = unfenced) -> None:
        self.location, self._fence = location, fence
        self._group = open_store_at(location, "store", fence)
        if "kind" not in self._group.attrs:
            raise StoreConflict(f"{location} holds no analysis")
        if self._group.attrs["layout_version"] not in _READABLE_LAYOUTS:
            raise StoreConflict(f"{location} is no analysis of layout {ANALYSIS_LAYOUT_VERSION}")

    @classmethod
    def open(cls, location: str, digest: str | None = None) -> "AnalysisStore":
        """The store at a location, opened once in each process; parameters and errors as of `BasinStore.open`."""
        return opened_once(cls, location) if digest is None else opened_for_tasks(cls, location, digest)

    @classmethod
    def create_or_resume(cls, location: str, title: str, job: AnalysisJob, fence: Fence = unfenced) -> "AnalysisStore":
        """Store of `job` at `location`: the existing one, or a new one.

        Raises
        ------
        StoreConflict
            If the location holds another job's store, one begun on a processor of another kind, or something else.
        StoreFailed
            If it cannot be written.
        """
        create_unless_there(location, "store", lambda: _create(location, title, job, fence), fence)
        store = cls(location, fence)
        check_same_request(location, job.digest, store.digest, store.request)
        if not store.complete:
            demand_same_rounding(location, store.attributes, StoreConflict)
        return store

    @property
    def attributes(self) -> dict[str, Any]:
        """Attributes of the store."""
        return dict(self._group.attrs)

    @property
    def digest(self) -> str:
        """Hash of the request."""
        return str(self._group.attrs["request_sha256"])

    @cached_property
    def job(self) -> AnalysisJob:
        """The job whose store this is.

        Raises
        ------
        StoreConflict
            If no package here has its kind.
        StoreFailed
            If its request is not the one that it was made for.
        """
        kind = KINDS[str(self._group.attrs["kind"])]
        return trusted_job(kind.job_class.trusted, self.location, self._group.attrs)  # type: ignore[return-value]

    @property
    def request(self) -> dict[str, Any]:
        """The request."""
        request: dict[str, Any] = json.loads(str(self._group.attrs["request"]))
        return request

    @property
    def complete(self) -> bool:
        """Whether the job has finished and every table is whole."""
        return bool(self._group.attrs["complete"])

    def write_part(self, name: str, columns: Columns) -> None:
        """Write the columns of a part, and mark it complete."""
        with as_store_failure(self.location):
            with synced_together(self.location):
                part = self._group.create_group(f"{PARTS}/{name}", overwrite=True)
                for column, values in columns.items():
                    _write(part, column, np.asarray(values), (), {})
            part.attrs[_WHOLE] = True

    def read_part(self, name: str) -> Columns:
        """Columns of a completed part.

        Raises
        ------
        StoreFailed
            If it is gone, for example because the driver has finished.
        """
        part = self._part(name)
        if part is None:
            raise StoreFailed(f"the store {self.location} has no part {name} any more")
        with as_store_failure(self.location):
            return {column: np.asarray(array[...]) for column, array in part.arrays()}

    def _part(self, name: str) -> Any | None:
        """Group of a part, None if it is missing."""
        with as_store_failure(self.location):
            try:
                return self._group[f"{PARTS}/{name}"]
            except KeyError:
                return None

    def parts(self) -> "StoredParts":
        """Completed parts."""
        # Zarr's own list of groups would warn of temporary files that writers of other parts have open.
        with as_store_failure(self.location):
            names = storage_at(self.location).folders(PARTS)
        found = {name: self._part(name) for name in names}
        return StoredParts(self, [name for name, part in found.items() if part is not None and part.attrs.get(_WHOLE)])

    def publish(self, variables: tuple[Variable, ...], columns: Columns) -> None:
        """Write the tables in place of the existing ones (driver only)."""
        self._fence()
        with as_store_failure(self.location):
            with synced_together(self.location):
                for variable in variables:
                    if variable.name in self._group:
                        del self._group[variable.name]
                    values = np.asarray(columns[variable.name])
                    _write(self._group, variable.name, values, variable.dims, variable.attrs(), variable)
            consolidate(self.location, self._fence)

    def read_tables(self) -> Columns:
        """Columns of the tables."""
        with as_store_failure(self.location):
            return {name: np.asarray(array[...]) for name, array in self._group.arrays()}

    def finish(self, seconds: dict[str, float]) -> None:
        """Mark the store complete, and remove the parts (driver only)."""
        self._fence()
        with as_store_failure(self.location):
            self._group.update_attributes({"complete": True, "finished": now(), "seconds": seconds})
        self.remove_parts()

    def invalidate(self) -> None:
        """Make the store unfinished again, so that the same job computes its tables anew."""
        self._fence()
        with as_store_failure(self.location):
            self._group.update_attributes({"complete": False, "finished": None})
            consolidate(self.location, self._fence)

    def remove_parts(self) -> None:
        """Remove the parts of a store whose tables are complete, and what killed writers have left (driver only)."""
        self._fence()
        with as_store_failure(self.location):
            if PARTS in self._group:
                del self._group[PARTS]
            storage_at(self.location).sweep()
            consolidate(self.location, self._fence)


class StoredParts(Mapping[str, Columns]):
    """Columns of parts by name, read on first use and then cached."""

    def __init__(self, store: AnalysisStore, names: list[str]) -> None:
        self._store = store
        self._columns: dict[str, Columns | None] = dict.fromkeys(names)

    @property
    def location(self) -> str:
        """Of their store."""
        return self._store.location

    def add(self, name: str) -> None:
        """Note that a part is complete."""
        self._columns[name] = None

    def __getitem__(self, name: str) -> Columns:
        columns = self._columns[name]
        if columns is None:
            columns = self._columns[name] = self._store.read_part(name)
        return columns

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)


def kind_of_store(location: str) -> str:
    """Kind of the store at a location: that of an analysis, or ``basin`` for basins and sweeps.

    Raises
    ------
    StoreConflict
        If there is no store.
    """
    attributes = attributes_of(location)
    if not attributes:
        raise StoreConflict(f"{location} is no basin store, and none of an analysis: nothing there that Zarr can open")
    return str(attributes.get("kind", "basin"))


def _create(location: str, title: str, job: AnalysisJob, fence: Fence) -> None:
    """Create a new store with attributes only. The length of its tables is not known yet."""
    group = zarr.create_group(storage_at(location, fence).zarr, zarr_format=3, overwrite=True)
    born = new_store_attributes(title, job.request(), job.digest)
    group.update_attributes(born | {"kind": job.kind, "layout_version": ANALYSIS_LAYOUT_VERSION})
    consolidate(location, fence)


def _write(
    group: Any, name: str, values: np.ndarray, dims: tuple[str, ...], attributes: dict[str, Any],
    variable: Variable | None = None,
) -> None:  # fmt: skip
    """Create one array with its values."""
    text = values.dtype.kind in "UOT"
    kind = str if text else values.dtype if variable is None else variable.dtype
    array = group.create_array(
        name, shape=values.shape, chunks=_chunks(values.shape), dtype=kind, config=CONFIG, attributes=attributes,
        dimension_names=dims or None, fill_value=variable.fill if variable else None, compressors=CODECS,
    )  # fmt: skip
    if values.size:
        array[...] = np.array(values.tolist(), np.dtypes.StringDType()) if text else values.astype(kind)


def _chunks(shape: tuple[int, ...]) -> tuple[int, ...]:
    """Chunks as long as the array, with a bound along the first dimension."""
    rest = max(1, int(np.prod(shape[1:], dtype=np.int64)))
    first = max(1, min(shape[0], _LONGEST_CHUNK // rest)) if shape else 1
    return (first, *(max(1, length) for length in shape[1:])) if shape else ()

"""The arrays of an open store of basins: what all its parts read and write through."""

from typing import Any

import numpy as np

from worker.errors import DamagedMetadata, as_store_failure
from worker.fence import Fence
from worker.jobs.basin_job import BasinJob
from worker.storage.chunks import CONFIG, write_over
from worker.stores.layout import Variable


class OpenArrays:
    """Handles on the arrays of a store. Opening one costs half as much as a tile, so each is opened once.

    Threads may share them.

    Parameters
    ----------
    location : str
        Name of the store in errors.
    job : BasinJob
        The store's.
    group : zarr.Group
        Root of the store.
    fence : Fence
        The driver's fence.
    """

    def __init__(self, location: str, job: BasinJob, group: Any, fence: Fence) -> None:
        self.location, self.job, self.group, self.fence = location, job, group, fence
        self._handles: dict[str, Any] = {}

    def fresh(self, variable: Variable) -> Any:
        """An array as it is now; of a finished store, where nothing grows any more, as it was first opened."""
        return self.array(variable) if self.group.attrs["complete"] else self._opened(variable)

    def _opened(self, variable: Variable) -> Any:
        try:
            return self.group[variable.path].with_config(CONFIG)
        except (KeyError, TypeError, ValueError) as error:  # they are missing, or JSON that Zarr does not take
            raise DamagedMetadata(self.location, variable.path) from error

    def array(self, variable: Variable) -> Any:
        """An array as it was when it was first opened. Those of cells never change their shape."""
        handle = self._handles.get(variable.path)
        if handle is None:
            handle = self._handles[variable.path] = self._opened(variable)
        return handle

    def array_with_room(self, variable: Variable, shape: tuple[int, ...]) -> Any:
        """An array that the driver extends along its last dimensions, reopened if the known one is too short."""
        if any(there < needed for there, needed in zip(self.array(variable).shape[-len(shape) :], shape, strict=True)):
            self._handles.pop(variable.path, None)
        return self.array(variable)

    def forget_handles(self) -> None:
        """Open every array anew when it is next used."""
        self._handles.clear()

    def read(self, variable: Variable, *index: Any) -> np.ndarray:
        """Read a part of an array."""
        with as_store_failure(self.location):
            return np.asarray(self.array(variable)[index])

    def write(self, variable: Variable, values: np.ndarray, *index: Any) -> None:
        """Write a part of an array, whatever is left of what was there."""
        with as_store_failure(self.location):
            write_over(self.array(variable), index, values)

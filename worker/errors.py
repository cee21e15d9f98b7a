"""What can go wrong with work, grouped by what a caller would do about it.

WorkerError
    InvalidJob       the request is at fault: correct it (also a ValueError)
    InvalidSettings  a RATTLE_... variable or an option is at fault: the message names it (also a ValueError)
    NotFound         what was asked for is not there: the message tells what is, and what would be right
    StoreConflict    something else lies at the location: choose another, or delete it
    StoreFailed      the store could not be read or written: the message holds the system's reason; resume when mended
    TileFailed       a tile kept failing: the message names it and its last error
    ClusterFailed    no scheduler or no worker answered: what had been computed is in the store; resume when they do
    UnlikeWorkers    a worker rounds in another way than a store was begun: use processors of one kind
    LeaseLost        another driver has taken the job over: leave it alone
    JobCancelled     somebody asked for it
"""

import contextlib
import re
import sys
from collections.abc import Iterator

from rattle_kernels import OutsideDomain

FieldPath = tuple[str | int, ...]
"""Where something stands in a request: names of fields and numbers of items, from the outside in."""


class WorkerError(Exception):
    """Anything that work can fail with.

    Examples
    --------
    >>> import rattle
    >>> try:
    ...     rattle.open("nowhere.zarr")
    ... except rattle.WorkerError as error:
    ...     print(error)
    nowhere.zarr is no basin store, and none of an analysis: nothing there that Zarr can open
    """


class InvalidJob(WorkerError, ValueError):
    """The job cannot be computed as described.

    Attributes
    ----------
    place : tuple of str and int
        The field at fault in the request; empty where no single field is.

    Examples
    --------
    >>> import rattle
    >>> try:
    ...     rattle.basin(cells=0)
    ... except rattle.InvalidJob as error:
    ...     print(error)
    cells: Input should be greater than or equal to 1
    """

    def __init__(self, message: str, place: FieldPath = ()) -> None:
        super().__init__(message)
        self.place = place


class InvalidFields(InvalidJob):
    """Fields of a request have wrong types or values, or are unknown.

    Attributes
    ----------
    faults : list of (tuple of str and int, str)
        Each field at fault, and what is wrong with it.
    """

    def __init__(self, faults: list[tuple[FieldPath, str]]) -> None:
        super().__init__("; ".join(f"{'.'.join(map(str, place))}: {message}" for place, message in faults))
        self.faults = faults

    def __reduce__(self) -> tuple[type, tuple[list[tuple[FieldPath, str]]]]:
        return type(self), (self.faults,)


class InvalidSettings(WorkerError, ValueError):
    """A setting has a wrong value, or settings contradict each other."""


class SweptOutsideDomain(OutsideDomain):
    """Some value of a swept parameter lies where what is asked for is not computed.

    Attributes
    ----------
    place : tuple of str and int
        Which value, in the request.
    """

    def __init__(self, error: OutsideDomain, place: FieldPath, where: str) -> None:
        super().__init__(error.parameter, error.value, error.bound, error.limit, f"{where}: {error}")
        self.place = place


class NotFound(WorkerError):
    """Computing has shown that there is no such orbit, saddle or attractor where it was looked for.

    Examples
    --------
    >>> import rattle
    >>> try:
    ...     rattle.manifolds(saddles=["P(1,4,0)"], progress=False)
    ... except rattle.NotFound as error:
    ...     print(str(error).partition(";")[0])
    saddle 1: the search found no saddle P(1,4,0)
    """


class StoreConflict(WorkerError):
    """The location holds something that is not this job's store, or no store.

    Examples
    --------
    >>> import rattle
    >>> try:
    ...     rattle.open("nowhere.zarr")
    ... except rattle.StoreConflict as error:
    ...     print(error)
    nowhere.zarr is no basin store, and none of an analysis: nothing there that Zarr can open
    """


class UnknownKind(StoreConflict, KeyError):
    """A job or a store is of a kind that no package which is installed here adds.

    Examples
    --------
    >>> from worker.kinds import KINDS
    >>> try:
    ...     KINDS["impact_speeds"]
    ... except UnknownKind as error:
    ...     print(str(error).partition(":")[0])
    there is no kind 'impact_speeds' here
    """

    __str__ = Exception.__str__  # a KeyError would quote it


class StoreFailed(WorkerError):
    """The store could not be read or written.

    Examples
    --------
    >>> import rattle
    >>> try:
    ...     rattle.open("s3://")
    ... except rattle.StoreFailed as error:
    ...     print(error)
    s3:// is no place for stores: write s3://bucket/prefix
    """


class Damaged(StoreFailed, OSError):
    """A file of a store does not hold what was written."""


class DamagedMetadata(Damaged):
    """The metadata of a store, or of an array or group within, cannot be read.

    Parameters
    ----------
    store : str
        Location of the store.
    node : str
        Path of the array or group within the store; empty for the store itself.

    Examples
    --------
    >>> from worker.errors import DamagedMetadata
    >>> print(DamagedMetadata("basin.zarr", "solution"))
    the store basin.zarr is damaged: the metadata solution/zarr.json cannot be read; `rattle check` mends it
    """

    def __init__(self, store: str, node: str) -> None:
        super().__init__(store, node)
        self.store, self.node = store, node

    def __str__(self) -> str:
        of_node = f"{self.node}/" if self.node else ""
        lost = "" if self.node else " unless its request is lost; then put back a copy of that file, or compute it anew"
        damaged = f"the store {self.store} is damaged: the metadata {of_node}zarr.json cannot be read"
        return f"{damaged}; `rattle check` mends it{lost}"


class OtherArrays(DamagedMetadata):
    """An array of a store is of another shape than the store's request asks for: one of the two was changed.

    Examples
    --------
    >>> from worker.errors import OtherArrays
    >>> print(OtherArrays("basin.zarr", "solution"))
    the store basin.zarr is damaged: solution is no array of its request; `rattle check` tells which of them to mend
    """

    def __str__(self) -> str:
        what = f"{self.node} is no array of its request"
        return f"the store {self.store} is damaged: {what}; `rattle check` tells which of them to mend"


class DamagedChunk(Damaged):
    """A chunk of a store does not hold the bytes that were written, or is missing from a finished store.

    Parameters
    ----------
    store : str
        Location of the store.
    array : str
        Path of the array within the store.
    chunk : str
        Numbers of the chunk along each dimension. One tile is one chunk.
    what : str
        What is wrong with it.

    Examples
    --------
    >>> from worker.errors import DamagedChunk
    >>> print(DamagedChunk("basin.zarr", "solution", "3/0"))
    the store basin.zarr is damaged: tile 3/0 of solution does not have its checksum; `rattle check` mends it
    """

    def __init__(self, store: str, array: str, chunk: str, what: str = "does not have its checksum") -> None:
        super().__init__(store, array, chunk, what)
        self.store, self.array, self.chunk, self.what = store, array, chunk, what

    def __str__(self) -> str:
        return (
            f"the store {self.store} is damaged: tile {self.chunk} of {self.array} {self.what}; `rattle check` mends it"
        )


class TileFailed(WorkerError):
    """A tile failed more often than retries allow."""


class ClusterFailed(WorkerError):
    """The scheduler or its workers cannot be reached."""


class UnlikeWorkers(WorkerError):
    """A worker computes without fused multiply-add for a store that was begun with it, or the other way round."""


class LeaseLost(WorkerError):
    """The job is another driver's by now."""


class JobCancelled(WorkerError):
    """The job was cancelled, or Ctrl-C stopped it. What had been computed is in the store: the same call goes on.

    Examples
    --------
    >>> import rattle
    >>> def stop(progress):
    ...     raise rattle.JobCancelled(f"stopped at {progress.tiles_done} of {progress.tiles_total} tiles")
    >>> try:
    ...     rattle.basin(cells=20, store="stopped.zarr", progress=stop)
    ... except rattle.JobCancelled as error:
    ...     print(error)
    stopped at 0 of 1 tiles
    """


# Where S3's clients look for keys that are given nowhere else: the metadata of a virtual machine.
_INSTANCE_KEYS = "http://169.254.169.254/"


@contextlib.contextmanager
def as_store_failure(location: str) -> Iterator[None]:
    """Say of any failure of the system which store it befell."""
    try:
        yield
    except Damaged:
        raise
    except _failures() as error:
        raise StoreFailed(f"the store {location} cannot be read or written: {_reason(error)}") from error


def _failures() -> tuple[type[Exception], ...]:
    """Errors of the system, and those of S3 if it is in use."""
    loaded = sys.modules.get("obstore.exceptions")
    return (OSError,) if loaded is None else (OSError, loaded.BaseError)


def _reason(error: Exception) -> str:
    """The system's reason in a line; that of S3 is in the XML of its answer, where it has answered."""
    if type(error) is FileNotFoundError and not error.strerror:  # Zarr's, which says where alone
        return "a part of it is gone; the same request computes it anew"
    message = getattr(error, "strerror", None) or str(error)
    if _INSTANCE_KEYS in message:
        return "S3 needs keys: set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY"
    answer = re.search(r"<Code>(.*?)</Code>\s*<Message>(.*?)</Message>", message)
    return f"{answer.group(1)}: {answer.group(2)}" if answer else message.partition("\n")[0].strip()

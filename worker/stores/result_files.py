"""Locations of results, and their files."""

from worker.errors import as_store_failure
from worker.stores.storage import Part, StoredFile, place_at, whole


def result_location(root: str, job_id: str) -> str:
    """Location of a job's store below the root of all results."""
    return f"{root.rstrip('/')}/{job_id}.zarr"


def holds_root(location: str) -> bool:
    """Whether the root of a store is at a location: a look at one file.

    Raises
    ------
    StoreFailed
        If that cannot be found out.
    """
    with as_store_failure(location):
        place = place_at(location)
        place.check()
        return place.read("zarr.json", lambda size, _: (0, min(size, 1))) is not None


def remove_rootless(location: str) -> None:
    """Remove what is left of a store that has lost its root: nothing can be continued there. Leave a store as it is.

    Raises
    ------
    StoreFailed
        If it cannot be removed.
    """
    with as_store_failure(location):
        place = place_at(location)
        if place.taken():
            place.remove()


def remove_result(location: str) -> None:
    """Remove a store, complete or not. Do nothing if there is none.

    Raises
    ------
    StoreFailed
        If it cannot be removed.
    """
    with as_store_failure(location):
        place_at(location).remove()


def bytes_of_result(location: str) -> int:
    """Bytes of all files of a store; 0 if there is none.

    Raises
    ------
    StoreFailed
        If it cannot be read.
    """
    with as_store_failure(location):
        return place_at(location).size()


def read_file_of_store(location: str, path: str, part: Part = whole) -> StoredFile | None:
    """Read a file of a store, or a part of it; None if it does not exist or the path leaves the store.

    Parameters
    ----------
    location : str
        Location of the store.
    path : str
        Path within the store.
    part : callable
        Returns which bytes to read, given the file's size and tag.

    Raises
    ------
    StoreFailed
        If it cannot be read.
    """
    with as_store_failure(location):
        return place_at(location).read(path, part)

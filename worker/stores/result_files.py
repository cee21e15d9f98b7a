"""Where results lie, and their files."""

from worker.errors import as_store_failure
from worker.stores.storage import Part, StoredFile, place_at, whole


def result_location(root: str, job_id: str) -> str:
    """Place of a job's store below the root of all results."""
    return f"{root.rstrip('/')}/{job_id}.zarr"


def remove_result(location: str) -> None:
    """Remove a store, whole or not; nothing happens where there is none.

    Raises
    ------
    StoreFailed
        Where it cannot be removed.
    """
    with as_store_failure(location):
        place_at(location).remove()


def read_file_of_store(location: str, path: str, part: Part = whole) -> StoredFile | None:
    """Read a file of a store, or a part of it; None where there is none, or the path leads out of the store.

    Parameters
    ----------
    location : str
        Of the store.
    path : str
        Within the store.
    part : callable
        Which bytes to read, from the size of the file and its tag.

    Raises
    ------
    StoreFailed
        Where it cannot be read.
    """
    with as_store_failure(location):
        return place_at(location).read(path, part)

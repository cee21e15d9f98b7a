"""Where results lie, and their files."""

from worker.errors import told_as_store_failure
from worker.stores.object_storage import StoredFile, place_at


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
    with told_as_store_failure(location):
        place_at(location).remove()


def file_of_store(location: str, path: str) -> StoredFile | None:
    """File of a store by its path within, or none; a path that leads out of the store is none of its files.

    Raises
    ------
    StoreFailed
        Where it cannot be read.
    """
    with told_as_store_failure(location):
        return place_at(location).read(path)

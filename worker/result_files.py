"""Where results lie, and their files."""

import shutil
from pathlib import Path

from worker.errors import told_as_store_failure


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
        with told_as_store_failure(location):
            shutil.rmtree(location)


def file_of_store(location: str, path: str) -> Path | None:
    """File of a store by its path within, or none; a path that leads out of the store is none of its files."""
    root = Path(location).resolve()
    try:
        file = (root / path).resolve()
        return file if file.is_relative_to(root) and file.is_file() else None
    except (OSError, ValueError):  # a name that no file can have
        return None

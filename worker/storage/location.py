"""Where stores are kept, and their files: the only module that distinguishes folders, buckets and addresses.

    /data/results/ID.zarr             a folder
    s3://bucket/results/ID.zarr       objects of S3 that share this prefix

Endpoint, region and credentials of S3 come from the usual ``AWS_...`` environment variables, never from a location,
because locations are logged and sent to workers.
"""

from pathlib import Path
from typing import Any

from zarr.storage import FsspecStore

from worker.errors import StoreFailed, as_store_failure
from worker.fence import Fence, unfenced
from worker.storage.checked_chunks import checked
from worker.storage.folder import folder_at
from worker.storage.protocol import Part, Storage, StoredFile, whole

_S3 = "s3://"


def storage_at(location: str, fence: Fence = unfenced) -> Storage:
    """Storage at a location.

    Parameters
    ----------
    location : str
    fence : Fence
        Needed if another driver may take the job over.

    Raises
    ------
    StoreFailed
        If the location is neither a folder nor of the form ``s3://bucket/prefix``.
    """
    if location.startswith(_S3):
        bucket, _, prefix = location.removeprefix(_S3).partition("/")
        if not bucket or not prefix.strip("/"):
            raise StoreFailed(f"{location} is no place for stores: write s3://bucket/prefix")
        try:
            from worker.storage.object_storage import objects_at
        except ModuleNotFoundError as error:
            raise StoreFailed(f"stores in S3 need {error.name}: pip install 'gear-rattle[s3]'") from error
        return objects_at(location, bucket, prefix.strip("/"), fence)
    if "://" in location:
        raise StoreFailed(f"{location} is no place for stores: write a folder or s3://bucket/prefix")
    return folder_at(Path(location))


class _ServedFiles(FsspecStore):
    """Files of a store that a service hands out."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.name = str(self.path)

    async def get(self, key: str, prototype: Any = None, byte_range: Any = None) -> Any:
        """Read a file, checked."""
        return await checked(super().get, self.name, key, prototype, byte_range)


def files_at(address: str, storage_options: dict[str, Any] | None = None) -> Any:
    """Zarr store at an address, to read.

    Parameters
    ----------
    address : str
    storage_options : dict, optional
        ``headers`` of its requests.
    """
    return _ServedFiles.from_url(address, storage_options=storage_options, read_only=True)


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
        storage = storage_at(location)
        storage.check()
        return storage.read("zarr.json", lambda size, _: (0, min(size, 1))) is not None


def remove_rootless(location: str) -> None:
    """Remove what is left of a store that has lost its root: nothing can be continued there. Leave a store as it is.

    Raises
    ------
    StoreFailed
        If it cannot be removed.
    """
    with as_store_failure(location):
        storage = storage_at(location)
        if storage.taken():
            storage.remove()


def remove_result(location: str) -> None:
    """Remove a store, complete or not. Do nothing if there is none.

    Raises
    ------
    StoreFailed
        If it cannot be removed.
    """
    with as_store_failure(location):
        storage_at(location).remove()


def bytes_of_result(location: str) -> int:
    """Bytes of all files of a store; 0 if there is none.

    Raises
    ------
    StoreFailed
        If it cannot be read.
    """
    with as_store_failure(location):
        return storage_at(location).size()


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
        return storage_at(location).read(path, part)

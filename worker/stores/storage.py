"""Where stores are kept: the only module that distinguishes folders and buckets.

    /data/results/ID.zarr             a folder
    s3://bucket/results/ID.zarr       objects of S3 that share this prefix

Endpoint, region and credentials of S3 come from the usual ``AWS_...`` environment variables, never from a location,
because locations are logged and sent to workers.
"""

import os
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from worker.errors import StoreFailed
from worker.fence import Fence, unfenced
from worker.stores.files.synced_files import SyncedFiles, write_file

_S3 = "s3://"


@dataclass(frozen=True)
class StoredFile:
    """Bytes of a file of a store from `start` on, the size of the whole, and a tag that changes with its content."""

    content: bytes
    start: int
    size: int
    tag: str


Part = Callable[[int, str], tuple[int, int]]
"""First byte to read of a file and the one after the last, from its size and tag."""


def whole(size: int, tag: str) -> tuple[int, int]:
    """Part of a file that is all of it."""
    return 0, size


class Place(Protocol):
    """A location of a store, existing or new."""

    @property
    def zarr(self) -> Any:
        """The store for Zarr and xarray."""

    def check(self) -> None:
        """Raise the system's error if there can be no store, for example because the bucket is gone."""

    def taken(self) -> bool:
        """Whether the location holds anything other than a store or the beginning of one."""

    def read(self, path: str, part: Part) -> StoredFile | None:
        """Part of a file by its path; None if it does not exist or the path leaves the store."""

    def folders(self, path: str) -> list[str]:
        """Names of the folders below a path of the store, ascending."""

    def write(self, path: str, content: bytes) -> None:
        """Write a file."""

    def paths(self) -> list[str]:
        """Paths of all files of the store, ascending."""

    def size(self) -> int:
        """Bytes of all files of the store."""

    def discard(self, paths: Sequence[str]) -> None:
        """Remove some files, if they are there."""

    def sweep(self) -> None:
        """Remove files that killed writers have left."""

    def remove(self) -> None:
        """Remove everything, if there is anything."""


def place_at(location: str, fence: Fence = unfenced) -> Place:
    """Place at a location.

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
            from worker.stores.files.object_storage import objects_at
        except ModuleNotFoundError as error:
            raise StoreFailed(f"stores in S3 need {error.name}: pip install 'gear-rattle[s3]'") from error
        return objects_at(location, bucket, prefix.strip("/"), fence)
    if "://" in location:
        raise StoreFailed(f"{location} is no place for stores: write a folder or s3://bucket/prefix")
    return _Folder(Path(location))


class _Folder:
    """A folder of the file system."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.zarr = SyncedFiles(path)

    def check(self) -> None:
        pass  # a folder is made with its store

    def taken(self) -> bool:
        if not self.path.is_dir():
            return self.path.exists()
        begun = (self.path / "zarr.json").exists()
        return not begun and any(each.suffix != ".partial" for each in self.path.iterdir())

    def read(self, path: str, part: Part) -> StoredFile | None:
        root = self.path.resolve()
        try:
            file = (root / path).resolve()
            if not file.is_relative_to(root) or not file.is_file():
                return None
            with file.open("rb") as opened:  # the same file, even if it is replaced meanwhile
                status = os.fstat(opened.fileno())
                tag = f"{status.st_mtime_ns:x}-{status.st_size:x}"
                start, stop = part(status.st_size, tag)
                opened.seek(start)
                return StoredFile(opened.read(stop - start), start, status.st_size, tag)
        except (FileNotFoundError, ValueError):  # removed meanwhile, or not a valid file name
            return None

    def folders(self, path: str) -> list[str]:
        try:
            with os.scandir(self.path / path) as found:
                return sorted(each.name for each in found if each.is_dir())
        except FileNotFoundError:
            return []

    def write(self, path: str, content: bytes) -> None:
        write_file(self.path, path, content)

    def paths(self) -> list[str]:
        return sorted(path.relative_to(self.path).as_posix() for path in self.path.rglob("*") if path.is_file())

    def size(self) -> int:
        return sum(path.stat().st_size for path in self.path.rglob("*") if path.is_file())

    def discard(self, paths: Sequence[str]) -> None:
        for path in paths:
            (self.path / path).unlink(missing_ok=True)

    def sweep(self) -> None:
        for orphan in self.path.rglob("*.partial"):
            orphan.unlink(missing_ok=True)

    def remove(self) -> None:
        if self.path.exists():
            shutil.rmtree(self.path)

"""What every kind of storage does: a folder of files, or objects that share a prefix."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol


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


class Storage(Protocol):
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

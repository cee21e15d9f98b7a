"""Files of a store in a folder, and when they are on the disk.

Guarantees. A file takes its name as a whole. Outside `synced_together` it is on the disk when its write returns, and so
is its name. Inside, a new file may follow later: all of them are on the disk when the block ends. So what is written
after a block, such as the ledger, never speaks of a file that a power cut can take away.

Inside such a block, too, two kinds of files are synced before they take their names. A file that replaces another: some
file systems would otherwise be left with an empty one after a power cut. And metadata: whoever goes on with a store
reads those of every array that has a name, claimed or not.

So a power cut may leave an empty or partial chunk that nothing claims. `write_over` takes it for none.

obstore writes the files of S3, and could write these; but its files in a folder are not synced: `LocalStore` of version
0.12.1 has no option for it, though object_store 0.14.2 within has (`docs/decisions/0039-power-cuts.md`).
"""

import asyncio
import os
import shutil
import uuid
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from typing import Any

from zarr.storage import LocalStore

from worker.errors import as_store_failure
from worker.storage.checked_chunks import CHUNKS, METADATA, checked
from worker.storage.protocol import Part, Storage, StoredFile

# A journal takes what is synced at the same time in one go.
_AT_A_TIME = 32
# Windows cannot open a folder to sync it.
_FOLDERS_CAN_BE_SYNCED = os.name == "posix"


@cache
def _syncing(process: int) -> ThreadPoolExecutor:
    """Threads that stay, since starting them takes longer than a sync. A fork has none of them, and starts its own."""
    return ThreadPoolExecutor(_AT_A_TIME, "sync")


class Unsynced:
    """Files that are not yet known to be on the disk, and folders that may lack their names."""

    def __init__(self) -> None:
        self.files: list[Path] = []
        self.folders: dict[Path, None] = {}

    def sync(self) -> None:
        """Wait until all are on the disk, in any order: nothing has spoken of them yet."""
        folders = list(self.folders) if _FOLDERS_CAN_BE_SYNCED else []
        list(_syncing(os.getpid()).map(_sync, self.files + folders))


# Zarr writes in other threads. They see this variable, since asyncio hands the caller's context to them.
_together: ContextVar[Unsynced | None] = ContextVar("together", default=None)


@contextmanager
def synced_together(location: str) -> Iterator[None]:
    """Sync the new files that are written inside at the end, all at once.

    If the block raises, nothing is synced and nothing is promised. A block within another syncs what is written in it.

    Parameters
    ----------
    location : str
        The store, as errors name it.

    Raises
    ------
    StoreFailed
        If the disk does not take them.
    """
    unsynced = Unsynced()
    token = _together.set(unsynced)
    try:
        yield
    finally:
        _together.reset(token)
    with as_store_failure(location):
        unsynced.sync()


class SyncedFiles(LocalStore):
    """Zarr's store in a folder, whose files survive a power cut."""

    def __init__(self, root: Path | str, *, read_only: bool = False) -> None:
        super().__init__(root, read_only=read_only)
        self.name = str(root)

    async def _open(self, *, mode: Any = None) -> None:
        """Make no folder: only a file that is written does."""
        self._is_open = True

    async def get(self, key: str, prototype: Any = None, byte_range: Any = None) -> Any:
        """Read a file, checked."""
        return await checked(super().get, self.name, key, prototype, byte_range)

    async def set(self, key: str, value: Any) -> None:
        """Write a file."""
        self._check_writable()
        await asyncio.to_thread(write_file, self.root, key, value.as_buffer_like())

    async def set_if_not_exists(self, key: str, value: Any) -> None:
        """Write a file unless it is there."""
        if not (self.root / key).exists():
            await self.set(key, value)

    def set_sync(self, key: str, value: Any) -> None:
        """Write a file, in this thread."""
        self._check_writable()
        write_file(self.root, key, value.as_buffer_like())


def write_file(root: Path, key: str, content: Any) -> None:
    """Write a file of a store as a whole.

    Parameters
    ----------
    root : Path
        Folder of the store.
    key : str
        Path of the file within.
    content : bytes-like
    """
    path, together = root / key, _together.get()
    path.parent.mkdir(parents=True, exist_ok=True)
    replaces = path.exists()
    later = together is not None and not replaces and path.name != METADATA
    partial = path.with_name(f"{path.name}.{uuid.uuid4().hex}.partial")
    try:
        with partial.open("wb") as file:
            file.write(content)
            if not later:
                file.flush()
                os.fsync(file.fileno())
        partial.replace(path)
    except OSError:
        partial.unlink(missing_ok=True)
        raise
    unsynced = together or Unsynced()
    if later:
        unsynced.files.append(path)
    unsynced.folders.update(dict.fromkeys([path.parent] if replaces else _folders_to(root, path)))
    if together is None:
        unsynced.sync()


def _folders_to(root: Path, path: Path) -> list[Path]:
    """Folders with the names that lead to a new file from what was there before its array or group.

    Other writers may have made some of them, and may be killed before they are on the disk. So each syncs all.
    """
    if path.name == METADATA:
        return [path.parent, path.parent.parent]
    within = path.relative_to(root).parts
    depth = within.index(CHUNKS) if CHUNKS in within else 0
    return list(path.parents)[: len(within) - depth]


def _sync(path: Path) -> None:
    opened = os.open(path, os.O_RDONLY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)


def folder_at(path: Path) -> Storage:
    """Storage of a store whose files lie in a folder."""
    return _Folder(path)


class _Folder:
    """A store's files in a folder of the file system."""

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

"""Where stores are kept: the only module that distinguishes folders and buckets.

    /data/results/ID.zarr             a folder
    s3://bucket/results/ID.zarr       objects of S3 that share this prefix

Endpoint, region and credentials of S3 come from the usual ``AWS_...`` environment variables, never from a location,
because locations are logged and sent to workers.
"""

import asyncio
import contextlib
import os
import re
import shutil
import time
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import obstore
from obstore.exceptions import GenericError
from obstore.store import S3Store
from zarr.storage import ObjectStore

from worker.errors import StoreFailed
from worker.fence import Fence, unfenced

if TYPE_CHECKING:  # not there when it runs
    from obstore.store import ClientConfig, RetryConfig

_S3 = "s3://"
# A missing server is noticed within seconds. Requests to a busy one are repeated for longer than an election takes.
_PATIENCE_SECONDS, _FIRST_PAUSE_SECONDS, _LONGEST_PAUSE_SECONDS = 15.0, 0.1, 3.0
_RETRIES: "RetryConfig" = {
    "max_retries": 6,
    "retry_timeout": timedelta(seconds=_PATIENCE_SECONDS),
    "backoff": {
        "init_backoff": timedelta(seconds=_FIRST_PAUSE_SECONDS),
        "max_backoff": timedelta(seconds=_LONGEST_PAUSE_SECONDS),
        "base": 2,
    },
}
_TIMEOUTS: "ClientConfig" = {"connect_timeout": "5s", "timeout": "30s"}
# A lease is lost five seconds before another driver may begin. A fenced request ends within that time.
_ONCE: "RetryConfig" = {"max_retries": 0, "retry_timeout": timedelta(0)}
_HURRY: "ClientConfig" = {"connect_timeout": "2s", "timeout": "4s"}
_DEFAULT_REGION = "us-east-1"
_REGIONS = ("AWS_REGION", "AWS_DEFAULT_REGION")
_ENDPOINTS = ("AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL", "AWS_ENDPOINT")


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
        """Whether the location holds something that is not even the beginning of a store."""

    def read(self, path: str, part: Part) -> StoredFile | None:
        """Part of a file by its path within; None where there is none, or the path leads out."""

    def folders(self, path: str) -> list[str]:
        """Names of the folders below a path of the store, ascending."""

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
        return _Objects(location, bucket, prefix.strip("/"), fence)
    if "://" in location:
        raise StoreFailed(f"{location} is no place for stores: write a folder or s3://bucket/prefix")
    return _Folder(Path(location))


class _Folder:
    """A folder of the file system."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.zarr = str(path)

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
            with file.open("rb") as opened:  # one file, even where it is replaced in the meantime
                status = os.fstat(opened.fileno())
                tag = f"{status.st_mtime_ns:x}-{status.st_size:x}"
                start, stop = part(status.st_size, tag)
                opened.seek(start)
                return StoredFile(opened.read(stop - start), start, status.st_size, tag)
        except (FileNotFoundError, ValueError):  # removed in the meantime, or a name that no file can have
            return None

    def folders(self, path: str) -> list[str]:
        try:
            with os.scandir(self.path / path) as found:
                return sorted(each.name for each in found if each.is_dir())
        except FileNotFoundError:
            return []

    def sweep(self) -> None:
        for orphan in self.path.rglob("*.partial"):
            orphan.unlink(missing_ok=True)

    def remove(self) -> None:
        if self.path.exists():
            shutil.rmtree(self.path)


class _WholeObjects(ObjectStore):
    """Objects written in one request each, so a killed writer leaves the old one or the new one, and no parts."""

    async def set(self, key: str, value: Any) -> None:
        self._check_writable()
        await obstore.put_async(self.store, key, value.as_buffer_like(), use_multipart=False)


class _FencedObjects(_WholeObjects):
    """Objects written by a driver whose job another driver may take over.

    Guarantees. Each request is sent after a check of the fence, and given up before another driver may begin. So a
    server that hangs accepts none of them later. A failed request is sent again after another check.
    """

    def __init__(self, store: Any, hurried: Any, fence: Fence, *, read_only: bool = False) -> None:
        super().__init__(store, read_only=read_only)
        self.hurried, self.fence = hurried, fence

    def with_read_only(self, read_only: bool = False) -> "_FencedObjects":
        return type(self)(self.store, self.hurried, self.fence, read_only=read_only)

    async def set(self, key: str, value: Any) -> None:
        self._check_writable()
        data = value.as_buffer_like()
        await self._patiently(lambda: obstore.put_async(self.hurried, key, data, use_multipart=False))

    async def delete(self, key: str) -> None:
        self._check_writable()
        with contextlib.suppress(FileNotFoundError):
            await self._patiently(lambda: obstore.delete_async(self.hurried, key))

    async def _patiently(self, send: Callable[[], Awaitable[Any]]) -> None:
        begin, pause = time.monotonic(), _FIRST_PAUSE_SECONDS
        while True:
            self.fence()
            try:
                await send()
                return
            except GenericError:  # the server is gone, busy, or too slow
                if time.monotonic() + pause > begin + _PATIENCE_SECONDS:
                    raise
            await asyncio.sleep(pause)
            pause = min(2.0 * pause, _LONGEST_PAUSE_SECONDS)


class _Objects:
    """Objects of S3 below a prefix."""

    def __init__(self, location: str, bucket: str, prefix: str, fence: Fence) -> None:
        # An address that begins with http:// is a decision to do without TLS.
        options: ClientConfig = {**_TIMEOUTS, "allow_http": _variable(_ENDPOINTS).startswith("http://")}
        region = _variable(_REGIONS) or _DEFAULT_REGION
        self._store = S3Store(bucket, prefix=prefix, region=region, retry_config=_RETRIES, client_options=options)
        self.zarr = _WholeObjects(self._store)
        if fence is not unfenced:
            hurry: ClientConfig = {**options, **_HURRY}
            once = S3Store(bucket, prefix=prefix, region=region, retry_config=_ONCE, client_options=hurry)
            self.zarr = _FencedObjects(self._store, once, fence)

    def _paths(self) -> list[str]:
        return [found["path"] for batch in obstore.list(self._store) for found in batch]

    def check(self) -> None:
        next(obstore.list(self._store, chunk_size=1), None)

    def taken(self) -> bool:
        paths = self._paths()
        return bool(paths) and "zarr.json" not in paths

    def read(self, path: str, part: Part) -> StoredFile | None:
        try:
            answer = obstore.get(self._store, path)  # the content is sent when it is read
        except (FileNotFoundError, ValueError):  # none there, or a path with steps such as ".."
            return None
        size, tag = answer.meta["size"], re.sub(r"\W", "", answer.meta["e_tag"] or "")
        start, stop = part(size, tag)
        if (start, stop) == (0, size):
            return StoredFile(bytes(answer.bytes()), start, size, tag)
        return StoredFile(bytes(obstore.get_range(self._store, path, start=start, end=stop)), start, size, tag)

    def folders(self, path: str) -> list[str]:
        found = obstore.list_with_delimiter(self._store, f"{path}/")
        return sorted(prefix.rstrip("/").rpartition("/")[2] for prefix in found["common_prefixes"])

    def sweep(self) -> None:
        """Do nothing: objects appear as a whole or not at all."""

    def remove(self) -> None:
        obstore.delete(self._store, self._paths())


def _variable(names: Sequence[str]) -> str:
    return next((os.environ[name] for name in names if os.environ.get(name)), "")

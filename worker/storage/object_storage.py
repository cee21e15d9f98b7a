"""Stores in S3: objects that share a prefix. Loaded only for a location that begins with ``s3://``."""

import asyncio
import contextlib
import os
import re
import time
from collections.abc import Awaitable, Callable, Sequence
from datetime import timedelta
from typing import TYPE_CHECKING, Any

import obstore
from obstore.exceptions import GenericError
from obstore.store import S3Store
from zarr.storage import ObjectStore

from worker.fence import Fence, unfenced
from worker.storage.checked_chunks import checked
from worker.storage.protocol import Part, Storage, StoredFile

if TYPE_CHECKING:  # not available at run time
    from obstore.store import ClientConfig, RetryConfig

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


def objects_at(location: str, bucket: str, prefix: str, fence: Fence) -> Storage:
    """Storage of a store whose objects share a prefix; `fence` is the driver's."""
    return _Objects(location, bucket, prefix, fence)


class _WholeObjects(ObjectStore):
    """Objects written in one request each, so a killed writer leaves the old object or the new one, never a part.

    Nothing has to be synced: S3 answers a PUT when the object is stored.
    """

    def __init__(self, store: Any, name: str, *, read_only: bool = False) -> None:
        super().__init__(store, read_only=read_only)
        self.name = name

    def with_read_only(self, read_only: bool = False) -> "_WholeObjects":
        return type(self)(self.store, self.name, read_only=read_only)

    async def get(self, key: str, prototype: Any = None, byte_range: Any = None) -> Any:
        """Read a file, checked."""
        return await checked(super().get, self.name, key, prototype, byte_range)

    async def set(self, key: str, value: Any) -> None:
        self._check_writable()
        await obstore.put_async(self.store, key, value.as_buffer_like(), use_multipart=False)


class _FencedObjects(_WholeObjects):
    """Objects written by a driver whose job another driver may take over.

    Guarantees. Each request is sent after a check of the fence, and given up before another driver may begin. So a
    server that hangs accepts none of them later. A failed request is sent again after another check.
    """

    def __init__(self, store: Any, name: str, hurried: Any, fence: Fence, *, read_only: bool = False) -> None:
        super().__init__(store, name, read_only=read_only)
        self.hurried, self.fence = hurried, fence

    def with_read_only(self, read_only: bool = False) -> "_FencedObjects":
        return type(self)(self.store, self.name, self.hurried, self.fence, read_only=read_only)

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
        # An endpoint that begins with http:// opts out of TLS.
        options: ClientConfig = {**_TIMEOUTS, "allow_http": _variable(_ENDPOINTS).startswith("http://")}
        region = _variable(_REGIONS) or _DEFAULT_REGION
        self._store = S3Store(bucket, prefix=prefix, region=region, retry_config=_RETRIES, client_options=options)
        self.zarr = _WholeObjects(self._store, location)
        if fence is not unfenced:
            hurry: ClientConfig = {**options, **_HURRY}
            once = S3Store(bucket, prefix=prefix, region=region, retry_config=_ONCE, client_options=hurry)
            self.zarr = _FencedObjects(self._store, location, once, fence)

    def write(self, path: str, content: bytes) -> None:
        obstore.put(self._store, path, content, use_multipart=False)

    def paths(self) -> list[str]:
        return sorted(found["path"] for batch in obstore.list(self._store) for found in batch)

    def size(self) -> int:
        return sum(found["size"] for batch in obstore.list(self._store) for found in batch)

    def discard(self, paths: Sequence[str]) -> None:
        there = sorted(set(paths).intersection(self.paths()))
        if there:
            obstore.delete(self._store, there)

    def check(self) -> None:
        next(obstore.list(self._store, chunk_size=1), None)

    def taken(self) -> bool:
        paths = self.paths()
        return bool(paths) and "zarr.json" not in paths

    def read(self, path: str, part: Part) -> StoredFile | None:
        try:
            answer = obstore.get(self._store, path)  # the content is sent when it is read
        except (FileNotFoundError, ValueError):  # missing, or a path with parts such as ".."
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
        obstore.delete(self._store, self.paths())


def _variable(names: Sequence[str]) -> str:
    return next((os.environ[name] for name in names if os.environ.get(name)), "")

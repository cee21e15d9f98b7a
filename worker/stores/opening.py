"""Stores of any kind at a location: whether there is one, how to open it, and how to create one.

A process opens a store once for all who read it. The root says which revision of the store is there: it holds all
metadata, and is written anew whenever they change. So each look at a store begins with a look at its root, and one that
has changed, or is gone, is never answered from an earlier look.
"""

import json
import threading
from collections.abc import Callable, Collection
from contextlib import suppress
from typing import Any, NamedTuple, TypeVar

import zarr
from cachetools import LRUCache, cached

from worker.errors import InvalidJob, OutsideDomain, StoreConflict, StoreFailed, as_store_failure
from worker.fence import Fence, unfenced
from worker.jobs.job import Job
from worker.rounding import demand_same_rounding
from worker.storage.checked_chunks import METADATA
from worker.storage.location import storage_at
from worker.storage.protocol import whole

_NOTHING_THERE = (FileNotFoundError, NotADirectoryError, ValueError)
_AnyStore = TypeVar("_AnyStore")
_AnyJob = TypeVar("_AnyJob", bound=Job)


class _Opened(NamedTuple):
    """A store, or the attributes of a root, and the bytes of the root when it was opened."""

    root: bytes
    value: Any


# Jobs whose tasks one process takes by turns.
_MOST_JOBS = 16
# By the bytes of their roots; each has handles and a job beside them.
_MOST_BYTES, _BESIDE = 1 << 25, 1 << 15
_OPENED: LRUCache[tuple[Callable[[str], Any], str], _Opened] = LRUCache(
    _MOST_BYTES, getsizeof=lambda opened: _BESIDE + len(opened.root)
)
_LOCK = threading.Lock()


def opened_once(open_at: Callable[[str], _AnyStore], location: str) -> _AnyStore:
    """What `open_at` makes of a location, made once in each process for as long as the root there stays as it is.

    All threads share it. What `open_at` raises is raised, and not kept.
    """
    root = _root_at(location)
    with _LOCK:
        known = _OPENED.get((open_at, location))
    if known is not None and known.root == root:
        value: _AnyStore = known.value
        return value
    value = open_at(location)
    # Of a root that has changed meanwhile nobody knows whether it is the one that was opened.
    if root is not None and root == _root_at(location):
        with _LOCK, suppress(ValueError):  # too large to be kept
            _OPENED[open_at, location] = _Opened(root, value)
    return value


@cached(LRUCache(_MOST_JOBS), lock=threading.Lock())
def opened_for_tasks(open_at: Callable[[str], Any], location: str, digest: str) -> Any:
    """Store of the job with this digest, for its tasks. The same digest means the same layout: no look at the root.

    Raises
    ------
    StoreConflict
        If the store was replaced by another request's since the job began.
    UnlikeWorkers
        If it was begun by processors that round otherwise.
    """
    store = open_at(location)
    if store.digest != digest:
        raise StoreConflict(f"{location} holds the store of another request by now")
    demand_same_rounding(location, store.attributes)
    return store


def _root_at(location: str) -> bytes | None:
    """The root of a store as it lies there; None if there is none."""
    with as_store_failure(location):
        file = storage_at(location).read(METADATA, whole)
    return None if file is None else file.content


def trusted_job(job_class: Callable[[dict[str, Any], str], _AnyJob], location: str, attributes: Any) -> _AnyJob:
    """Job of a store with these attributes; `job_class` makes it of its request and its digest.

    Raises
    ------
    StoreFailed
        If its request is not the one that it was made for.
    """
    try:
        return job_class(json.loads(str(attributes["request"])), str(attributes.get("request_sha256")))
    except (InvalidJob, OutsideDomain) as error:
        message = f"the request of the store {location} cannot be read: {error}"
        raise StoreFailed(f"{message}; `rattle check` tells what to do") from error


def open_group(location: str, mode: str, *, consolidated: bool = False, fence: Fence = unfenced) -> Any:
    """Root group at a location. Raises Zarr's errors."""
    return zarr.open_group(storage_at(location, fence).zarr, mode=mode, zarr_format=3, use_consolidated=consolidated)


def open_store_at(location: str, what: str, fence: Fence) -> Any:
    """Root of a store, for reading and writing. `what` names the expected kind of store, `fence` is the driver's.

    Raises
    ------
    StoreConflict
        If the location holds nothing that Zarr can open.
    StoreFailed
        If it cannot be read.
    """
    with as_store_failure(location):
        try:
            return open_group(location, "r+", fence=fence)
        except _NOTHING_THERE as error:
            raise StoreConflict(f"{location} is no {what}: nothing there that Zarr can open") from error


def _attributes_at(location: str) -> dict[str, Any]:
    with as_store_failure(location):
        try:
            return dict(open_group(location, "r").attrs)
        except _NOTHING_THERE:
            storage_at(location).check()
            return {}


def attributes_of(location: str) -> dict[str, Any]:
    """Attributes of the store at a location; none where there is no store."""
    attributes = opened_once(_attributes_at, location)
    # They are created last of all.
    return attributes if "layout_version" in attributes else {}


def holds_store(location: str) -> bool:
    """Whether a location holds a store of any kind."""
    return bool(attributes_of(location))


def is_complete(location: str, digest: str) -> bool:
    """Whether a location holds the complete store of the request with this digest."""
    attributes = attributes_of(location)
    return bool(attributes.get("complete")) and attributes.get("request_sha256") == digest


def create_unless_there(location: str, what: str, create: Callable[[], None], fence: Fence) -> None:
    """Create a store unless one exists.

    Raises
    ------
    StoreConflict
        If the location holds something that is not a store.
    StoreFailed
        If it cannot be written.
    """
    if holds_store(location):
        return
    fence()
    with as_store_failure(location):
        if storage_at(location).taken():
            raise StoreConflict(f"{location} exists and is no {what}: choose another location, or remove it")
        create()


def demand_all_known(location: str, unread: Collection[str]) -> None:
    """Refuse to compute a store of whose request nothing here knows some fields, `unread`.

    Raises
    ------
    StoreConflict
    """
    if unread:
        raise StoreConflict(f"{location} has {', '.join(unread)} as well: install the package that adds it")


def check_same_request(location: str, digest: str, there: str, request: dict[str, Any]) -> None:
    """Refuse a store of another request. `there` and `request` are the store's digest and request.

    Raises
    ------
    StoreConflict
    """
    if there != digest:
        raise StoreConflict(
            f"{location} holds the store of another request: choose another location, or remove it\n"
            f"it holds {json.dumps(request)}"
        )

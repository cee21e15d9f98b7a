"""Stores of any kind at a location: whether there is one, how to open it, and how to create one."""

import json
from collections.abc import Callable, Collection
from typing import Any

import zarr

from worker.errors import StoreConflict, StoreFailed, as_store_failure
from worker.fence import Fence, unfenced
from worker.storage.location import storage_at

_NOTHING_THERE = (FileNotFoundError, NotADirectoryError, ValueError)


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


def holds_store(location: str) -> bool:
    """Whether a location holds a store of any kind. Its attributes are created last of all."""
    with as_store_failure(location):
        try:
            group = open_group(location, "r")
        except _NOTHING_THERE:
            storage_at(location).check()
            return False
        return "layout_version" in group.attrs


def is_complete(location: str, digest: str) -> bool:
    """Whether a location holds the complete store of the request with this digest."""
    if not holds_store(location):
        return False
    with as_store_failure(location):
        attributes = open_group(location, "r").attrs
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


def demand_same_digest(location: str, there: str, digest: str) -> None:
    """Refuse a store that was replaced by another request's since the job began; `there` is the store's digest.

    Raises
    ------
    StoreConflict
    """
    if there != digest:
        raise StoreConflict(f"{location} holds the store of another request by now")


def demand_own_request(location: str, digest: str, there: Any) -> None:
    """Refuse a store whose request is not the one that it was made for. `there` is the digest that it was given then.

    Raises
    ------
    StoreFailed
    """
    if there != digest:
        raise StoreFailed(
            f"the request of the store {location} cannot be read: it does not have the digest that was stored with it; "
            "`rattle check` tells what to do"
        )


def demand_same_request(location: str, digest: str, there: str, request: dict[str, Any]) -> None:
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

"""Which metadata are right: an array's own, or those that the root says once more."""

import copy
import json
from collections.abc import Mapping
from typing import Any, NamedTuple

from zarr import Array
from zarr.core.array import AsyncArray
from zarr.core.group import GroupMetadata
from zarr.core.metadata.v3 import ArrayV3Metadata
from zarr.storage import StorePath

from worker.additions import additions
from worker.errors import DamagedMetadata, StoreConflict, as_store_failure
from worker.jobs.basin_job import BasinJob
from worker.jobs.job import Job
from worker.storage.checked_chunks import METADATA
from worker.storage.location import storage_at
from worker.storage.protocol import whole
from worker.stores.analysis_store import PARTS
from worker.stores.new_store import consolidate, new_metadata

MISSING = "they are missing"
OTHERS = "they are not those that the root has"
COPY_IS_WRONG = "what they say once more of the arrays is not so"
ROOT_IS_WRONG = "they cannot be read as those of a store"

_DEMANDED = ("request", "request_sha256", "layout_version", "complete")
_NODE_TYPES = {"array": ArrayV3Metadata, "group": GroupMetadata}
# No other root of this project has these values.
_OF_ROOTS = {"zarr_format": 3, "node_type": "group"}


class Root(NamedTuple):
    """What the root's own metadata say: its attributes, and the metadata of every array and group once more.

    ``damaged`` if Zarr cannot open a store with such a root.
    """

    attributes: dict[str, Any]
    nodes: dict[str, Any]
    damaged: bool


class Metadata(NamedTuple):
    """The right metadata of every array and group by path, and what is damaged.

    ``lost`` has the paths of those that are not right in their own place, with what is wrong there. ``copy_is_wrong``
    if the root says others once more.
    """

    nodes: dict[str, Any]
    lost: dict[str, str]
    copy_is_wrong: bool


def read_root(location: str) -> Root:
    """Read the root's metadata; of damaged ones, the attributes.

    Parameters
    ----------
    location : str

    Returns
    -------
    Root

    Raises
    ------
    StoreConflict
        If there is no store.
    StoreFailed
        If it cannot be read, or its attributes are lost: nothing else says what it holds.
    """
    with as_store_failure(location):
        storage_at(location).check()
        file = storage_at(location).read(METADATA, whole)
    if file is None:
        raise StoreConflict(f"{location} is no basin store, and none of an analysis: nothing there that Zarr can open")
    document = _object(file.content)
    attributes = (document or {}).get("attributes")
    if not isinstance(attributes, dict):
        attributes = _rescued(file.content)
    if any(name not in attributes for name in _DEMANDED):
        if document is not None and document.get("node_type") == "group" and document.get("attributes") == {}:
            raise StoreConflict(f"{location} is no basin store, and none of an analysis: it is another group of Zarr")
        raise DamagedMetadata(location, "")
    collected = (document or {}).get("consolidated_metadata")
    nodes = collected.get("metadata") if isinstance(collected, dict) else None
    nodes = nodes if isinstance(nodes, dict) else {}
    sound = document is not None and {name: document.get(name) for name in _OF_ROOTS} == _OF_ROOTS
    own = {path: _own(node) for path, node in nodes.items() if path.split("/")[0] != PARTS and isinstance(node, dict)}
    return Root(attributes, own, not (sound and _opens(document)))


def right_metadata(location: str, job: Job, root: Root, paths: list[str]) -> Metadata:
    """The right metadata of every array and group, and what is wrong with the others.

    Those of an unfinished store may differ: a driver may have been stopped between the two. Where both can be read, a
    new store of the same job decides. Where neither can, that is what is left.

    Parameters
    ----------
    location : str
    job : Job
    root : Root
    paths : list of str
        Of all files of the store.

    Raises
    ------
    DamagedMetadata
        If those of an array are damaged in both places, and no new store has them.
    """
    complete = bool(root.attributes["complete"])
    files = {path.removesuffix(f"/{METADATA}") for path in paths if path.endswith(f"/{METADATA}")}
    files = {path for path in files if path.split("/")[0] != PARTS}
    unlisted = files - root.nodes.keys() if complete or root.damaged else set()
    fresh = {path: _own(node) for path, node in new_metadata(job).items()} if isinstance(job, BasinJob) else {}
    nodes, lost, copy_is_wrong = dict[str, Any](), dict[str, str](), False
    for path in [*root.nodes, *sorted(unlisted)]:
        own, copied = _sound(_read(location, path) if path in files else None), _sound(root.nodes.get(path))
        known = not fresh or path in fresh or any(addition.owns(path) for addition in additions())
        if own is None and complete and unlisted and path not in fresh and not _has_files(paths, path):
            copy_is_wrong = True  # by a name that no array of the store has
            continue
        if own is None and copied is None:
            copied = _sound(fresh.get(path))
            if copied is None or 0 in copied.get("shape", ()):
                if not known:
                    continue  # a name that is none of the store, or another program's
                raise DamagedMetadata(location, path)
        ahead = _agreement(own, fresh.get(path)) > _agreement(copied, fresh.get(path))
        if own is None or (copied not in (None, own) and complete and not ahead):
            lost[path] = OTHERS if path in files else MISSING
            own = copied
        copy_is_wrong |= complete and own != copied
        nodes[path] = own
    return Metadata(nodes, lost, copy_is_wrong)


def restore_metadata(location: str, root: Root, metadata: Metadata) -> None:
    """Write damaged metadata anew, and collect those of all arrays at the root again.

    Parameters
    ----------
    location : str
    root : Root
    metadata : Metadata
    """
    with as_store_failure(location):
        place = storage_at(location)
        for path in metadata.lost:
            place.write(f"{path}/{METADATA}", _written(metadata.nodes[path]))
        if root.damaged:
            place.write(METADATA, _written({"attributes": root.attributes, **_OF_ROOTS}))
        if root.damaged or metadata.copy_is_wrong:
            consolidate(location)


def array_of(location: str, path: str, node: Mapping[str, Any]) -> Any:
    """An array by its right metadata, whatever those in the store are."""
    metadata = ArrayV3Metadata.from_dict(copy.deepcopy(dict(node)))
    return Array(AsyncArray(metadata=metadata, store_path=StorePath(storage_at(location).zarr, path)))


def _written(node: Mapping[str, Any]) -> bytes:
    return json.dumps(node, indent=2).encode()


def _own(node: Mapping[str, Any]) -> dict[str, Any]:
    return {name: node[name] for name in node if name != "consolidated_metadata"}


def _object(content: bytes) -> dict[str, Any] | None:
    try:
        node = json.loads(content)
    except (ValueError, RecursionError):
        return None
    return node if isinstance(node, dict) else None


def _rescued(content: bytes) -> dict[str, Any]:
    """Attributes of a root that is no JSON any more. They come first, and may be whole."""
    text = content.decode("utf-8", "replace")
    begin = text.find("{", 1)
    try:
        attributes = json.JSONDecoder().raw_decode(text, begin)[0] if begin > 0 else {}
    except (ValueError, RecursionError):
        return {}
    return attributes if isinstance(attributes, dict) else {}


def _read(location: str, path: str) -> dict[str, Any] | None:
    with as_store_failure(location):
        file = storage_at(location).read(f"{path}/{METADATA}", whole)
    node = _object(file.content) if file else None
    return None if node is None else _own(node)


def _opens(node: Mapping[str, Any] | None) -> bool:
    """Whether Zarr can open such metadata. What its readers raise of damaged ones is of any kind."""
    try:
        _NODE_TYPES[node["node_type"]].from_dict(copy.deepcopy(dict(node)))  # type: ignore[index, arg-type]
    except Exception:
        return False
    return True


def _sound(node: dict[str, Any] | None) -> dict[str, Any] | None:
    return node if node is not None and _opens(node) else None


def _has_files(paths: list[str], folder: str) -> bool:
    return any(path.startswith(f"{folder}/") for path in paths)


def _agreement(node: Mapping[str, Any] | None, fresh: Mapping[str, Any] | None) -> int:
    """How much of metadata is as in a new store. Lengths of solutions, and attributes, are found while computing."""
    if fresh is None or node is None:
        return 0
    same = sum(node.get(name) == fresh[name] for name in fresh if name not in ("attributes", "shape"))
    attributes = node.get("attributes")
    attributes = attributes if isinstance(attributes, dict) else {}
    same += sum(attributes.get(name) == value for name, value in fresh.get("attributes", {}).items())
    lengths = zip(node.get("shape", ()), fresh.get("shape", ()), strict=False)
    return same + sum(length in (there, 0) for there, length in lengths)

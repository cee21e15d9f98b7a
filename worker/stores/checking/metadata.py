"""Which metadata are right: an array's own, or those that the root says once more."""

import json
from collections.abc import Iterator, Mapping
from tempfile import TemporaryDirectory
from typing import Any

from worker.errors import as_store_failure
from worker.jobs.basin_job import BasinJob
from worker.jobs.job import Job
from worker.stores.analysis_store import PARTS
from worker.stores.files.checked_chunks import METADATA
from worker.stores.new_store import create_store
from worker.stores.storage import place_at, whole

MISSING = "they are missing"
OTHERS = "they are not those that the root has"
COPY_IS_WRONG = "those that the root has are others, and not of such a store"


def nodes_of(location: str) -> dict[str, Any]:
    """Metadata of every array and group by its path, as the root says them once more; without parts, which pass.

    Parameters
    ----------
    location : str

    Returns
    -------
    dict of str to dict
    """
    with as_store_failure(location):
        file = place_at(location).read(METADATA, whole)
    nodes = json.loads(file.content)["consolidated_metadata"]["metadata"] if file else {}
    return {path: _own(node) for path, node in nodes.items() if path.split("/")[0] != PARTS}


def damaged_metadata(
    location: str, job: Job, nodes: Mapping[str, Any], complete: bool
) -> Iterator[tuple[str, str]]:  # fmt: skip
    """Paths of arrays and groups whose own metadata are not those that the root says once more, and what is wrong.

    Those of an unfinished store may differ: a driver may have been stopped between the two. Where both can be read, a
    new store of the same job decides.

    Parameters
    ----------
    location : str
    job : Job
    nodes : dict
        What `nodes_of` has found.
    complete : bool
    """
    differing = {}
    for path, node in nodes.items():
        with as_store_failure(location):
            file = place_at(location).read(f"{path}/{METADATA}", whole)
        own = _read(file.content) if file else None
        if own is None:
            yield path, MISSING if file is None else OTHERS
        elif complete and own != node:
            differing[path] = own, node
    fresh = _fresh_nodes(job) if differing else {}
    for path, (own, node) in differing.items():
        yield path, COPY_IS_WRONG if _fits(own, fresh.get(path)) > _fits(node, fresh.get(path)) else OTHERS


def _own(node: Mapping[str, Any]) -> dict[str, Any]:
    return {name: node[name] for name in node if name != "consolidated_metadata"}


def _read(content: bytes) -> dict[str, Any] | None:
    try:
        node = json.loads(content)
    except ValueError:
        return None
    return _own(node) if isinstance(node, dict) else None


def _fresh_nodes(job: Job) -> dict[str, Any]:
    """Metadata of a new store. Tables of an analysis are made when it ends, and made anew when one is damaged."""
    if not isinstance(job, BasinJob):
        return {}
    with TemporaryDirectory() as folder:
        create_store(f"{folder}/store", job)
        return nodes_of(f"{folder}/store")


def _fits(node: Mapping[str, Any], fresh: Mapping[str, Any] | None) -> int:
    """How much of metadata is as in a new store. Lengths of solutions, and attributes, are found while computing."""
    if fresh is None:
        return 0
    same = sum(node.get(name) == fresh[name] for name in fresh if name not in ("attributes", "shape"))
    same += sum(node.get("attributes", {}).get(name) == value for name, value in fresh.get("attributes", {}).items())
    lengths = zip(node.get("shape", ()), fresh.get("shape", ()), strict=False)
    return same + sum(length in (there, 0) for there, length in lengths)

"""A result of a service as a folder here: the files of its store, byte by byte."""

import itertools
import json
import math
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import httpx2 as httpx
from rich.console import Console
from rich.progress import track

from rattle.remote.failure import ServiceFailed, detail_of
from worker.errors import StoreConflict

_METADATA = "zarr.json"
_ANSWER_SECONDS = 60.0


def fetch_store(address: str, headers: dict[str, str], folder: Path, console: Console) -> None:
    """Copy a store into a folder, which is there once all files are.

    Parameters
    ----------
    address : str
        Of a store that no job writes to any more.
    headers : dict
        Of each request.
    folder : Path
        Where nothing is yet.
    console : Console
        Shows a progress bar.

    Raises
    ------
    StoreConflict
        If something is there.
    ServiceFailed
        If the service does not answer, or refuses.
    OSError
        If the folder cannot be written.
    """
    if folder.exists():
        raise StoreConflict(f"{folder} is there already: choose another name, or delete it")
    part = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    try:
        with httpx.Client(headers=headers, timeout=_ANSWER_SECONDS) as client:
            _copy(client, address, part, console)
        part.chmod(0o755)
        part.rename(folder)
    finally:
        shutil.rmtree(part, ignore_errors=True)


def _copy(client: httpx.Client, address: str, folder: Path, console: Console) -> None:
    root = _content(client, f"{address}/{_METADATA}")
    if root is None:
        raise ServiceFailed(f"there is no store at {address}", 404)
    nodes: dict[str, Any] = json.loads(root)["consolidated_metadata"]["metadata"]
    (folder / _METADATA).write_bytes(root)
    paths = [file for path, node in nodes.items() for file in _files_of(path, node)]
    for path in track(paths, "fetching", console=console, transient=True):
        content = _content(client, f"{address}/{path}")
        if content is None and path.endswith(_METADATA):
            raise ServiceFailed(f"{address}/{path} is not there, though the root lists it: check the store there", 404)
        if content is not None:  # chunks that hold fill values alone have no file
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_bytes(content)
    # Of a result that is gone every file is missing, and each missing chunk looked like one of fill values.
    if _content(client, f"{address}/{_METADATA}") != root:
        raise ServiceFailed(f"the result at {address} was deleted or changed while it was fetched", 404)


def _content(client: httpx.Client, address: str) -> bytes | None:
    """A file's content; None if the service says that there is no such file. Every other failure is an error."""
    try:
        answer = client.get(address)
    except httpx.HTTPError as error:
        raise ServiceFailed(f"{address} does not answer ({error}); try again") from error
    if answer.status_code == httpx.codes.NOT_FOUND:
        return None
    if answer.is_error:
        raise ServiceFailed(detail_of(answer), answer.status_code)
    return answer.content


def _files_of(path: str, node: dict[str, Any]) -> Iterator[str]:
    """Files that a group or an array may have: its metadata, and the chunks of a regular grid."""
    yield f"{path}/{_METADATA}"
    if node["node_type"] == "array":
        chunk: Sequence[int] = node["chunk_grid"]["configuration"]["chunk_shape"]
        chunks = [range(math.ceil(size / of)) for size, of in zip(node["shape"], chunk, strict=True)]
        for place in itertools.product(*chunks):
            yield "/".join([path, "c", *map(str, place)])

"""A finished store: its tree, its metadata without what varies, and a hash of what each array holds."""

import hashlib
import json

import numpy as np
import zarr

VARIES = {"started", "finished", "seconds", "versions", "git_revision", "fused_multiply_add", "history", "source"}
"""Attributes that depend on the run: times, versions, the revision, the processor."""
METADATA = "zarr.json"
ENCODING = ("zarr_format", "node_type", "chunk_key_encoding", "codecs", "storage_transformers")
"""Metadata that most arrays have in common."""


def chunks(folder):
    """Path of every file but metadata."""
    return [path for path in _files(folder) if not path.endswith(METADATA)]


def _files(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def metadata(folder):
    """Every ``zarr.json`` by its path, without what varies; what many have in common stands once, as encodings."""
    encodings, found = [], {}
    for path in _files(folder):
        if path.endswith(METADATA):
            found[path] = _metadata(json.loads((folder / path).read_text()), encodings)
    return {"encodings": encodings, "files": found}


def _metadata(node, encodings):
    told = {name: value for name, value in node.items() if name not in ENCODING}
    told["attributes"] = {name: value for name, value in node["attributes"].items() if name not in VARIES}
    if node.get("consolidated_metadata"):
        # These say all the others once more: how many there are is enough.
        told["consolidated_metadata"] = len(node["consolidated_metadata"]["metadata"])
    encoding = {name: node[name] for name in ENCODING if name in node}
    if encoding not in encodings:
        encodings.append(encoding)
    return told | {"encoding": encodings.index(encoding)}


def arrays(folder):
    """What every array holds, by its path."""
    return {path: _content(folder / path) for path in _array_paths(folder)}


def _array_paths(folder):
    nodes = {path.parent: json.loads(path.read_text()) for path in sorted(folder.rglob(METADATA))}
    return [path.relative_to(folder).as_posix() for path, node in nodes.items() if node["node_type"] == "array"]


def _content(folder):
    values = np.asarray(zarr.open_array(str(folder), mode="r")[...])
    content = {"sha256": hashlib.sha256(_bytes(values)).hexdigest()}
    return content | _numbers(values.ravel()) if values.dtype.kind == "f" else content


def _numbers(values):
    """How many are finite, and a weighted mean of these: it differs where bytes do, and says by how much."""
    finite = values[np.isfinite(values)]
    weights = np.linspace(1.0, 2.0, finite.size)
    return {"finite": int(finite.size), "mean": float((finite * weights).sum() / max(1, finite.size))}


def _bytes(values):
    """Numbers as they are, little endian; texts as JSON."""
    if values.dtype.kind in "biuf":
        return np.ascontiguousarray(values.astype(values.dtype.newbyteorder("<"))).tobytes()
    return json.dumps(values.tolist()).encode()

"""A finished store: its tree, its metadata without what varies, and a hash of what each array holds."""

import hashlib
import json

import numpy as np
import zarr

VARIES = {"started", "finished", "seconds", "versions", "git_revision"}
"""Attributes that tell of times, versions and revisions."""


def tree(folder):
    """Path of every file."""
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def metadata(folder):
    """Every ``zarr.json`` by its path; of the consolidated ones the paths alone, as they say the same again."""
    return {path: _metadata(folder / path) for path in tree(folder) if path.endswith("zarr.json")}


def _metadata(file):
    found = json.loads(file.read_text())
    found["attributes"] = {name: value for name, value in found["attributes"].items() if name not in VARIES}
    if found.get("consolidated_metadata"):
        found["consolidated_metadata"] = sorted(found["consolidated_metadata"]["metadata"])
    return found


def arrays(folder):
    """What every array holds, by its path."""
    return {path: _content(folder / path) for path in _array_paths(folder)}


def _array_paths(folder):
    files = [path for path in tree(folder) if path.endswith("/zarr.json")]
    nodes = {path: json.loads((folder / path).read_text()) for path in files}
    return [path.removesuffix("/zarr.json") for path, node in nodes.items() if node["node_type"] == "array"]


def _content(folder):
    values = np.asarray(zarr.open_array(str(folder), mode="r")[...])
    content = {"shape": list(values.shape), "sha256": hashlib.sha256(_bytes(values)).hexdigest()}
    if values.dtype.kind == "f" and np.isfinite(values).any():
        finite = values[np.isfinite(values)]
        content |= {"least": float(finite.min()), "greatest": float(finite.max()), "finite": int(finite.size)}
    return content


def _bytes(values):
    """Numbers as they are, little endian; texts as JSON."""
    if values.dtype.kind in "biuf":
        return np.ascontiguousarray(values.astype(values.dtype.newbyteorder("<"))).tobytes()
    return json.dumps(values.tolist()).encode()

"""A finished result as one file to hand on: an RO-Crate 1.1 with its request, versions, tables and pictures."""

import io
import json
import re
import uuid
import zipfile
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import xarray as xr

from rattle.results.opening import open
from worker.additions import additions
from worker.errors import InvalidJob
from worker.kinds import KINDS
from worker.pictures.figure_file import PictureFormat, save_figure
from worker.results.figure import figure_of_store
from worker.results.opening import is_address
from worker.results.shares import shares_figure
from worker.results.tables import TableFormat, table_of, tables_in, write_table
from worker.stores.provenance import LICENSE, REFERENCES

_MOST_ROWS = 100_000
# What has a value for each cell, point or tile is in the store, not in tables.
_OF_CELLS = {"velocity", "time", "sample", "tile", "tile_velocity", "tile_time"}
_SPDX_NAME = re.compile(r"[A-Za-z0-9.+-]+")
# A zip's times begin here. The same store gives the same bytes.
_NO_TIME = (1980, 1, 1, 0, 0, 0)
# Name of the file that makes a folder an RO-Crate.
_METADATA = "ro-crate-metadata.json"
_SPECIFICATION = "https://w3id.org/ro/crate/1.1"
_SPDX = "https://spdx.org/licenses/"
_PROGRAM = "#gear-rattle"


class CrateFile(NamedTuple):
    """A file of a crate: its bytes, its media type, and what it is."""

    content: bytes
    media_type: str
    name: str


def write_crate(location: str, target: Path, creator: str | None, license_name: str | None) -> Path:
    """Write a store as a crate; see `rattle.export`."""
    if target.suffix != ".zip":
        raise InvalidJob(f"the name of an export ends in .zip, not as {str(target)!r} does")
    if license_name is not None and not _SPDX_NAME.fullmatch(license_name):
        raise InvalidJob(f"the licence {license_name!r} is no SPDX name, such as CC-BY-4.0")
    if is_address(location):
        raise InvalidJob(f"{location} is an address: copy the result into a folder first, with `rattle fetch`")
    with open(location) as dataset:
        if not dataset.attrs["complete"]:
            raise InvalidJob(f"{location} is not finished: the call that began it goes on from what is there")
        files = dict(_files(location, dataset))
        metadata = _metadata_of(dataset.attrs, files, creator, license_name or dataset.attrs.get("license", LICENSE))
    _write_whole(target, _zipped({_METADATA: metadata} | {name: file.content for name, file in files.items()}))
    return target


def _write_whole(target: Path, content: bytes) -> None:
    """Write a file, or leave the one that is there: a full disk leaves no half of it."""
    partial = target.with_name(f"{target.name}.{uuid.uuid4().hex}.partial")
    try:
        partial.write_bytes(content)
        partial.replace(target)
    finally:
        partial.unlink(missing_ok=True)


def _files(location: str, dataset: xr.Dataset) -> Iterator[tuple[str, CrateFile]]:
    request = json.dumps(json.loads(dataset.attrs["request"]), indent=1)
    yield "request.json", CrateFile(request.encode(), "application/json", "The request, as a service takes it")
    names = ("versions", "git_revision", "fused_multiply_add", "layout_version")
    versions = {name: _unpacked(dataset.attrs.get(name)) for name in names}
    yield "versions.json", CrateFile(json.dumps(versions, indent=1).encode(), "application/json", "What computed it")
    for addition in additions():
        for path, content, media_type, name in addition.crate_files(dataset):
            yield path, CrateFile(content, media_type, name)
    for name in _small_tables(dataset):
        if len(table := table_of(dataset, name)):  # few basins have a transient, whose ends are a table
            text = write_table(table, TableFormat.CSV)
            yield f"tables/{name}.csv", CrateFile(text.encode(), "text/csv", f"Table of {name}")
    figures = {"picture": figure_of_store} | (
        {"shares": shares_figure} if dataset.rattle.kind in KINDS.offering("shares") else {}
    )
    for name, draw in figures.items():
        for picture_format in (PictureFormat.PNG, PictureFormat.SVG):
            drawn = io.BytesIO()
            save_figure(draw(location), drawn, picture_format)
            path = f"pictures/{name}.{picture_format.value}"
            yield path, CrateFile(drawn.getvalue(), picture_format.media_type, f"{name.capitalize()} of the result")


def _unpacked(value: object) -> object:
    """An attribute that the dataset holds as JSON."""
    return json.loads(value) if isinstance(value, str) and value.startswith("{") else value


def _small_tables(dataset: xr.Dataset) -> list[str]:
    """Names of the tables that list what was found. Arrays of the same dimensions are columns of one table."""
    names: dict[tuple[str, ...], str] = {}
    for name in sorted(tables_in(dataset), key=lambda name: name != "share"):
        dimensions = (name,) if name in dataset.dims else tuple(map(str, dataset[name].dims))
        rows = dataset.sizes[name] if name in dataset.dims else dataset[name].size
        if not _OF_CELLS.intersection(dimensions) and rows <= _MOST_ROWS:
            names.setdefault(dimensions, name)
    return sorted(names.values())


def _zipped(files: dict[str, bytes]) -> bytes:
    zipped = io.BytesIO()
    with zipfile.ZipFile(zipped, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, _NO_TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)
    return zipped.getvalue()


def _metadata_of(
    attributes: Mapping[str, Any], files: Mapping[str, CrateFile], creator: str | None, license_name: str
) -> bytes:
    """The crate's own file: JSON-LD that describes all others. Dates are those of the store."""
    license_id = _SPDX + license_name
    parts = [{"@id": path} for path in files]
    graph: list[dict[str, Any]] = [
        {
            "@id": _METADATA, "@type": "CreativeWork", "about": {"@id": "./"},
            "conformsTo": {"@id": _SPECIFICATION},
        },
        {
            "@id": "./", "@type": "Dataset", "name": attributes["title"],
            "description": f"{attributes['title']}: request {attributes['request_sha256']}",
            "identifier": attributes["request_sha256"], "datePublished": attributes["finished"],
            "license": {"@id": license_id}, "hasPart": parts, "mentions": {"@id": "#run"},
            "citation": {"@id": _doi()},
        },
        {"@id": license_id, "@type": "CreativeWork", "name": license_name, "description": f"Licence {license_name}"},
        {"@id": _doi(), "@type": "ScholarlyArticle", "name": REFERENCES},
        {
            "@id": _PROGRAM, "@type": "SoftwareApplication", "name": "gear-rattle",
            "softwareVersion": _version_of(attributes), "description": "Basins of attraction of a rattling gear pair",
        },
        {
            "@id": "#run", "@type": "CreateAction", "name": attributes.get("history", "computation"),
            "instrument": {"@id": _PROGRAM}, "object": {"@id": "request.json"},
            "result": [part for part in parts if part["@id"] not in ("request.json", "versions.json")],
            "startTime": attributes["started"], "endTime": attributes["finished"],
        },
    ]  # fmt: skip
    graph += [
        {
            "@id": path, "@type": "File", "name": file.name, "encodingFormat": file.media_type,
            "contentSize": str(len(file.content)),
        }
        for path, file in files.items()
    ]  # fmt: skip
    if creator is not None:
        graph[1]["author"] = {"@id": "#creator"}
        graph.append({"@id": "#creator", "@type": "Person", "name": creator})
    document = {"@context": f"{_SPECIFICATION}/context", "@graph": graph}
    return json.dumps(document, indent=1, ensure_ascii=False).encode()


def _doi() -> str:
    return "https://doi.org/" + REFERENCES.rpartition("doi:")[2]


def _version_of(attributes: Mapping[str, Any]) -> str:
    """Version that computed the result; older stores say it only among all versions."""
    versions = attributes.get("versions", {})
    versions = json.loads(versions) if isinstance(versions, str) else versions
    return str(versions.get("gear-rattle", version("gear-rattle")))

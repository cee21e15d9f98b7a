"""A finished result as one file to hand on: an RO-Crate with its request, versions, tables and pictures."""

import io
import json
import re
import uuid
import zipfile
from collections.abc import Iterator
from pathlib import Path

import xarray as xr

from rattle.results.opening import open
from rattle.stores.crate import METADATA, CrateFile, crate_metadata
from worker.errors import InvalidJob
from worker.pictures.figure_file import PictureFormat, save_figure
from worker.pictures.picture import figure_of_store
from worker.pictures.share_chart import shares_figure
from worker.stores.provenance import LICENSE
from worker.views.reading import is_address
from worker.views.tables import TableFormat, table_of, tables_in, write_table

_MOST_ROWS = 100_000
# What has a value for each cell, point or tile is in the store, not in tables.
_OF_CELLS = {"velocity", "time", "sample", "tile", "tile_velocity", "tile_time"}
_SPDX_NAME = re.compile(r"[A-Za-z0-9.+-]+")
# A zip's times begin here. The same store gives the same bytes.
_NO_TIME = (1980, 1, 1, 0, 0, 0)


def export(
    store: str | Path, path: str | Path, *, creator: str | None = None, license: str | None = None  # noqa: A002
) -> Path:  # fmt: skip
    """Write a finished result as a zipped RO-Crate 1.1: its request, versions, tables and pictures.

    The certificate of a proof is part of it.

    Parameters
    ----------
    store : str or path
        A folder, or ``s3://bucket/prefix``.
    path : str or path
        File to write; its name ends in .zip.
    creator : str, optional
        Who made the result. A store says nobody's name.
    license : str, optional
        SPDX name of the result's licence, by default CC0-1.0.

    Returns
    -------
    Path
        The file, in place of one that was there. The same store gives the same bytes.

    Raises
    ------
    InvalidJob
        If the file's name or the licence cannot be one, or the result is not finished.
    StoreConflict, StoreFailed
        If there is no store, or it cannot be read.
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> import rattle
    >>> basin = rattle.basin(cells=20, store="exported.zarr", progress=False)
    >>> rattle.export("exported.zarr", "basin.zip", creator="A. Author").name
    'basin.zip'
    """
    location, target = str(store), Path(path)
    if target.suffix != ".zip":
        raise InvalidJob(f"the name of an export ends in .zip, not as {str(path)!r} does")
    if license is not None and not _SPDX_NAME.fullmatch(license):
        raise InvalidJob(f"the licence {license!r} is no SPDX name, such as CC-BY-4.0")
    if is_address(location):
        raise InvalidJob(f"{location} is an address: copy the result into a folder first, with `rattle fetch`")
    with open(location) as dataset:
        if not dataset.attrs["complete"]:
            raise InvalidJob(f"{location} is not finished: the call that began it goes on from what is there")
        files = dict(_files(location, dataset))
        metadata = crate_metadata(dataset.attrs, files, creator, license or dataset.attrs.get("license", LICENSE))
    _write_whole(target, _zipped({METADATA: metadata} | {name: file.content for name, file in files.items()}))
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
    if certificate := dataset.attrs.get("certificate"):
        text = json.dumps(json.loads(certificate), indent=1)
        yield "certificate.json", CrateFile(text.encode(), "application/json", "Certificate of the proof")
    for name in _small_tables(dataset):
        if len(table := table_of(dataset, name)):  # few basins have a transient, whose ends are a table
            text = write_table(table, TableFormat.CSV)
            yield f"tables/{name}.csv", CrateFile(text.encode(), "text/csv", f"Table of {name}")
    figures = {"picture": figure_of_store} | ({"shares": shares_figure} if _is_sweep(dataset) else {})
    for name, draw in figures.items():
        for picture_format in (PictureFormat.PNG, PictureFormat.SVG):
            drawn = io.BytesIO()
            save_figure(draw(location), drawn, picture_format)
            path = f"pictures/{name}.{picture_format.value}"
            yield path, CrateFile(drawn.getvalue(), picture_format.media_type, f"{name.capitalize()} of the result")


def _unpacked(value: object) -> object:
    """An attribute that the dataset holds as JSON."""
    return json.loads(value) if isinstance(value, str) and value.startswith("{") else value


def _is_sweep(dataset: xr.Dataset) -> bool:
    return "share" in dataset and dataset.share.ndim == 2


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

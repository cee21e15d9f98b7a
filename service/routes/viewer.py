"""Data from which a viewer draws a basin: its outline, its overlays, and its labels tile by tile."""

import gzip
from typing import Annotated

from fastapi import APIRouter, Header, Path, Query, Response

from service.answers.conditional import (
    NOT_MODIFIED,
    IfNoneMatch,
    etag_of,
    json_answer,
    json_or_not_modified,
    not_modified,
)
from service.errors import NotReady
from service.models.results import OutlineView, OverlaysView, OverlayView, UncertaintyView
from service.routes.dependencies import LARGE, JobId, JobsHere, SettingsHere, problems, require_kind
from service.routes.results import COMPUTING, location_of
from worker.additions import additions
from worker.kinds import KINDS
from worker.pictures.overlay_kind import OverlayKind
from worker.results.summary import fingerprint
from worker.results.viewer import outline_basin, overlay_basin, read_tile_labels, uncertainty_of_basin

router = APIRouter(prefix="/v1/jobs/{job_id}", tags=["viewer"])

_NOTHING_YET = problems(
    s404="there is no such job, or what was asked for is not there yet", s409="the job is no basin and no sweep"
)
Panel = Annotated[int, Query(ge=0, description="Which basin of a sweep, the last swept parameter fastest")]
_OF_TILES = (
    "Step, group and period as int32, then solution as int16: little endian, each row by row from the lowest speed."
)
_OF_SHAPES = "The header `rattle-shape` holds the numbers of rows and columns."
_IMMUTABLE, _REVALIDATE = "private, max-age=604800, immutable", "private, no-cache"


def _location_of_basins(job_id: str, jobs: JobsHere, settings: SettingsHere, what: str) -> str:
    """Location of the store of a basin or a sweep.

    Raises
    ------
    JobNotFound, WrongKind, NotReady
    """
    require_kind(jobs.get(job_id), what, *KINDS.offering("has_tiles"))
    return location_of(job_id, jobs, settings)


@router.get(
    "/outline",
    response_model=OutlineView,
    summary="All of a basin but its cells",
    dependencies=[LARGE],
    responses=_NOTHING_YET | NOT_MODIFIED,
)
def get_outline(
    job_id: JobId,
    jobs: JobsHere,
    settings: SettingsHere,
    panel: Panel = 0,
    if_none_match: IfNoneMatch = None,
) -> Response:
    """Window, tiles and their states, solutions with their colours and points, the grazing curve."""
    view = OutlineView.from_outline(outline_basin(_location_of_basins(job_id, jobs, settings, "an outline"), panel))
    return json_or_not_modified(json_answer(view.model_dump_json()), if_none_match)


@router.get(
    "/overlays/{kind}",
    response_model=OverlaysView,
    summary="What can be laid over a basin",
    dependencies=[LARGE],
    responses=_NOTHING_YET | NOT_MODIFIED,
)
def get_overlays(
    job_id: JobId,
    kind: OverlayKind,
    jobs: JobsHere,
    settings: SettingsHere,
    panel: Panel = 0,
    if_none_match: IfNoneMatch = None,
) -> Response:
    """Curves and marks of one kind, computed on request: saddles and manifolds take seconds.

    Saddles and manifolds need the catalogue of motions. Until it exists, the list is empty.
    """
    location = _location_of_basins(job_id, jobs, settings, "overlays")
    etag = etag_of(fingerprint(location), kind, str(panel))
    if (known := not_modified(etag, if_none_match)) is not None:
        return known
    with COMPUTING:
        overlays = [OverlayView.from_overlay(each) for each in overlay_basin(location, panel, kind)]
    body = OverlaysView(overlays=overlays).model_dump_json()
    return Response(body, media_type="application/json", headers={"etag": etag})


@router.get(
    "/uncertainty",
    response_model=UncertaintyView,
    summary="Uncertainty exponent of a basin",
    dependencies=[LARGE],
    responses=_NOTHING_YET | NOT_MODIFIED,
)
def get_uncertainty(
    job_id: JobId,
    jobs: JobsHere,
    settings: SettingsHere,
    panel: Panel = 0,
    if_none_match: IfNoneMatch = None,
) -> Response:
    """Final-state uncertainty exponent of the window, with its error, from the labels of all cells."""
    location = _location_of_basins(job_id, jobs, settings, "an uncertainty exponent")
    etag = etag_of(fingerprint(location), "uncertainty", str(panel))
    if (known := not_modified(etag, if_none_match)) is not None:
        return known
    with COMPUTING:
        fit = uncertainty_of_basin(location, panel)
    if fit is None:
        raise NotReady(f"basin {panel} of job {job_id} is not complete yet")
    body = UncertaintyView(exponent=fit.exponent, error=fit.error).model_dump_json()
    return Response(body, media_type="application/json", headers={"etag": etag})


@router.get(
    "/tiles/{number}",
    summary="Labels of one tile",
    description=f"{_OF_TILES}\n\n" + " ".join((*(each.of_tiles for each in additions()), _OF_SHAPES)),
    dependencies=[LARGE],
    response_class=Response,
    responses={
        200: {"content": {"application/octet-stream": {}}},
        **_NOTHING_YET,
        **NOT_MODIFIED,
    },
)
def get_tile(
    job_id: JobId,
    number: Annotated[int, Path(ge=0, description="Of the tile, counted through all basins of the job")],
    jobs: JobsHere,
    settings: SettingsHere,
    every: Annotated[int, Query(ge=1, le=4096, description="Only every n-th cell each way, of the whole grid")] = 1,
    level: Annotated[int, Query(ge=0, description="Of the outline's levels; 0 is the basin itself")] = 0,
    accept_encoding: Annotated[str, Header(include_in_schema=False)] = "",
    if_none_match: IfNoneMatch = None,
) -> Response:
    """Send what a tile holds."""
    labels = read_tile_labels(_location_of_basins(job_id, jobs, settings, "tiles"), number, every, level)
    if labels is None:
        raise NotReady(f"tile {number} of job {job_id} is not labelled yet, or there is none of this number")
    etag = etag_of(labels.content)
    if (known := not_modified(etag, if_none_match)) is not None:
        return known
    headers = {
        "etag": etag, "cache-control": _IMMUTABLE if labels.final else _REVALIDATE, "vary": "accept-encoding",
        "rattle-shape": f"{labels.rows} {labels.columns}",
    }  # fmt: skip
    content = labels.content
    if "gzip" in accept_encoding:
        content, headers["content-encoding"] = gzip.compress(content, compresslevel=1, mtime=0), "gzip"
    return Response(content, headers=headers, media_type="application/octet-stream")

"""What a viewer draws a basin from: its outline, and its labels tile by tile."""

import gzip
import hashlib
from typing import Annotated

from fastapi import APIRouter, Header, Path, Query, Response

from service.dependencies import JobsHere, SettingsHere, problems
from service.errors import NotReady
from service.routes.results import location_of
from service.viewer_models import OutlineView
from worker.panel_outline import outline_panel
from worker.tile_labels import read_tile_labels

router = APIRouter(prefix="/v1/jobs/{job_id}", tags=["viewer"])

_NOTHING_YET = problems(s404="there is no such job, or what was asked for is not there yet")
_FOR_GOOD, _ASK_AGAIN = "private, max-age=604800, immutable", "private, no-cache"


@router.get("/outline", summary="All of a basin but its cells", responses=_NOTHING_YET)
def get_outline(
    job_id: str,
    jobs: JobsHere,
    settings: SettingsHere,
    panel: Annotated[int, Query(ge=0, description="Which basin of a sweep, the last swept parameter fastest")] = 0,
) -> OutlineView:
    """Window, tiles and what is in them, solutions with their colours and points, the grazing curve."""
    return OutlineView.from_outline(outline_panel(location_of(job_id, jobs, settings), panel))


@router.get(
    "/tiles/{number}",
    summary="Labels of one tile",
    response_class=Response,
    responses={
        200: {"content": {"application/octet-stream": {}}},
        304: {"description": "the tile is as it was (If-None-Match)"},
        **_NOTHING_YET,
    },
)
def get_tile(
    job_id: str,
    number: Annotated[int, Path(ge=0, description="Of the tile, counted through all basins of the job")],
    jobs: JobsHere,
    settings: SettingsHere,
    every: Annotated[int, Query(ge=1, le=4096, description="Only every n-th cell each way, of the whole grid")] = 1,
    accept_encoding: Annotated[str, Header(include_in_schema=False)] = "",
    if_none_match: Annotated[str, Header(include_in_schema=False)] = "",
) -> Response:
    """Step, group and period as int32, then solution as int16: little endian, each row by row from the lowest speed.

    The header `rattle-shape` has the rows and columns.
    """
    labels = read_tile_labels(location_of(job_id, jobs, settings), number, every)
    if labels is None:
        raise NotReady(f"tile {number} of job {job_id} is not labelled yet, or there is none of this number")
    tag = f'"{hashlib.blake2b(labels.content, digest_size=12).hexdigest()}"'
    headers = {
        "etag": tag, "cache-control": _FOR_GOOD if labels.final else _ASK_AGAIN, "vary": "accept-encoding",
        "rattle-shape": f"{labels.rows} {labels.columns}",
    }  # fmt: skip
    if tag in if_none_match:
        return Response(status_code=304, headers=headers)
    content = labels.content
    if "gzip" in accept_encoding:
        content, headers["content-encoding"] = gzip.compress(content, compresslevel=1, mtime=0), "gzip"
    return Response(content, headers=headers, media_type="application/octet-stream")

"""Results: summary, picture, and the Zarr store itself over HTTP."""

import contextlib
import io
import re
import threading
from collections.abc import Callable, Sequence
from functools import partial
from importlib.metadata import version
from typing import Annotated, Any, TypeVar

from fastapi import APIRouter, Depends, Query, Request, Response
from matplotlib.figure import Figure
from pydantic import AfterValidator

from service.answers.byte_range import range_of_file
from service.answers.conditional import NOT_MODIFIED, IfNoneMatch, etag_of, json_or_not_modified, not_modified
from service.answers.result_view import location_of_result, summary_of_result
from service.errors import JobNotFound, NotReady
from service.models.results import AnyResult
from service.routes.dependencies import LARGE, JobId, JobsHere, SettingsHere, problems, require_kind
from worker.errors import InvalidJob
from worker.kinds import KINDS
from worker.pictures.annotations import parse_annotations
from worker.pictures.colours import USUAL, Palette, parse_paints
from worker.pictures.figure_file import PictureFormat, save_figure
from worker.pictures.overlay_kind import USUAL_OVERLAYS, OverlayKind, parse_overlays
from worker.pictures.printing import AS_DRAWN, DPI, FONT_POINTS, SIDE_MM, Printing
from worker.pictures.window import parse_window
from worker.results.caption import caption_of
from worker.results.netcdf import NETCDF, netcdf_of
from worker.results.opening import open_store
from worker.results.panel import Layer, Look
from worker.results.shares import shares_figure
from worker.results.summary import fingerprint
from worker.results.tables import TableFormat, Units, demand_small_table, table_of, write_table

router = APIRouter(prefix="/v1/jobs/{job_id}", tags=["results"])

Responses = dict[int | str, dict[str, Any]]
AnyRoute = TypeVar("AnyRoute", bound=Callable[..., Response])

_VERSION = version("gear-rattle")
_NOTHING_YET = problems(s404="there is no such job, or it has not begun")
# Overlays are computed in this process, which also handles all other requests: one at a time.
COMPUTING = threading.Lock()


def location_of(job_id: str, jobs: JobsHere, settings: SettingsHere) -> str:
    """Location of a job's store.

    Raises
    ------
    JobNotFound, NotReady
    """
    location = location_of_result(jobs.get(job_id), settings.results)
    if settings.deletes_results:
        jobs.reads.note(job_id)
    return location


def _store_path(path: str) -> str:
    # Anything that is not a path within a store is refused here, before it reaches the file system.
    if not re.fullmatch(r"[A-Za-z0-9._/-]{1,512}", path) or {"", ".", ".."} & set(path.split("/")):
        raise JobNotFound(f"a store holds no {path!r}")
    return path


@router.get(
    "/result",
    response_model=AnyResult,
    dependencies=[LARGE],
    summary="Summary of a result",
    responses=_NOTHING_YET | NOT_MODIFIED,
)
def get_result(job_id: JobId, jobs: JobsHere, settings: SettingsHere, if_none_match: IfNoneMatch = None) -> Response:
    """Solutions, shares and attractors, or what an analysis has found.

    Also while the job runs; `complete` is then false. The same request sent again after a cancellation is a new job
    that goes on in the store of the cancelled one, so that one's result may become complete, too.
    """
    return json_or_not_modified(summary_of_result(jobs.get(job_id), settings.results), if_none_match)


def _get_figure(name: str, summary: str, responses: Responses) -> Callable[[AnyRoute], AnyRoute]:
    """Routes of a figure, one for each format of its file."""

    def decorate(route: AnyRoute) -> AnyRoute:
        for each in PictureFormat:
            answers = {200: {"content": {each.media_type: {}}}, **responses, **NOT_MODIFIED}
            own = route.__name__ if each == PictureFormat.PNG else f"{route.__name__}_{each}"
            add = router.get(
                f"/{name}.{each}", summary=f"{summary} as {each.upper()}", response_class=Response, responses=answers,
                name=own, dependencies=[LARGE],
            )  # fmt: skip
            add(route)
        return route

    return decorate


def _picture_answer(
    draw: Callable[[], Figure], picture_format: PictureFormat, etag: str, printing: Printing = AS_DRAWN,
    caption: str | None = None,
) -> Response:  # fmt: skip
    buffer = io.BytesIO()
    save_figure(draw(), buffer, picture_format, printing, caption)
    return Response(buffer.getvalue(), media_type=picture_format.media_type, headers={"etag": etag})


SideAsked = Annotated[
    float | None,
    Query(ge=SIDE_MM[0], le=SIDE_MM[1], description="In mm. Of width and height alone the other follows"),
]


def _printing(
    width: SideAsked = None,
    height: SideAsked = None,
    dpi: Annotated[
        int | None,
        Query(ge=DPI[0], le=DPI[1], description="Dots per inch: of a PNG, and of the cells in an SVG or a PDF"),
    ] = None,
    font_size: Annotated[
        float | None, Query(ge=FONT_POINTS[0], le=FONT_POINTS[1], description="Of ordinary letters, in points")
    ] = None,
    editable: Annotated[bool, Query(description="Whether text of an SVG or a PDF stays text")] = False,
) -> Printing:
    return Printing(width, height, dpi, font_size, editable)


_USUAL_OVERLAYS = ",".join(USUAL_OVERLAYS)
PanelAsked = Annotated[int | None, Query(ge=0, description="One basin of a sweep; by default all, side by side")]
WindowAsked = Annotated[
    str | None,
    Query(
        description="What is shown of a basin: time from, to, speed from, to, as in `0.2,0.6,3,5`; by default all that "
        "is computed. Phases repeat",
        max_length=200,
    ),
]
PrintingAsked = Annotated[Printing, Depends(_printing)]
ColoursAsked = Annotated[
    str,
    Query(
        description="Colours that some motions have instead, as in `P(2,2,2):bfffbf;P(3,3,0):802a00/1`: a name, a "
        "colour, and perhaps a texture from 0 to 3",
        max_length=4000,
    ),
]
NotesAsked = Annotated[Sequence[str], Query(description="Pinned points with labels, as in `0.3,4.1,here`")]
MeasuresAsked = Annotated[
    Sequence[str],
    Query(
        description="Lines with the distance between two points, as in `0.3,4.1,0.5,4.4`, or with a label after a "
        "further comma, which may be empty"
    ),
]
KeyAsked = Annotated[bool, Query(description="Whether all that lies over basins is named, also marks")]
CaptionAsked = Annotated[bool, Query(description="Whether the file has a caption with parameters and what to cite")]
OverlaysAsked = Annotated[str, Query(description=f"What lies over basins, of {','.join(OverlayKind)}", max_length=100)]


@_get_figure(
    "picture",
    "Picture of a result",
    _NOTHING_YET
    | problems(
        s422="the window is none, or shows nothing of the job, there is no such panel, layer or overlay, or the "
        "picture had too many pixels"
    ),
)
def get_picture(
    job_id: JobId,
    request: Request,
    jobs: JobsHere,
    settings: SettingsHere,
    layer: Layer = Layer.SOLUTION,
    window: WindowAsked = None,
    panel: PanelAsked = None,
    overlays: OverlaysAsked = _USUAL_OVERLAYS,
    palette: Palette = USUAL,
    colours: ColoursAsked = "",
    overlay_key: KeyAsked = False,
    note: NotesAsked = (),
    measure: MeasuresAsked = (),
    caption: CaptionAsked = False,
    printing: PrintingAsked = AS_DRAWN,
    if_none_match: IfNoneMatch = None,
) -> Response:
    """Draw a basin, or what an analysis has found. While a basin is computed, missing tiles are hatched."""
    location, kind = location_of(job_id, jobs, settings), KINDS[jobs.get(job_id).kind]
    picture_format = PictureFormat.of_file(request.url.path)
    shown = parse_window(window) if window is not None else None
    own, written = parse_paints(colours), parse_annotations(note, measure)
    look = Look(
        layer, parse_overlays(overlays), shown, panel, palette, own, overlay_key=overlay_key, annotations=written
    )
    # Computed before drawing: a tile that arrives while drawing is in the picture and changes the next ETag.
    etag = etag_of(kind.fingerprint(location), repr((look, printing, caption)), picture_format, _VERSION)
    known = not_modified(etag, if_none_match)
    if known is not None:
        return known
    told = _caption_of(location, look) if caption else None
    with COMPUTING if set(look.overlays) - set(USUAL_OVERLAYS) else contextlib.nullcontext():
        return _picture_answer(partial(kind.figure, location, look), picture_format, etag, printing, told)


def _caption_of(location: str, look: Look) -> str:
    with open_store(location) as dataset:
        return caption_of(dataset, look)


@_get_figure(
    "shares",
    "Shares over the swept parameters",
    problems(s404="there is no such job, or none of its basins is complete yet", s409="the job sweeps nothing"),
)
def get_shares(
    job_id: JobId, request: Request, jobs: JobsHere, settings: SettingsHere, if_none_match: IfNoneMatch = None
) -> Response:
    """Draw the share of each solution over one swept parameter, or as maps over two, also while the sweep runs."""
    require_kind(jobs.get(job_id), "shares over a parameter", *KINDS.offering("shares"))
    location = location_of(job_id, jobs, settings)
    picture_format = PictureFormat.of_file(request.url.path)
    etag = etag_of(fingerprint(location), "shares", picture_format, _VERSION)
    known = not_modified(etag, if_none_match)
    try:
        return known or _picture_answer(partial(shares_figure, location), picture_format, etag)
    except InvalidJob as error:
        raise NotReady(f"no basin of job {job_id} is complete yet") from error


@router.get(
    "/result.nc",
    summary="The result as netCDF",
    response_class=Response,
    responses={200: {"content": {NETCDF: {}}}, **_NOTHING_YET, **problems(s422="it is too large"), **NOT_MODIFIED},
    dependencies=[LARGE],
)
def get_netcdf(job_id: JobId, jobs: JobsHere, settings: SettingsHere, if_none_match: IfNoneMatch = None) -> Response:
    """All of a result in one file of netCDF 3. Larger ones are read from the Zarr store."""
    location, kind = location_of(job_id, jobs, settings), KINDS[jobs.get(job_id).kind]
    etag = etag_of(kind.fingerprint(location), "netcdf", _VERSION)
    known = not_modified(etag, if_none_match)
    if known is not None:
        return known
    with open_store(location) as dataset:
        content = netcdf_of(dataset, f"/v1/jobs/{job_id}/result.zarr")
    return Response(content, media_type=NETCDF, headers={"etag": etag})


_TABLES = (
    _NOTHING_YET | problems(s422="the result has no such table; the answer names those that it has") | NOT_MODIFIED
)


@router.get(
    "/result.json",
    summary="A table of a result as JSON",
    response_class=Response,
    responses={200: {"content": {TableFormat.JSON.media_type: {}}}, **_TABLES},
    name="get_table_json",
    dependencies=[LARGE],
)
@router.get(
    "/result.csv",
    summary="A table of a result as CSV",
    response_class=Response,
    responses={200: {"content": {TableFormat.CSV.media_type: {}}}, **_TABLES},
    name="get_table_csv",
    dependencies=[LARGE],
)
def get_table(
    job_id: JobId,
    request: Request,
    jobs: JobsHere,
    settings: SettingsHere,
    table: Annotated[str | None, Query(description="A dimension or an array of the store", max_length=100)] = None,
    units: Annotated[
        Units, Query(description="Of a machine: columns in SI units beside those of the model, or in their place")
    ] = Units.BOTH,
    if_none_match: IfNoneMatch = None,
) -> Response:
    """List what a result holds, row by row: by default motions, shares, orbits, orders or departures."""
    location, kind = location_of(job_id, jobs, settings), KINDS[jobs.get(job_id).kind]
    table_format = TableFormat.of_file(request.url.path)
    etag = etag_of(kind.fingerprint(location), "table", table or "", table_format, units, _VERSION)
    known = not_modified(etag, if_none_match)
    if known is not None:
        return known
    with open_store(location) as dataset:
        demand_small_table(dataset, table, settings.max_table_rows, f"/v1/jobs/{job_id}/result.zarr")
        text = write_table(table_of(dataset, table, units), table_format)
    return Response(text, media_type=table_format.media_type, headers={"etag": etag})


@router.get(
    "/result.zarr/{path:path}",
    summary="The Zarr store",
    response_class=Response,
    responses={200: {"content": {"application/octet-stream": {}}}, **_NOTHING_YET},
)
def get_store(
    job_id: JobId,
    path: Annotated[str, AfterValidator(_store_path)],
    request: Request,
    jobs: JobsHere,
    settings: SettingsHere,
) -> Response:
    """One file of the store. `xarray.open_zarr` opens the URL that ends in `result.zarr`, also while the job runs."""
    answer = range_of_file(location_of(job_id, jobs, settings), path, request.headers)
    if answer is None:
        raise JobNotFound(f"the store of job {job_id} holds no {path!r}")
    return answer

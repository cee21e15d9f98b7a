"""Results: summary, picture, and the Zarr store itself over HTTP."""

import io

from fastapi import APIRouter, Response
from fastapi.responses import FileResponse

from service.dependencies import JobsHere, SettingsHere, problems
from service.errors import JobNotFound, NotReady
from service.models import ResultView
from worker.errors import InvalidJob
from worker.panel_picture import Layer
from worker.picture import draw_basin
from worker.result_files import file_of_store, result_location
from worker.results import summarise
from worker.share_chart import draw_shares
from worker.store import holds_basin

router = APIRouter(prefix="/v1/jobs/{job_id}", tags=["results"])

_NOTHING_YET = problems(s404="there is no such job, or it has not begun")


def _location(job_id: str, jobs: JobsHere, settings: SettingsHere) -> str:
    """Place of a job's store, once there is one."""
    record = jobs.get(job_id)
    location = result_location(settings.results, job_id)
    if not holds_basin(location):
        raise NotReady(f"job {job_id} is {record.state} and has no result yet")
    return location


@router.get("/result", summary="Summary of a result", responses=_NOTHING_YET)
def get_result(job_id: str, jobs: JobsHere, settings: SettingsHere) -> ResultView:
    """Solutions, shares and attractors; also while the job runs, and then it says that it is not complete."""
    return ResultView.from_summary(summarise(_location(job_id, jobs, settings)), f"/v1/jobs/{job_id}/result.zarr")


@router.get(
    "/picture.png",
    summary="Picture of a result",
    response_class=Response,
    responses={200: {"content": {"image/png": {}}}, **_NOTHING_YET},
)
def get_picture(job_id: str, jobs: JobsHere, settings: SettingsHere, layer: Layer = Layer.SOLUTION) -> Response:
    """Draw the basin, also while tiles are still coming: what is missing is hatched."""
    buffer = io.BytesIO()
    draw_basin(_location(job_id, jobs, settings), buffer, layer=layer)
    return Response(buffer.getvalue(), media_type="image/png")


@router.get(
    "/shares.png",
    summary="Shares over the swept parameters",
    response_class=Response,
    responses={
        200: {"content": {"image/png": {}}},
        **problems(s404="there is no such job, or none of its basins is complete yet", s422="the job sweeps nothing"),
    },
)
def get_shares(job_id: str, jobs: JobsHere, settings: SettingsHere) -> Response:
    """Draw the share of each solution over the swept parameter, or maps of them over two, also while a sweep runs."""
    location, buffer = _location(job_id, jobs, settings), io.BytesIO()
    if jobs.get(job_id).kind != "sweep":
        raise InvalidJob(f"job {job_id} is a single basin: it sweeps no parameter to draw shares over")
    try:
        draw_shares(location, buffer)
    except InvalidJob as error:
        raise NotReady(f"no basin of job {job_id} is complete yet") from error
    return Response(buffer.getvalue(), media_type="image/png")


@router.head("/result.zarr/{path:path}", include_in_schema=False)
@router.get(
    "/result.zarr/{path:path}",
    summary="The Zarr store",
    response_class=FileResponse,
    responses={200: {"content": {"application/octet-stream": {}}}, **_NOTHING_YET},
)
def get_store(job_id: str, path: str, jobs: JobsHere, settings: SettingsHere) -> Response:
    """One file of the store; `xarray.open_zarr` reads it by the URL that ends in `result.zarr`, also while it grows."""
    file = file_of_store(_location(job_id, jobs, settings), path)
    if file is None:
        raise JobNotFound(f"the store of job {job_id} holds no {path!r}")
    return FileResponse(file, media_type="application/octet-stream")

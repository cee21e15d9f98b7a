"""Results: summary, picture, and the Zarr store itself over HTTP."""

import io

from fastapi import APIRouter, Response
from fastapi.responses import FileResponse

from service.analysis_requests import AnalysisResult
from service.dependencies import JobsHere, SettingsHere, problems
from service.errors import JobNotFound, NotReady
from service.models import ResultView
from service.result_view import draw_result, result_view
from worker.panel_picture import Layer
from worker.result_files import file_of_store, result_location
from worker.store import holds_store

router = APIRouter(prefix="/v1/jobs/{job_id}", tags=["results"])

_NOTHING_YET = problems(s404="there is no such job, or it has not begun")


def _location(job_id: str, jobs: JobsHere, settings: SettingsHere) -> str:
    """Place of a job's store, once there is one."""
    record = jobs.get(job_id)
    location = result_location(settings.results, job_id)
    if not holds_store(location):
        raise NotReady(f"job {job_id} is {record.state} and has no result yet")
    return location


@router.get("/result", summary="Summary of a result", responses=_NOTHING_YET)
def get_result(job_id: str, jobs: JobsHere, settings: SettingsHere) -> ResultView | AnalysisResult:
    """Solutions, shares and attractors, or what an analysis has found.

    Also while the job runs, and then it says that it is not complete.
    """
    location = _location(job_id, jobs, settings)
    return result_view(jobs.get(job_id).kind, location, f"/v1/jobs/{job_id}/result.zarr")


@router.get(
    "/picture.png",
    summary="Picture of a result",
    response_class=Response,
    responses={200: {"content": {"image/png": {}}}, **_NOTHING_YET},
)
def get_picture(job_id: str, jobs: JobsHere, settings: SettingsHere, layer: Layer = Layer.SOLUTION) -> Response:
    """Draw the basin, also while tiles are still coming: what is missing is hatched. Or what an analysis has found."""
    buffer = io.BytesIO()
    draw_result(jobs.get(job_id).kind, _location(job_id, jobs, settings), buffer, layer)
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

"""Submission of basins."""

from fastapi import APIRouter, Response

from service.dependencies import JobsHere, RunnerHere, SettingsHere, problems
from service.errors import LimitExceeded
from service.models import BasinRequest, JobView
from service.settings import Settings

router = APIRouter(prefix="/v1", tags=["submit"])


def _check_size(request: BasinRequest, settings: Settings) -> None:
    """Refuse what is too large, before anything is done that takes time in proportion to it."""
    cells = request.grid.time.cells * request.grid.velocity.cells
    for what, size, most in (
        ("cells", cells, settings.max_cells),
        ("iterations", request.iterations, settings.max_iterations),
        ("cells times iterations", cells * request.iterations, settings.max_applications),
    ):
        if size > most:
            raise LimitExceeded(f"{size} {what} are more than the limit of {most}")


@router.post(
    "/basins",
    status_code=202,
    summary="Submit a basin",
    responses=problems(
        s400="malformed JSON", s413="body too large", s422="what is wrong with the request, field by field"
    ),
)
def submit_basin(
    request: BasinRequest, response: Response, jobs: JobsHere, runner: RunnerHere, settings: SettingsHere
) -> JobView:
    """Record a basin to be computed.

    The same request again answers with the same job; after a failure or a cancellation, with a new one.
    """
    _check_size(request, settings)
    record, new = jobs.submit(request.to_job())
    if new:
        runner.ring()
    response.headers["Location"] = f"/v1/jobs/{record.id}"
    return JobView.from_record(record)

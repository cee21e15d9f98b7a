"""Submission of basins."""

from fastapi import APIRouter, Response

from service.dependencies import JobsHere, RunnerHere, SettingsHere, problems
from service.limits import check_size
from service.models import BasinRequest, JobView

router = APIRouter(prefix="/v1", tags=["submit"])


@router.post(
    "/basins",
    status_code=202,
    response_model_exclude_unset=True,
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
    check_size(request, settings)
    record, new = jobs.submit(request.to_job())
    if new:
        runner.ring()
    response.headers["Location"] = f"/v1/jobs/{record.id}"
    return JobView.from_record(record)

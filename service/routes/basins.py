"""Submission of basins."""

from fastapi import APIRouter, Response

from service.dependencies import JobsHere, RunnerHere, SettingsHere, problems
from service.models import BasinRequest, JobView
from service.submission import accept

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
    return accept(request, response, jobs, runner, settings)

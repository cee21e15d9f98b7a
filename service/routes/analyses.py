"""Submission of analyses: what explains the pictures."""

from fastapi import APIRouter

from service.analysis_requests import BifurcationRequest, OrbitsRequest
from service.dependencies import problems
from service.models import JobView
from service.submission import SubmissionHere

router = APIRouter(prefix="/v1", tags=["submit"])

_REFUSED = problems(
    s400="malformed JSON", s413="body too large", s422="what is wrong with the request, field by field"
)  # fmt: skip


@router.post(
    "/bifurcations",
    status_code=202,
    response_model_exclude_unset=True,
    summary="Submit a bifurcation diagram",
    responses=_REFUSED,
)
def submit_bifurcation(request: BifurcationRequest, submission: SubmissionHere) -> JobView:
    """Record a bifurcation diagram to be computed.

    The same request again answers with the same job; after a failure or a cancellation, with a new one.
    """
    return submission.accept(request)


@router.post(
    "/orbits",
    status_code=202,
    response_model_exclude_unset=True,
    summary="Submit a search for periodic orbits",
    responses=_REFUSED,
)
def submit_orbits(request: OrbitsRequest, submission: SubmissionHere) -> JobView:
    """Record periodic orbits to be found, and on request followed in one parameter or two.

    The same request again answers with the same job; after a failure or a cancellation, with a new one.
    """
    return submission.accept(request)

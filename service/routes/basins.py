"""Submission of basins."""

from fastapi import APIRouter

from service.dependencies import problems
from service.models import BasinRequest, JobView
from service.submission import SubmissionHere

router = APIRouter(prefix="/v1", tags=["submit"])


@router.post(
    "/basins",
    status_code=202,
    response_model_exclude_unset=True,
    summary="Submit a basin",
    responses=problems(
        s400="malformed JSON",
        s413="body too large",
        s422="what is wrong with the request, field by field",
        s429="too much waits or is under way: the header Retry-After says when to ask again",
    ),  # fmt: skip
)
def submit_basin(request: BasinRequest, submission: SubmissionHere) -> JobView:
    """Record a basin to be computed.

    The same request again answers with the same job; after a failure or a cancellation, with a new one that goes on
    from what is there.
    """
    return submission.accept(request)

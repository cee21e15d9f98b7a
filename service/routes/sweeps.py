"""Submission of sweeps."""

from fastapi import APIRouter

from service.dependencies import problems
from service.models import JobView, SweepRequest
from service.submission import SubmissionHere

router = APIRouter(prefix="/v1", tags=["submit"])


@router.post(
    "/sweeps",
    status_code=202,
    response_model_exclude_unset=True,
    summary="Submit a sweep",
    responses=problems(
        s400="malformed JSON",
        s413="body too large",
        s422="what is wrong with the request, field by field",
        s429="too much waits or is under way: the header Retry-After says when to ask again",
    ),  # fmt: skip
)
def submit_sweep(request: SweepRequest, submission: SubmissionHere) -> JobView:
    """Record basins over one or two parameters to be computed, all into one store.

    The same request again answers with the same job; after a failure or a cancellation, with a new one that goes on
    from what is there.
    """
    return submission.accept(request)

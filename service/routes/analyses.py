"""Submission of analyses: what explains the pictures."""

from fastapi import APIRouter

from service.analysis_requests import BifurcationRequest, GrazingCurveRequest, ManifoldRequest, OrbitsRequest
from service.dependencies import problems
from service.models import JobView
from service.submission import SubmissionHere

router = APIRouter(prefix="/v1", tags=["submit"])

_REFUSED = problems(
    s400="malformed JSON",
    s413="body too large",
    s422="what is wrong with the request, field by field",
    s429="too much waits or is under way: the header Retry-After says when to ask again",
)


@router.post(
    "/bifurcations",
    status_code=202,
    response_model_exclude_unset=True,
    summary="Submit a bifurcation diagram",
    responses=_REFUSED,
)
def submit_bifurcation(request: BifurcationRequest, submission: SubmissionHere) -> JobView:
    """Record a bifurcation diagram to be computed.

    The same request again answers with the same job; after a failure or a cancellation, with a new one
    that goes on from what is there.
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

    The same request again answers with the same job; after a failure or a cancellation, with a new one
    that goes on from what is there.
    """
    return submission.accept(request)


@router.post(
    "/manifolds",
    status_code=202,
    response_model_exclude_unset=True,
    summary="Submit manifolds of saddles",
    responses=_REFUSED,
)
def submit_manifold(request: ManifoldRequest, submission: SubmissionHere) -> JobView:
    """Record manifolds to be grown.

    Whether a seed leads to a saddle is known when it is computed: else the job fails and says what is there.
    """
    return submission.accept(request)


@router.post(
    "/grazing-curves",
    status_code=202,
    response_model_exclude_unset=True,
    summary="Submit a grazing curve",
    responses=_REFUSED,
)
def submit_grazing_curve(request: GrazingCurveRequest, submission: SubmissionHere) -> JobView:
    """Record a grazing curve and its pre-images to be computed.

    The same request again answers with the same job; after a failure or a cancellation, with a new one
    that goes on from what is there.
    """
    return submission.accept(request)

"""Submission of jobs: basins, sweeps of them, and the analyses that explain the pictures.

The same request again answers with the same job; after a failure or a cancellation, with a new one that goes on from
what is there.
"""

from typing import Any

from fastapi import APIRouter, Response

from service.models.analysis_requests import (
    BifurcationRequest,
    GrazingCurveRequest,
    ManifoldRequest,
    OrbitsRequest,
)
from service.models.models import BasinRequest, JobView, SweepRequest
from service.routes.dependencies import problems
from service.routes.plain_json import PlainJsonRoute
from service.routes.submission import SubmissionHere

router = APIRouter(prefix="/v1", tags=["submit"], route_class=PlainJsonRoute)

_ACCEPTED: dict[str, Any] = {
    "status_code": 202,
    "response_model": JobView,
    "responses": problems(
        s400="malformed JSON",
        s413="body too large",
        s422="what is wrong with the request, field by field",
        s429="too much waits or is under way: the header Retry-After says when to ask again",
    ),
}


@router.post("/basins", summary="Submit a basin", **_ACCEPTED)
async def submit_basin(request: BasinRequest, submission: SubmissionHere) -> Response:
    """Record a basin to be computed.

    The same request again answers with the same job; after a failure or a cancellation, with a new one that goes on
    from what is there.
    """
    return await submission.accept(request)


@router.post("/sweeps", summary="Submit a sweep", **_ACCEPTED)
async def submit_sweep(request: SweepRequest, submission: SubmissionHere) -> Response:
    """Record basins over one or two parameters to be computed, all into one store.

    The same request again answers with the same job; after a failure or a cancellation, with a new one that goes on
    from what is there.
    """
    return await submission.accept(request)


@router.post("/bifurcations", summary="Submit a bifurcation diagram", **_ACCEPTED)
async def submit_bifurcation(request: BifurcationRequest, submission: SubmissionHere) -> Response:
    """Record a bifurcation diagram to be computed.

    The same request again answers with the same job; after a failure or a cancellation, with a new one that goes on
    from what is there.
    """
    return await submission.accept(request)


@router.post("/orbits", summary="Submit a search for periodic orbits", **_ACCEPTED)
async def submit_orbits(request: OrbitsRequest, submission: SubmissionHere) -> Response:
    """Record periodic orbits to be found, and on request followed in one parameter or two.

    The same request again answers with the same job; after a failure or a cancellation, with a new one that goes on
    from what is there.
    """
    return await submission.accept(request)


@router.post("/manifolds", summary="Submit manifolds of saddles", **_ACCEPTED)
async def submit_manifold(request: ManifoldRequest, submission: SubmissionHere) -> Response:
    """Record manifolds to be grown.

    Whether a seed leads to a saddle is known when it is computed: else the job fails and says what is there.
    """
    return await submission.accept(request)


@router.post("/grazing-curves", summary="Submit a grazing curve", **_ACCEPTED)
async def submit_grazing_curve(request: GrazingCurveRequest, submission: SubmissionHere) -> Response:
    """Record a grazing curve and its pre-images to be computed.

    The same request again answers with the same job; after a failure or a cancellation, with a new one that goes on
    from what is there.
    """
    return await submission.accept(request)

"""Submission of jobs: a route for each kind of `worker.kinds`."""

from collections.abc import Awaitable, Callable
from typing import Any

from fastapi import APIRouter, Response

from service.models.jobs import JobView
from service.models.requests import described_as
from service.routes.dependencies import problems
from service.routes.plain_json import PlainJsonRoute
from service.routes.submission import SubmissionHere
from worker.kinds import KINDS, JobKind


def submission_router() -> APIRouter:
    """Routes of all kinds.

    Returns
    -------
    APIRouter
    """
    router = APIRouter(prefix="/v1", tags=["submit"], route_class=PlainJsonRoute)
    for name, kind in KINDS.items():
        router.post(
            f"/{kind.path}",
            name=f"submit_{name}",
            summary=kind.summary,
            description=kind.description,
            status_code=202,
            response_model=JobView,
            responses=problems(
                s400="malformed JSON",
                s413="body too large",
                s422="what is wrong with the request, field by field",
                s429="too many jobs are queued or running; the header Retry-After says when to try again",
            ),
        )(_submit(kind))
    return router


def _submit(kind: JobKind) -> Callable[..., Awaitable[Response]]:
    body_type: Any = described_as(kind.job_class)

    async def submit(request: body_type, submission: SubmissionHere) -> Response:
        return await submission.accept(kind.job_class, request)

    return submit

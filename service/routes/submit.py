"""Submission of jobs: a route for each kind of `worker.kinds`."""

from collections.abc import Awaitable, Callable, Container
from functools import partial
from typing import Any

from anyio import to_thread
from fastapi import APIRouter, Response

from service.answers.job_views import view_of
from service.answers.limits import settled_job
from service.answers.result_view import result_is_gone
from service.models.jobs import JobView
from service.models.machines import MACHINE
from service.models.requests import described_as
from service.records.job_record import JobRecord
from service.records.jobs import Jobs
from service.routes.dependencies import (
    ChecksHere,
    JobsHere,
    RunnerHere,
    SettingsHere,
    SubmitterHere,
    problems,
)
from service.routes.plain_json import PlainJsonRoute
from service.settings import Settings
from worker.jobs.job import Job
from worker.kinds import KINDS, JobKind


def submit_router(taken: Container[str]) -> APIRouter:
    """Routes of all kinds.

    Parameters
    ----------
    taken : container of str
        Paths of the other routes.

    Returns
    -------
    APIRouter

    Raises
    ------
    ImportError
        If a kind asks for one of them.
    """
    router = APIRouter(prefix="/v1", tags=["submit"], route_class=PlainJsonRoute)
    for name, kind in KINDS.items():
        if f"/v1/{kind.path}" in taken:
            raise ImportError(f"the kind {name} asks for the route /v1/{kind.path}, which this service has already")
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
    fields = kind.job_class.model_fields
    # A kind that is of machines describes its own.
    own = any(field.is_required() for name, field in fields.items() if (field.alias or name) == MACHINE)
    body_type: Any = described_as(kind.job_class, machine=not own)

    async def submit(
        request: body_type, jobs: JobsHere, runner: RunnerHere, settings: SettingsHere, submitter: SubmitterHere,
        checks: ChecksHere,
    ) -> Response:  # fmt: skip
        job = await checks.run(partial(settled_job, kind.job_class, request, settings))
        record, new = await to_thread.run_sync(_answering, job, jobs, settings, submitter)
        if new:
            runner.wake()
        location = {"location": f"/v1/jobs/{record.id}"}
        return Response(view_of(record).body, 202, location, "application/json")

    return submit


def _answering(job: Job, jobs: Jobs, settings: Settings, submitter: str) -> tuple[JobRecord, bool]:
    """Record of the job that answers a request, and whether it is new: one whose result is gone answers no more."""
    known = jobs.answering(job)
    if known is not None:
        if not result_is_gone(known, settings.results):
            return known, False
        jobs.disown_result(known.id)
    return jobs.submit(job, submitter)

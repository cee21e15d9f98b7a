"""Submission of jobs: a route for each kind of `worker.kinds`."""

from collections.abc import Awaitable, Callable, Container
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Response

from service.answers.conditional import JsonAnswer
from service.answers.job_views import JobViews
from service.answers.limits import settled_job
from service.answers.request_checks import RequestChecks
from service.answers.result_view import result_is_gone
from service.errors import JobNotFound
from service.models.jobs import JobView
from service.models.requests import described_as
from service.records.jobs import Jobs
from service.records.threads import DatabaseThreads
from service.routes.dependencies import (
    ChecksHere,
    JobsHere,
    RunnerHere,
    SettingsHere,
    SubmitterHere,
    ThreadsHere,
    ViewsHere,
    problems,
)
from service.routes.plain_json import PlainJsonRoute
from service.runner.process import RunnerProcess
from service.settings import Settings
from worker.jobs.job import Job
from worker.kinds import KINDS, JobKind


@dataclass(frozen=True)
class Submission:
    """What a submission needs: records, views, threads, the runner, limits, the client's name and checks."""

    jobs: Jobs
    views: JobViews
    threads: DatabaseThreads
    runner: RunnerProcess
    settings: Settings
    submitter: str
    checks: RequestChecks

    async def accept(self, job_class: type[Job], body: dict[str, Any]) -> Response:
        """Record a request as a job, wake the runner if the job is new, and respond with its address.

        Parameters
        ----------
        job_class : type
            Class of the kind that is submitted.
        body : dict
            The request, as JSON.

        Returns
        -------
        Response

        Raises
        ------
        LimitExceeded, OutsideDomain, InvalidJob, TooMuch
            Naming what is wrong with the request.
        """
        job = await self.checks.run(partial(settled_job, job_class, body, self.settings))
        known = await self.threads.read(self.views.answering, job)
        if known is not None:
            gone = await self.threads.write(self._disowned, known[0])
            known = None if gone else known
        job_id, view = known or await self._record(job)
        return Response(view.body, 202, {"location": f"/v1/jobs/{job_id}"}, "application/json")

    def _disowned(self, job_id: str) -> bool:
        """Whether a job can no longer answer, because its result is gone."""
        try:
            if not result_is_gone(self.jobs.get(job_id), self.settings.results):
                return False
        except JobNotFound:  # deleted a moment ago
            return True
        self.jobs.disown_result(job_id)
        return True

    async def _record(self, job: Job) -> tuple[str, JsonAnswer]:
        record, new = await self.threads.write(self.jobs.submit, job, self.submitter)
        if new:
            self.runner.wake()
        return record.id, self.views.of_record(record)


async def _submission(
    jobs: JobsHere,
    views: ViewsHere,
    threads: ThreadsHere,
    runner: RunnerHere,
    settings: SettingsHere,
    submitter: SubmitterHere,
    checks: ChecksHere,
) -> Submission:
    return Submission(jobs, views, threads, runner, settings, submitter, checks)


SubmissionHere = Annotated[Submission, Depends(_submission)]


def submission_router(taken: Container[str]) -> APIRouter:
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
    body_type: Any = described_as(kind.job_class)

    async def submit(request: body_type, submission: SubmissionHere) -> Response:
        return await submission.accept(kind.job_class, request)

    return submit

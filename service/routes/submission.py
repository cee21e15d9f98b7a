"""What every submission does, whatever it asks for."""

from dataclasses import dataclass
from typing import Annotated

from fastapi import Depends, Response

from service.answers.conditional import JsonAnswer
from service.answers.job_views import JobViews
from service.answers.limits import JobRequest, check_size
from service.records.jobs import Jobs
from service.records.threads import DatabaseThreads
from service.routes.dependencies import (
    JobsHere,
    RunnerHere,
    SettingsHere,
    SubmitterHere,
    ThreadsHere,
    ViewsHere,
)
from service.runner.process import RunnerProcess
from service.settings import Settings
from worker.job import Job


@dataclass(frozen=True)
class Submission:
    """What a submission needs: the records, how they are told, threads to ask them, the runner, limits, who asks."""

    jobs: Jobs
    views: JobViews
    threads: DatabaseThreads
    runner: RunnerProcess
    settings: Settings
    submitter: str

    async def accept(self, request: JobRequest) -> Response:
        """Record a request as a job, wake the runner where it is a new one, and say where the job is.

        Raises
        ------
        LimitExceeded, OutsideDomain, InvalidJob
            Saying what is wrong with the request.
        """
        check_size(request, self.settings)
        job = request.to_job()
        known = await self.threads.read(self.views.answering, job)
        job_id, view = known or await self._record(job)
        return Response(view.body, 202, {"location": f"/v1/jobs/{job_id}"}, "application/json")

    async def _record(self, job: Job) -> tuple[str, JsonAnswer]:
        record, new = await self.threads.write(self.jobs.submit, job, self.submitter)
        if new:
            self.runner.ring()
        return record.id, self.views.of_record(record)


async def _submission(
    jobs: JobsHere,
    views: ViewsHere,
    threads: ThreadsHere,
    runner: RunnerHere,
    settings: SettingsHere,
    submitter: SubmitterHere,
) -> Submission:
    return Submission(jobs, views, threads, runner, settings, submitter)


SubmissionHere = Annotated[Submission, Depends(_submission)]

"""What every submission does, whatever it asks for."""

from dataclasses import dataclass
from typing import Annotated

from fastapi import Depends, Response

from service.database_threads import DatabaseThreads
from service.dependencies import JobsHere, RunnerHere, SettingsHere, SubmitterHere, ThreadsHere
from service.jobs import Jobs
from service.limits import JobRequest, check_size
from service.models import JobView
from service.runner_process import RunnerProcess
from service.settings import Settings


@dataclass(frozen=True)
class Submission:
    """What a submission needs: the answer under way, the records, threads to ask them, the runner, limits, who asks."""

    response: Response
    jobs: Jobs
    threads: DatabaseThreads
    runner: RunnerProcess
    settings: Settings
    submitter: str

    async def accept(self, request: JobRequest) -> JobView:
        """Record a request as a job, wake the runner where it is a new one, and say where the job is.

        Raises
        ------
        LimitExceeded, OutsideDomain, InvalidJob
            Saying what is wrong with the request.
        """
        check_size(request, self.settings)
        job = request.to_job()
        known = await self.threads.read(self.jobs.answering, job)
        record, new = (known, False) if known else await self.threads.write(self.jobs.submit, job, self.submitter)
        if new:
            self.runner.ring()
        self.response.headers["Location"] = f"/v1/jobs/{record.id}"
        return JobView.from_record(record)


async def _submission(
    response: Response,
    jobs: JobsHere,
    threads: ThreadsHere,
    runner: RunnerHere,
    settings: SettingsHere,
    submitter: SubmitterHere,
) -> Submission:
    return Submission(response, jobs, threads, runner, settings, submitter)


SubmissionHere = Annotated[Submission, Depends(_submission)]

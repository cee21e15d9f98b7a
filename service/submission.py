"""What every submission does, whatever it asks for."""

from dataclasses import dataclass
from typing import Annotated

from fastapi import Depends, Response

from service.dependencies import JobsHere, RunnerHere, SettingsHere, SubmitterHere
from service.jobs import Jobs
from service.limits import JobRequest, check_size
from service.models import JobView
from service.runner_process import RunnerProcess
from service.settings import Settings


@dataclass(frozen=True)
class Submission:
    """What a submission needs: the answer under way, the records, the runner, the limits, and who asks."""

    response: Response
    jobs: Jobs
    runner: RunnerProcess
    settings: Settings
    submitter: str

    def accept(self, request: JobRequest) -> JobView:
        """Record a request as a job, wake the runner where it is a new one, and say where the job is.

        Raises
        ------
        LimitExceeded, OutsideDomain, InvalidJob
            Saying what is wrong with the request.
        """
        check_size(request, self.settings)
        record, new = self.jobs.submit(request.to_job(), self.submitter)
        if new:
            self.runner.ring()
        self.response.headers["Location"] = f"/v1/jobs/{record.id}"
        return JobView.from_record(record)


async def _submission(
    response: Response, jobs: JobsHere, runner: RunnerHere, settings: SettingsHere, submitter: SubmitterHere
) -> Submission:
    return Submission(response, jobs, runner, settings, submitter)


SubmissionHere = Annotated[Submission, Depends(_submission)]

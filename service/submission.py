"""What every submission does, whatever it asks for."""

from typing import Annotated

from fastapi import Depends, Response

from service.dependencies import JobsHere, RunnerHere, SettingsHere, SubmitterHere
from service.limits import JobRequest, check_size
from service.models import JobView


class Submission:
    """What a submission needs: the answer under way, the records, the runner, the limits, and who asks."""

    def __init__(
        self, response: Response, jobs: JobsHere, runner: RunnerHere, settings: SettingsHere, submitter: SubmitterHere
    ) -> None:
        self.response, self.jobs, self.runner, self.settings = response, jobs, runner, settings
        self.submitter = submitter

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


SubmissionHere = Annotated[Submission, Depends()]

"""What every submission does, whatever it asks for."""

from fastapi import Response

from service.dependencies import JobsHere, RunnerHere, SettingsHere
from service.limits import check_size
from service.models import BasinRequest, JobView


def accept(
    request: BasinRequest, response: Response, jobs: JobsHere, runner: RunnerHere, settings: SettingsHere
) -> JobView:
    """Record a request as a job, wake the runner where it is a new one, and say where the job is.

    Raises
    ------
    LimitExceeded, OutsideDomain, InvalidJob
        Saying what is wrong with the request.
    """
    check_size(request, settings)
    record, new = jobs.submit(request.to_job())
    if new:
        runner.ring()
    response.headers["Location"] = f"/v1/jobs/{record.id}"
    return JobView.from_record(record)

"""Withdrawal: a client drops its interest in a job that it has submitted."""

import time

from fastapi import APIRouter, Response

from service.routes.dependencies import (
    CallerHere,
    FeedHere,
    JobId,
    JobsHere,
    RunnerHere,
    problems,
    require_ownership,
)

router = APIRouter(prefix="/v1/jobs/{job_id}", tags=["jobs"])

# A follower that has just closed its stream is counted until the service notices.
_PATIENCE_SECONDS = 1.0
_POLL_SECONDS = 0.05


@router.post(
    "/withdraw",
    status_code=204,
    summary="Drop a job that nobody follows",
    responses=problems(s404="there is no such job"),
)
def withdraw_job(job_id: JobId, jobs: JobsHere, runner: RunnerHere, feed: FeedHere, caller: CallerHere) -> Response:
    """Stop a job unless somebody else follows its events here. What it has computed stays readable."""
    require_ownership(jobs.get(job_id), caller)
    deadline = time.monotonic() + _PATIENCE_SECONDS
    while feed.followers(job_id):
        if time.monotonic() > deadline:
            return Response(status_code=204)
        time.sleep(_POLL_SECONDS)
    jobs.request_cancel(job_id)
    runner.cancel(job_id)
    return Response(status_code=204)

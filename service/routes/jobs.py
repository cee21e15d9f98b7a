"""Jobs: list, state, cancel, withdraw, delete."""

import time
from typing import Annotated

from fastapi import APIRouter, Query, Response

from service.answers.conditional import NOT_MODIFIED, IfNoneMatch, json_or_not_modified
from service.answers.job_views import page_of, view_of
from service.errors import Unstoppable
from service.models.jobs import JobPage, JobView
from service.records.job_record import JobState
from service.routes.dependencies import (
    CallerHere,
    FeedHere,
    JobId,
    JobsHere,
    RunnerHere,
    SettingsHere,
    problems,
    require_ownership,
)
from worker.storage.location import remove_result, result_location

router = APIRouter(prefix="/v1/jobs", tags=["jobs"])

_STOP_SECONDS = 10.0
# A follower that has just closed its stream is counted until the service notices.
_LEAVING_SECONDS = 1.0
_NO_JOB = problems(s404="there is no such job")


@router.get("", response_model=JobPage, summary="List jobs", responses=problems(s422="a parameter is out of range"))
def list_jobs(
    jobs: JobsHere,
    size: Annotated[int, Query(ge=1, le=200, description="Jobs a page")] = 50,
    before: Annotated[int | None, Query(ge=1, le=2**62, description="Cursor of a `next` link")] = None,
    state: JobState | None = None,
) -> Response:
    """Jobs, newest first."""
    return Response(page_of(jobs, before, size, state), media_type="application/json")


@router.get("/{job_id}", response_model=JobView, summary="State of a job", responses=_NO_JOB | NOT_MODIFIED)
def get_job(job_id: JobId, jobs: JobsHere, if_none_match: IfNoneMatch = None) -> Response:
    """State, progress and links of a job."""
    return json_or_not_modified(view_of(jobs.get(job_id)), if_none_match)


@router.post("/{job_id}/cancel", response_model=JobView, status_code=202, summary="Cancel a job", responses=_NO_JOB)
def cancel_job(job_id: JobId, jobs: JobsHere, runner: RunnerHere, caller: CallerHere) -> Response:
    """Stop a job. What it has computed stays readable; a job that has ended is not changed."""
    require_ownership(jobs.get(job_id), caller)
    record = jobs.request_cancel(job_id)
    runner.cancel(job_id)
    return Response(view_of(record).body, 202, media_type="application/json")


@router.post(
    "/{job_id}/withdraw",
    status_code=204,
    summary="Drop a job that nobody follows",
    responses=_NO_JOB,
)
def withdraw_job(job_id: JobId, jobs: JobsHere, runner: RunnerHere, feed: FeedHere, caller: CallerHere) -> Response:
    """Stop a job unless somebody else follows its events here. What it has computed stays readable."""
    require_ownership(jobs.get(job_id), caller)
    deadline = time.monotonic() + _LEAVING_SECONDS
    while feed.followers(job_id):
        if time.monotonic() > deadline:
            return Response(status_code=204)
        time.sleep(0.05)
    jobs.request_cancel(job_id)
    runner.cancel(job_id)
    return Response(status_code=204)


@router.delete(
    "/{job_id}",
    status_code=204,
    summary="Delete a job and its result",
    responses=_NO_JOB | problems(s409="the job did not stop in time: try again"),
)
def delete_job(
    job_id: JobId, jobs: JobsHere, runner: RunnerHere, settings: SettingsHere, caller: CallerHere
) -> Response:
    """Stop a job if it is running, then remove its result and its record."""
    require_ownership(jobs.get(job_id), caller)
    jobs.request_cancel(job_id)
    runner.cancel(job_id)
    deadline = time.monotonic() + _STOP_SECONDS
    while not jobs.get(job_id).state.final:
        if time.monotonic() > deadline:
            raise Unstoppable(f"job {job_id} has not stopped within {_STOP_SECONDS:.0f} s: try again")
        time.sleep(0.05)
    if (store := jobs.release_store(job_id)) is not None:
        remove_result(result_location(settings.results, store))
    jobs.delete(job_id)
    return Response(status_code=204)

"""Jobs: list, state, cancel, delete."""

import time
from typing import Annotated

from fastapi import APIRouter, Query, Response

from service.conditional import NOT_MODIFIED, IfNoneMatch, view_or_not_modified
from service.dependencies import (
    CallerHere,
    JobId,
    JobsHere,
    RunnerHere,
    SettingsHere,
    ThreadsHere,
    demand_ownership,
    problems,
)
from service.errors import Unstoppable
from service.job_record import JobState
from service.jobs import Jobs
from service.models import JobPage, JobView
from worker.result_files import remove_result, result_location

router = APIRouter(prefix="/v1/jobs", tags=["jobs"])

_STOP_SECONDS = 10.0
_NO_JOB = problems(s404="there is no such job")


@router.get("", response_model=JobPage, summary="List jobs", responses=problems(s422="a parameter is out of range"))
async def list_jobs(
    jobs: JobsHere,
    threads: ThreadsHere,
    size: Annotated[int, Query(ge=1, le=200, description="Jobs a page")] = 50,
    before: Annotated[int | None, Query(ge=1, le=2**62, description="Cursor of a `next` link")] = None,
    state: JobState | None = None,
) -> Response:
    """Jobs, newest first."""
    body = await threads.read(_page, jobs, size, before, state)
    return Response(body, media_type="application/json")


def _page(jobs: Jobs, size: int, before: int | None, state: JobState | None) -> str:
    records = jobs.page(before, size + 1, state)
    shown = records[:size]
    following = None
    if len(records) > size:
        only = f"&state={state}" if state else ""
        following = f"/v1/jobs?size={size}&before={shown[-1].number}{only}"
    page = JobPage(jobs=[JobView.from_record(record) for record in shown], next=following)
    return page.model_dump_json(exclude_unset=True)


@router.get("/{job_id}", response_model=JobView, summary="State of a job", responses=_NO_JOB | NOT_MODIFIED)
async def get_job(job_id: JobId, jobs: JobsHere, threads: ThreadsHere, if_none_match: IfNoneMatch = None) -> Response:
    """State, progress and links of a job."""
    record = await threads.read(jobs.get, job_id)
    return view_or_not_modified(JobView.from_record(record), if_none_match, exclude_unset=True)


@router.post(
    "/{job_id}/cancel", status_code=202, response_model_exclude_unset=True, summary="Cancel a job", responses=_NO_JOB
)
def cancel_job(job_id: JobId, jobs: JobsHere, runner: RunnerHere, caller: CallerHere) -> JobView:
    """Stop a job. What it has computed stays readable; a job that has ended stays as it is."""
    demand_ownership(jobs.get(job_id), caller)
    record = jobs.request_cancel(job_id)
    runner.cancel(job_id)
    return JobView.from_record(record)


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
    demand_ownership(jobs.get(job_id), caller)
    jobs.request_cancel(job_id)
    runner.cancel(job_id)
    patience = time.monotonic() + _STOP_SECONDS
    while not jobs.get(job_id).state.final:
        if time.monotonic() > patience:
            raise Unstoppable(f"job {job_id} has not stopped within {_STOP_SECONDS:.0f} s: try again")
        time.sleep(0.05)
    if (store := jobs.give_up_store(job_id)) is not None:
        remove_result(result_location(settings.results, store))
    jobs.delete(job_id)
    return Response(status_code=204)

"""What routes are given: the settings, the job records, the runner.

What only looks something up is `async`: FastAPI sends every other function to a thread, which costs more than a read of
the database.
"""

import re
from collections.abc import Awaitable, Callable
from typing import Annotated, Any

from fastapi import Depends, Path, Request
from pydantic import AfterValidator

from service.answers.event_feed import EventFeed
from service.answers.job_views import JobViews
from service.answers.readiness import Probes
from service.answers.summaries import Summaries
from service.errors import JobNotFound, NotYours
from service.records.events import Events
from service.records.job_record import JobRecord
from service.records.jobs import Jobs
from service.records.key_record import KeyScope
from service.records.keys import Caller
from service.records.threads import DatabaseThreads
from service.runner.process import RunnerProcess
from service.settings import Settings


def _kept_as(name: str) -> Callable[[Request], Awaitable[Any]]:
    """Dependency on what the application's state holds under a name."""

    async def kept(request: Request) -> Any:
        return getattr(request.app.state, name)

    return kept


async def _caller(request: Request) -> Caller:
    caller: Caller = request.state.caller
    return caller


def _job_id(text: str) -> str:
    # Whatever is no id ends here, before anything looks it up or makes a path of it.
    if not re.fullmatch(_JOB_ID, text):
        raise JobNotFound(f"there is no job {text}: an id has 32 hexadecimal digits")
    return text


async def _submitter(caller: "CallerHere") -> str:
    return caller.name


def demand_ownership(record: JobRecord, caller: Caller) -> None:
    """Refuse to touch another caller's job.

    Raises
    ------
    NotYours
    """
    if record.submitter != caller.name and not caller.may(KeyScope.ADMIN):
        raise NotYours(f"job {record.id} was submitted by {record.submitter}: that needs the scope {KeyScope.ADMIN}")


_JOB_ID = "[0-9a-f]{32}"
JobId = Annotated[str, Path(json_schema_extra={"pattern": f"^{_JOB_ID}$"}), AfterValidator(_job_id)]
EventsHere = Annotated[Events, Depends(_kept_as("events"))]
ProbesHere = Annotated[Probes, Depends(_kept_as("probes"))]
FeedHere = Annotated[EventFeed, Depends(_kept_as("feed"))]
SummariesHere = Annotated[Summaries, Depends(_kept_as("summaries"))]
CallerHere = Annotated[Caller, Depends(_caller)]
SettingsHere = Annotated[Settings, Depends(_kept_as("settings"))]
ViewsHere = Annotated[JobViews, Depends(_kept_as("views"))]
JobsHere = Annotated[Jobs, Depends(_kept_as("jobs"))]
ThreadsHere = Annotated[DatabaseThreads, Depends(_kept_as("threads"))]
RunnerHere = Annotated[RunnerProcess, Depends(_kept_as("runner"))]
SubmitterHere = Annotated[str, Depends(_submitter)]


def problems(**details: str) -> dict[int | str, dict[str, object]]:
    """Declare problem documents a route can answer with: ``problems(s404="no such job")``."""
    return {
        int(status[1:]): {"description": detail, "content": {"application/problem+json": {"schema": _PROBLEM}}}
        for status, detail in details.items()
    }


_PROBLEM = {"$ref": "#/components/schemas/Problem"}

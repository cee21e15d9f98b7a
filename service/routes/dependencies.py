"""Dependencies of routes: the settings, the job records, the runner.

Dependencies that only look something up are `async`: FastAPI runs every other function in a thread.
"""

import re
from collections.abc import AsyncIterator, Awaitable, Callable
from typing import Annotated, Any

from fastapi import Depends, Path, Request
from fastapi.dependencies.models import Dependant
from fastapi.exceptions import RequestValidationError
from pydantic import AfterValidator

from service.answers.event_feed import EventFeed
from service.answers.large_answers import LargeAnswers
from service.answers.readiness import Probes
from service.answers.request_checks import RequestChecks
from service.errors import JobNotFound, NotYours, WrongKind
from service.records.events import Events
from service.records.job_record import JobRecord
from service.records.jobs import Jobs
from service.records.keys import Caller, KeyScope
from service.runner.process import RunnerProcess
from service.settings import Settings


def _from_state(name: str) -> Callable[[Request], Awaitable[Any]]:
    """Dependency on an attribute of the application's state."""

    async def attribute(request: Request) -> Any:
        return getattr(request.app.state, name)

    return attribute


async def _caller(request: Request) -> Caller:
    caller: Caller = request.state.caller
    return caller


async def _large_answer(request: Request) -> AsyncIterator[None]:
    large: LargeAnswers = request.app.state.large_answers
    async with large.place():
        yield


def _job_id(text: str) -> str:
    # Anything else is refused here, before it is looked up or becomes part of a path.
    if not re.fullmatch(_JOB_ID, text):
        raise JobNotFound(f"there is no job {text}: an id has 32 hexadecimal digits")
    return text


async def _submitter(caller: "CallerHere") -> str:
    return caller.name


def require_ownership(record: JobRecord, caller: Caller) -> None:
    """Refuse a caller that may not change a job.

    Raises
    ------
    NotYours
        If the caller neither submitted the job nor is an administrator.
    """
    if record.submitter != caller.name and not caller.may(KeyScope.ADMIN):
        raise NotYours(f"job {record.id} was submitted by {record.submitter}: that needs the scope {KeyScope.ADMIN}")


def require_kind(record: JobRecord, what: str, *kinds: str) -> None:
    """Refuse a job that has nothing of what is requested.

    Raises
    ------
    WrongKind
        If the job is of none of these kinds.
    """
    if record.kind not in kinds:
        raise WrongKind(
            f"job {record.id} is of kind {record.kind}: only jobs of kind {' and '.join(kinds)} have {what}"
        )


async def refuse_unknown_parameters(request: Request) -> None:
    """Refuse query parameters that the route does not have.

    Raises
    ------
    RequestValidationError
        It lists those that the route has.
    """
    route = request.scope["route"]
    # The pages read their own addresses: the explorer's holds what is seen.
    if not request.query_params or not route.include_in_schema:
        return
    known = sorted(_parameters_of(route.dependant))
    takes = f"this address takes {', '.join(known)}" if known else "this address takes none"
    unknown = [name for name in request.query_params if name not in known]
    if unknown:
        errors = [{"type": "unknown", "loc": ("query", name), "msg": f"unknown parameter: {takes}"} for name in unknown]
        raise RequestValidationError(errors)


def _parameters_of(dependant: Dependant) -> set[str]:
    """Names of the query parameters of a route, also of those that only what it depends on reads."""
    own = {each.alias for each in dependant.query_params}
    return own.union(*map(_parameters_of, dependant.dependencies))


_JOB_ID = "[0-9a-f]{32}"
JobId = Annotated[str, Path(json_schema_extra={"pattern": f"^{_JOB_ID}$"}), AfterValidator(_job_id)]
EventsHere = Annotated[Events, Depends(_from_state("events"))]
ProbesHere = Annotated[Probes, Depends(_from_state("probes"))]
ChecksHere = Annotated[RequestChecks, Depends(_from_state("checks"))]
FeedHere = Annotated[EventFeed, Depends(_from_state("feed"))]
CallerHere = Annotated[Caller, Depends(_caller)]
SettingsHere = Annotated[Settings, Depends(_from_state("settings"))]
LARGE = Depends(_large_answer)
"""For routes whose answer grows with a job: a few of them are answered at a time."""
JobsHere = Annotated[Jobs, Depends(_from_state("jobs"))]
RunnerHere = Annotated[RunnerProcess, Depends(_from_state("runner"))]
SubmitterHere = Annotated[str, Depends(_submitter)]


def problems(**details: str) -> dict[int | str, dict[str, object]]:
    """Declare the problem documents of a route, by status: ``problems(s404="no such job")``."""
    return {
        int(status[1:]): {"description": detail, "content": {"application/problem+json": {"schema": _PROBLEM}}}
        for status, detail in details.items()
    }


_PROBLEM = {"$ref": "#/components/schemas/Problem"}

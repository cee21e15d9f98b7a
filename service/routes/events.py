"""Events of a job, as they happen."""

import contextlib
from collections.abc import AsyncIterator
from typing import Annotated

from fastapi import APIRouter, Depends, Header, Response
from fastapi.sse import EventSourceResponse, ServerSentEvent

from service.models.jobs import EventView
from service.records.events import EventRecord
from service.routes.dependencies import EventsHere, FeedHere, JobId, JobsHere, problems

router = APIRouter(prefix="/v1/jobs/{job_id}", tags=["jobs"])

_NOTHING_FOLLOWS: dict[int | str, dict[str, object]] = {
    204: {"description": "the job has ended, and the client has seen that"}
}

# Those that FastAPI gives a stream that it begins.
_OF_STREAMS = {"cache-control": "no-cache", "x-accel-buffering": "no"}


def _start(
    job_id: JobId,
    jobs: JobsHere,
    events: EventsHere,
    response: Response,
    last_event_id: Annotated[int | None, Header(ge=0, lt=2**31, description="Number of the last event seen")] = None,
) -> int | None:
    """Number after which the stream begins; None, and status 204, if no event will ever follow."""
    job = jobs.get(job_id)
    newest = events.newest([job_id]).get(job_id, 0)
    # A number that the job has not reached belongs to another job.
    start = last_event_id if last_event_id is not None and last_event_id <= newest else 0
    if job.state.final and start == newest:
        response.status_code = 204
        return None
    return start


@router.get(
    "/events",
    response_class=EventSourceResponse,
    summary="Follow a job",
    responses=_NOTHING_FOLLOWS | problems(s404="there is no such job", s422="Last-Event-ID is no number"),
)
async def follow_job(
    job_id: JobId, start: Annotated[int | None, Depends(_start)], feed: FeedHere
) -> AsyncIterator[ServerSentEvent]:
    """Server-Sent Events named `state` and `progress`, until the job has ended.

    The data of each event is JSON of the schema EventView; its id is its number. Sent back as `Last-Event-ID`, the
    number continues the stream with all changes of state since then and with recent progress.
    """
    if start is None:
        return
    async with contextlib.aclosing(feed.follow(job_id, start)) as events:
        async for event in events:
            yield _as_sent(event)


@router.head("/events", include_in_schema=False)
def head_of_events(start: Annotated[int | None, Depends(_start)]) -> Response:
    """What a stream would begin with. It has no end that could be waited for, so it is not begun."""
    return Response(status_code=204) if start is None else EventSourceResponse(iter(()), headers=_OF_STREAMS)


def _as_sent(event: EventRecord) -> ServerSentEvent:
    name = "state" if event.progress is None else "progress"
    return ServerSentEvent(data=EventView.from_record(event), event=name, id=str(event.sequence))

"""Brings the events of jobs to whoever follows them, from the database: a job may run in any replica.

One task of this process asks the database a few times a second, and only while somebody follows a job. It asks for the
highest number of every job that is followed; what is new of a job is read once, however many follow it.
"""

import asyncio
import logging
from collections.abc import AsyncGenerator

from anyio import to_thread

from service.records.event_record import EventRecord
from service.records.events import Events

_log = logging.getLogger("rattle.events")
_POLL_SECONDS = 0.25


class _Topic:
    """A job that is followed: how far it was read, and a bell for each follower."""

    def __init__(self) -> None:
        self.sequence = 0
        self.news: list[EventRecord] = []
        self.gone = False
        self.bells: set[asyncio.Event] = set()

    def ring(self) -> None:
        for bell in self.bells:
            bell.set()


class EventFeed:
    """The events of jobs as they happen.

    Guarantees. A follower gets every change of state after the number that he names, in order and once; of progress at
    least the newest. He is told within half a second. What he holds here is freed when he leaves.

    Parameters
    ----------
    events : Events
    """

    def __init__(self, events: Events) -> None:
        self._events = events
        self._topics: dict[str, _Topic] = {}
        self._asking: asyncio.Task[None] | None = None
        self._closed = False

    @property
    def followed(self) -> int:
        """How many jobs are followed at the moment."""
        return len(self._topics)

    def close(self) -> None:
        """End all streams, because the service stops."""
        self._closed = True
        if self._asking is not None:
            self._asking.cancel()
        for topic in self._topics.values():
            topic.ring()

    async def follow(self, job_id: str, sequence: int) -> AsyncGenerator[EventRecord]:
        """Events of a job with higher numbers, until its last one, or until there is no such job."""
        bell = asyncio.Event()
        topic = self._topics.setdefault(job_id, _Topic())
        topic.bells.add(bell)
        try:
            if self._asking is None or self._asking.done():
                self._asking = asyncio.create_task(self._ask())
            while not (self._closed or topic.gone):
                bell.clear()
                for event in await self._since(topic, job_id, sequence):
                    yield event
                    sequence = event.sequence
                    if event.state.final:
                        return
                await bell.wait()
        finally:
            topic.bells.discard(bell)
            if not topic.bells and self._topics.get(job_id) is topic:
                del self._topics[job_id]

    async def _since(self, topic: _Topic, job_id: str, sequence: int) -> list[EventRecord]:
        """What a follower has not had; from what was read last for all of them where that reaches back far enough."""
        if topic.news and topic.news[0].sequence <= sequence + 1:
            return [event for event in topic.news if event.sequence > sequence]
        return await to_thread.run_sync(self._events.after, job_id, sequence)

    async def _ask(self) -> None:
        while self._topics and not self._closed:
            await asyncio.sleep(_POLL_SECONDS)
            topics = dict(self._topics)
            try:
                newest = await to_thread.run_sync(self._events.newest, list(topics))
                for job_id, topic in topics.items():
                    await self._bring(topic, job_id, newest.get(job_id))
            except Exception:
                _log.exception("the events of jobs could not be read; trying again")

    async def _bring(self, topic: _Topic, job_id: str, newest: int | None) -> None:
        if newest is None:
            topic.gone = True
        elif newest > topic.sequence:
            topic.news = await to_thread.run_sync(self._events.after, job_id, topic.sequence)
            topic.sequence = newest
        else:
            return
        topic.ring()

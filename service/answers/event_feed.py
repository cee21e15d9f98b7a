"""Passes the events of jobs on to their followers. They come from the database, because a job may run in any replica.

One task of this process polls the database a few times a second while any job is followed. It reads the highest event
number of every followed job. New events of a job are read once, however many follow it.
"""

import asyncio
import logging
from collections.abc import AsyncGenerator

from anyio import to_thread

from service.records.events import EventRecord, Events

_log = logging.getLogger("rattle.events")
_POLL_SECONDS = 0.25


class _Topic:
    """A followed job: the last event that was read, and an asyncio event that wakes each follower."""

    def __init__(self) -> None:
        self.sequence = 0
        self.recent: list[EventRecord] = []
        self.gone = False
        self.wakers: set[asyncio.Event] = set()

    def wake(self) -> None:
        for waker in self.wakers:
            waker.set()


class EventFeed:
    """The events of jobs as they happen.

    Guarantees. A follower gets every change of state after its event number, once and in order, and at least the
    newest progress. Each event arrives within half a second. A follower's memory is freed when it leaves.

    Parameters
    ----------
    events : Events
    """

    def __init__(self, events: Events) -> None:
        self._events = events
        self._topics: dict[str, _Topic] = {}
        self._polling: asyncio.Task[None] | None = None
        self._closed = False

    @property
    def followed(self) -> int:
        """Number of jobs being followed."""
        return len(self._topics)

    def followers(self, job_id: str) -> int:
        """Number of followers of a job."""
        topic = self._topics.get(job_id)
        return len(topic.wakers) if topic else 0

    def close(self) -> None:
        """End all streams when the service stops."""
        self._closed = True
        if self._polling is not None:
            self._polling.cancel()
        for topic in self._topics.values():
            topic.wake()

    async def follow(self, job_id: str, sequence: int) -> AsyncGenerator[EventRecord]:
        """Events of a job with higher numbers, until its last one, or until the job is deleted."""
        waker = asyncio.Event()
        topic = self._topics.setdefault(job_id, _Topic())
        topic.wakers.add(waker)
        try:
            if self._polling is None or self._polling.done():
                self._polling = asyncio.create_task(self._poll())
            while not (self._closed or topic.gone):
                waker.clear()
                for event in await self._since(topic, job_id, sequence):
                    yield event
                    sequence = event.sequence
                    if event.state.final:
                        return
                await waker.wait()
        finally:
            topic.wakers.discard(waker)
            if not topic.wakers and self._topics.get(job_id) is topic:
                del self._topics[job_id]

    async def _since(self, topic: _Topic, job_id: str, sequence: int) -> list[EventRecord]:
        """Events that a follower has not seen. They need no query if the last read for all reaches back far enough."""
        if topic.recent and topic.recent[0].sequence <= sequence + 1:
            return [event for event in topic.recent if event.sequence > sequence]
        return await to_thread.run_sync(self._events.after, job_id, sequence)

    async def _poll(self) -> None:
        while self._topics and not self._closed:
            await asyncio.sleep(_POLL_SECONDS)
            topics = dict(self._topics)
            try:
                newest = await to_thread.run_sync(self._events.newest, list(topics))
                for job_id, topic in topics.items():
                    await self._update(topic, job_id, newest.get(job_id))
            except Exception:
                _log.exception("the events of jobs could not be read; trying again")

    async def _update(self, topic: _Topic, job_id: str, newest: int | None) -> None:
        if newest is None:
            topic.gone = True
        elif newest > topic.sequence:
            topic.recent = await to_thread.run_sync(self._events.after, job_id, topic.sequence)
            topic.sequence = newest
        else:
            return
        topic.wake()

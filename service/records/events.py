"""Numbered events of each job, which its event stream replays.

An event is written in the transaction that changes the job, after the job's row has been changed. That row is locked
until the transaction ends, so the events of a job are numbered without gaps or duplicates, and appear in order.
"""

from collections.abc import Callable, Collection, Mapping
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import JSON, DateTime, Enum, String, delete, func, select
from sqlalchemy.orm import Mapped, Session, mapped_column

from service.records.engine import to_read
from service.records.job_record import Base, JobState

PROGRESS_KEPT = 64
"""Progress events that are kept for a running job: a quarter of a minute."""


class EventRecord(Base):
    """One event of a job: a change of state, or progress.

    The events of a job are numbered from 1 without gaps. Changes of state are kept as long as the job. Progress is
    kept for a short time only, and not after the job has ended. So a job has a few rows, or a few dozen while it runs.
    """

    __tablename__ = "events"

    job_id: Mapped[str] = mapped_column(String(32), primary_key=True)
    sequence: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    state: Mapped[JobState] = mapped_column(
        Enum(JobState, native_enum=False, length=16, values_callable=lambda states: [state.value for state in states])
    )
    # Set for progress.
    progress: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True))
    # Set for the state failed.
    error: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True))
    moment: Mapped[datetime] = mapped_column(DateTime(timezone=True))


def note_event(
    session: Session, job_id: str, state: JobState, progress: dict[str, Any] | None = None, error: Any = None
) -> None:
    """Write an event of a job that this transaction has created or changed."""
    of_job = EventRecord.job_id == job_id
    sequence = 1 + (session.scalar(select(func.max(EventRecord.sequence)).where(of_job)) or 0)
    session.add(
        EventRecord(
            job_id=job_id, sequence=sequence, state=state, progress=progress, error=error, moment=datetime.now(UTC)
        )
    )
    if progress is not None or state.final:
        past = sequence if state.final else sequence - PROGRESS_KEPT
        outdated = of_job, EventRecord.progress.is_not(None), EventRecord.sequence <= past
        session.execute(delete(EventRecord).where(*outdated))


def delete_events(session: Session, job_id: str) -> None:
    """Delete the events of a job that is being deleted."""
    session.execute(delete(EventRecord).where(EventRecord.job_id == job_id))


class Events:
    """Reads the events in a service's database.

    Parameters
    ----------
    sessions : callable
        Makes database sessions.
    """

    def __init__(self, sessions: Callable[[], Session]) -> None:
        self._sessions = sessions

    def after(self, job_id: str, sequence: int) -> list[EventRecord]:
        """Events of a job with higher numbers, in order."""
        later = select(EventRecord).where(EventRecord.job_id == job_id, EventRecord.sequence > sequence)
        with to_read(self._sessions()) as session:
            return list(session.scalars(later.order_by(EventRecord.sequence)))

    def newest(self, job_ids: Collection[str]) -> Mapping[str, int]:
        """Highest event number of each of some jobs; jobs that no longer exist are left out."""
        newest = select(EventRecord.job_id, func.max(EventRecord.sequence)).where(EventRecord.job_id.in_(job_ids))
        with to_read(self._sessions()) as session:
            return dict(session.execute(newest.group_by(EventRecord.job_id)).all())

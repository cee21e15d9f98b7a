"""When results were last read, by whichever replica: what is in use is not deleted to make room."""

import time
from datetime import UTC, datetime
from typing import Any, NamedTuple

from sqlalchemy import DateTime, String, delete, select
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Mapped, mapped_column

from service.records.engine import to_read
from service.records.job_record import LIVE, Base, JobRecord

# A reader of chunks asks many times a second.
_NOTE_SECONDS = 60.0


class ReadRecord(Base):
    """Last reading of one job's result, to a minute."""

    __tablename__ = "reads"

    job_id: Mapped[str] = mapped_column(String(32), primary_key=True)
    read: Mapped[datetime] = mapped_column(DateTime(timezone=True))


class Ended(NamedTuple):
    """A job that has ended: its id, its store, and when it was last of use, read or just finished."""

    id: str
    store: str
    used: datetime


class Reads:
    """Readings of results, in the database.

    Parameters
    ----------
    sessions : callable
        Makes sessions.
    """

    def __init__(self, sessions: Any) -> None:
        self._sessions = sessions
        self._noted: dict[str, float] = {}

    def note(self, job_id: str) -> None:
        """Note that a result is being read, at most once a minute."""
        now = time.monotonic()
        if now - self._noted.get(job_id, -_NOTE_SECONDS) < _NOTE_SECONDS:
            return
        self._noted = {known: then for known, then in self._noted.items() if now - then < _NOTE_SECONDS}
        self._noted[job_id] = now
        with self._sessions() as session:
            session.merge(ReadRecord(job_id=job_id, read=datetime.now(UTC)))
            try:
                session.commit()
            except IntegrityError:
                session.rollback()  # another replica has just noted it

    def ended(self) -> list[Ended]:
        """Jobs that have ended and whose results may be there, those that were of no use for longest first."""
        columns = JobRecord.id, JobRecord.store, JobRecord.finished, ReadRecord.read
        there = JobRecord.state.not_in(LIVE), JobRecord.store.is_not(None), JobRecord.finished.is_not(None)
        query = select(*columns).outerjoin(ReadRecord, ReadRecord.job_id == JobRecord.id).where(*there)
        with to_read(self._sessions()) as session:
            rows = session.execute(query).all()
        found = [
            Ended(job_id, store, max(_utc(each) for each in (done, read) if each))
            for job_id, store, done, read in rows
            if store is not None
        ]
        return sorted(found, key=lambda each: each.used)

    def last(self, job_id: str) -> datetime | None:
        """When a result was last read."""
        with to_read(self._sessions()) as session:
            read = session.scalar(select(ReadRecord.read).where(ReadRecord.job_id == job_id))
        return None if read is None else _utc(read)

    def forget_deleted(self) -> None:
        """Forget readings of jobs that are no more."""
        with self._sessions() as session:
            session.execute(delete(ReadRecord).where(ReadRecord.job_id.not_in(select(JobRecord.id))))
            session.commit()


def _utc(moment: datetime) -> datetime:
    """A moment with its zone, which SQLite does not keep."""
    return moment if moment.tzinfo else moment.replace(tzinfo=UTC)

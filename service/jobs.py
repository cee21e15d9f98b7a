"""What happens to job records: submission, changes of state, progress."""

import uuid
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import delete, func, select, update
from sqlalchemy.exc import IntegrityError, SQLAlchemyError
from sqlalchemy.orm import Session

from service.errors import JobNotFound
from service.events import forget_events, note_event
from service.job_record import JobRecord, JobState
from worker.job_kinds import Job

_LIVE = (JobState.QUEUED, JobState.RUNNING, JobState.CANCELLING)


def _now() -> datetime:
    return datetime.now(UTC)


class Jobs:
    """The job records.

    Guarantees. The same request is answered with the same job as long as that job can answer it; after a failure or a
    cancellation a new one is made. A state changes only from the state it is expected in, and a final state never.

    Parameters
    ----------
    sessions : callable
        Makes database sessions.
    """

    def __init__(self, sessions: Callable[[], Session]) -> None:
        self._sessions = sessions

    def submit(self, job: Job, submitter: str) -> tuple[JobRecord, bool]:
        """Record of the job that answers a request, and whether it is new; `submitter` is noted where it is."""
        while True:
            with self._sessions() as session:
                known = session.scalar(select(JobRecord).where(JobRecord.answering == job.digest))
                if known is not None:
                    return known, False
                record = JobRecord(
                    id=uuid.uuid4().hex, kind=job.kind, digest=job.digest, answering=job.digest, state=JobState.QUEUED,
                    request=job.request(), submitter=submitter, created=_now(),
                )  # fmt: skip
                session.add(record)
                try:
                    session.flush()
                    note_event(session, record.id, record.state)
                    session.commit()
                except IntegrityError:
                    continue  # another replica recorded the same request in the meantime: take that one
                return record, True

    def get(self, job_id: str) -> JobRecord:
        """Record by id.

        Raises
        ------
        JobNotFound
        """
        with self._sessions() as session:
            record = session.scalar(select(JobRecord).where(JobRecord.id == job_id))
        if record is None:
            raise JobNotFound(f"there is no job {job_id}")
        return record

    def page(self, before: int | None, size: int, state: JobState | None) -> list[JobRecord]:
        """Up to `size` records, newest first, older than number `before`."""
        query = select(JobRecord).order_by(JobRecord.number.desc()).limit(size)
        if before is not None:
            query = query.where(JobRecord.number < before)
        if state is not None:
            query = query.where(JobRecord.state == state)
        with self._sessions() as session:
            return list(session.scalars(query))

    def claim(self) -> JobRecord | None:
        """Oldest queued job, now running; None where none is queued."""
        with self._sessions() as session:
            query = select(JobRecord).where(JobRecord.state == JobState.QUEUED).order_by(JobRecord.number).limit(1)
            record = session.scalar(query)
        if record is None or not self.move(record.id, JobState.QUEUED, JobState.RUNNING, started=_now()):
            return None
        return self.get(record.id)

    def move(self, job_id: str, expected: JobState, state: JobState, **values: Any) -> bool:
        """Change a state from the expected one; False where it was another."""
        if state.final:
            values["finished"] = _now()
        if state in (JobState.FAILED, JobState.CANCELLED):
            values["answering"] = None
        with self._sessions() as session:
            change = update(JobRecord).where(JobRecord.id == job_id, JobRecord.state == expected)
            done = bool(session.execute(change.values(state=state, **values)).rowcount == 1)  # type: ignore[attr-defined]
            if done:
                note_event(session, job_id, state, error=values.get("error"))
            session.commit()
        return done

    def record_progress(self, job_id: str, progress: dict[str, Any]) -> None:
        """Note how far a running job is."""
        with self._sessions() as session:
            further = update(JobRecord).where(JobRecord.id == job_id).values(progress=progress)
            state = session.scalar(further.returning(JobRecord.state))
            if state is not None and not state.final:
                note_event(session, job_id, state, progress)
            session.commit()

    def request_cancel(self, job_id: str) -> JobRecord:
        """Cancel a queued job at once, ask a running one to stop; a final one stays as it is."""
        for _ in range(3):  # the state may move under us, forwards only: twice at most
            record = self.get(job_id)
            if record.state == JobState.QUEUED and not self.move(job_id, JobState.QUEUED, JobState.CANCELLED):
                continue
            if record.state == JobState.RUNNING and not self.move(job_id, JobState.RUNNING, JobState.CANCELLING):
                continue
            break
        return self.get(job_id)

    def delete(self, job_id: str) -> None:
        """Remove the record of a job that has ended."""
        with self._sessions() as session:
            gone = delete(JobRecord).where(JobRecord.id == job_id, JobRecord.state.not_in(_LIVE))
            if session.execute(gone).rowcount == 1:  # type: ignore[attr-defined]
                forget_events(session, job_id)
            session.commit()

    def count(self) -> dict[JobState, int]:
        """How many jobs are in each state."""
        with self._sessions() as session:
            counts = select(JobRecord.state, func.count()).group_by(JobRecord.state)
            return dict(session.execute(counts).all())

    def answers(self) -> bool:
        """Whether the database does."""
        try:
            with self._sessions() as session:
                session.execute(select(1))
        except SQLAlchemyError:
            return False
        return True

    def recover(self) -> None:
        """After a crash: jobs left running are queued again, those being cancelled are cancelled."""
        with self._sessions() as session:
            left = session.scalars(select(JobRecord).where(JobRecord.state.in_(_LIVE[1:]))).all()
        for record in left:
            state = JobState.QUEUED if record.state == JobState.RUNNING else JobState.CANCELLED
            self.move(record.id, record.state, state)

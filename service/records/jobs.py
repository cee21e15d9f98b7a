"""What happens to job records: submission, leases, changes of state, progress."""

import uuid
from collections.abc import Callable, Collection
from datetime import UTC, datetime
from enum import Enum
from typing import Any

from sqlalchemy import ColumnElement, and_, bindparam, delete, func, or_, select, text, true, update
from sqlalchemy.exc import IntegrityError, SQLAlchemyError
from sqlalchemy.orm import Session, aliased

from service.errors import JobNotFound
from service.records.clock import database_time
from service.records.engine import to_read
from service.records.events import forget_events, note_event
from service.records.job_record import LIVE, SMALL_PLACES, JobRecord, JobState
from service.records.quotas import check_quotas
from service.records.replica import is_dead
from service.settings import Quotas
from worker.jobs.job import Job

LEASE_SECONDS = 20.0
"""How long a replica need not be heard of before its jobs are taken over."""
_HELD = (JobState.RUNNING, JobState.CANCELLING)
# What is asked hundreds of times a second is built once.
_BY_ID = select(JobRecord).where(JobRecord.id == bindparam("job_id"))
_ANSWERING = select(JobRecord).where(JobRecord.answering == bindparam("digest"))
# Any number, as long as every replica takes the same one.
_SUBMISSION_LOCK = 6


def _now() -> datetime:
    return datetime.now(UTC)


def _lease_over() -> ColumnElement[bool]:
    return or_(JobRecord.lease_until.is_(None), JobRecord.lease_until < database_time())


class Whose(Enum):
    """Of which submitters."""

    ANYONES = "anyone's"
    NEWCOMERS = "of who has nothing running"
    NOBODYS = "nobody's"


class Jobs:
    """The job records.

    Guarantees. The same request is answered with the same job as long as that job can answer it; after a failure or a
    cancellation a new one is made, which goes on from what is in the store. A state changes only from the state it is
    expected in, and a final state never. A job is leased to one claim at a time, and what is done in the name of
    another one changes nothing.

    Parameters
    ----------
    sessions : callable
        Makes database sessions.
    quotas : Quotas
        What submissions are refused beyond.
    """

    def __init__(self, sessions: Callable[[], Session], quotas: Quotas) -> None:
        self._sessions, self._quotas = sessions, quotas

    def submit(self, job: Job, submitter: str) -> tuple[JobRecord, bool]:
        """Record of the job that answers a request, and whether it is new; `submitter` is noted where it is.

        Raises
        ------
        TooMuch, LimitExceeded
            Where a quota leaves no room for a new job.
        """
        while True:
            with self._sessions() as session:
                _one_at_a_time(session)
                known = session.scalar(_ANSWERING, {"digest": job.digest})
                if known is not None:
                    return known, False
                check_quotas(self._quotas, session, submitter, job.places)
                job_id = uuid.uuid4().hex
                record = JobRecord(
                    id=job_id, kind=job.kind, digest=job.digest, answering=job.digest, state=JobState.QUEUED,
                    request=job.request(), submitter=submitter, created=_now(), places=job.places,
                    store=_store_left(session, job.digest) or job_id,
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
        with to_read(self._sessions()) as session:
            record = session.scalar(_BY_ID, {"job_id": job_id})
        if record is None:
            raise JobNotFound(f"there is no job {job_id}")
        return record

    def records(self, ids: Collection[str]) -> list[JobRecord]:
        """Those of these ids that there are, in any order."""
        with to_read(self._sessions()) as session:
            return list(session.scalars(select(JobRecord).where(JobRecord.id.in_(ids))))

    def claim(self, owner: str, *, but: Collection[str] = (), large: Whose = Whose.ANYONES) -> JobRecord | None:
        """A job that is queued, or that a dead replica has left running: now leased, and running.

        It is of the submitter with the fewest jobs running, then the one who was served longest ago, and the oldest of
        that submitter's.

        Parameters
        ----------
        owner : str
            Who claims; unlike any other claim.
        but : collection of str
            Jobs that are not to be claimed.
        large : Whose
            Whose jobs may be claimed that are not small.
        """
        free = and_(
            or_(JobRecord.state == JobState.QUEUED, and_(JobRecord.state == JobState.RUNNING, _lease_over())),
            JobRecord.id.not_in(but),
            _allowed(large),
        )
        values = {
            "state": JobState.RUNNING, "started": _now(), "lease_owner": owner,
            "lease_until": database_time() + LEASE_SECONDS,
        }  # fmt: skip
        while True:
            with self._sessions() as session:
                number = session.scalar(_next_in_turn(free))
                if number is None:
                    return None
                taken = update(JobRecord).where(JobRecord.number == number, free).values(values)
                job_id = session.scalar(taken.returning(JobRecord.id))
                if job_id is not None:
                    note_event(session, job_id, JobState.RUNNING)
                session.commit()
                if job_id is not None:
                    return session.scalar(select(JobRecord).where(JobRecord.id == job_id))

    def renew(self, owners: Collection[str]) -> dict[str, JobState]:
        """Renew the leases of some claims; those that still hold theirs, with the states of their jobs."""
        ours = JobRecord.lease_owner.in_(owners), JobRecord.state.in_(_HELD)
        with self._sessions() as session:
            session.execute(update(JobRecord).where(*ours).values(lease_until=database_time() + LEASE_SECONDS))
            session.commit()
            held = session.execute(select(JobRecord.lease_owner, JobRecord.state).where(*ours)).all()
        return {str(owner): state for owner, state in held}

    def free_the_dead(self) -> None:
        """End the leases of replicas that are seen to be dead, and cancel what nobody is left to cancel."""
        with self._sessions() as session:
            owners = session.scalars(select(JobRecord.lease_owner).where(JobRecord.state.in_(_HELD)).distinct()).all()
            dead = [owner for owner in owners if owner is not None and is_dead(owner.partition("/")[0])]
            if dead:
                session.execute(update(JobRecord).where(JobRecord.lease_owner.in_(dead)).values(lease_until=None))
                session.commit()
            left = session.scalars(
                select(JobRecord.id).where(JobRecord.state == JobState.CANCELLING, _lease_over())
            ).all()
        for job_id in left:
            self.move(job_id, JobState.CANCELLING, JobState.CANCELLED)

    def move(
        self, job_id: str, expected: JobState, state: JobState, *, owner: str | None = None, **values: Any
    ) -> bool:
        """Change a state from the expected one; False where it was another, or the job is not `owner`'s (if given)."""
        if state not in _HELD:
            values |= {"lease_owner": None, "lease_until": None}
        if state.final:
            values["finished"] = _now()
        if state in (JobState.FAILED, JobState.CANCELLED):
            values["answering"] = None
        change = update(JobRecord).where(JobRecord.id == job_id, JobRecord.state == expected)
        if owner is not None:
            change = change.where(JobRecord.lease_owner == owner)
        with self._sessions() as session:
            done = bool(session.execute(change.values(state=state, **values)).rowcount == 1)  # type: ignore[attr-defined]
            if done:
                note_event(session, job_id, state, error=values.get("error"))
            session.commit()
        return done

    def record_progress(self, job_id: str, progress: dict[str, Any], owner: str) -> None:
        """Note how far a running job is, where it is `owner`'s."""
        noted = update(JobRecord).where(JobRecord.id == job_id, JobRecord.lease_owner == owner)
        with self._sessions() as session:
            state = session.scalar(noted.values(progress=progress).returning(JobRecord.state))
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

    def give_up_store(self, job_id: str) -> str | None:
        """Part an ended job from its store; the store's name, where no other job needs it.

        Another one does that has gone on from there, or that may.
        """
        with self._sessions() as session:
            _one_at_a_time(session)
            store = session.scalar(select(JobRecord.store).where(JobRecord.id == job_id))
            ours = JobRecord.id == job_id, JobRecord.state.not_in(LIVE)
            session.execute(update(JobRecord).where(*ours).values(store=None))
            needed = JobRecord.store == store, JobRecord.answering.is_not(None)
            others = session.scalar(select(func.count()).where(*needed))
            session.commit()
        return None if others else store

    def delete(self, job_id: str) -> None:
        """Remove the record of a job that has ended."""
        with self._sessions() as session:
            gone = delete(JobRecord).where(JobRecord.id == job_id, JobRecord.state.not_in(LIVE))
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
            with to_read(self._sessions()) as session:
                session.execute(select(1))
        except SQLAlchemyError:
            return False
        return True


def _one_at_a_time(session: Session) -> None:
    """Let no other submission count until this one is recorded; SQLite's transactions are so by themselves."""
    if session.get_bind().dialect.name == "postgresql":
        session.execute(text("SELECT pg_advisory_xact_lock(:lock)"), {"lock": _SUBMISSION_LOCK})


def _store_left(session: Session, digest: str) -> str | None:
    """Store of the last job of this digest that failed or was cancelled."""
    ended = JobRecord.digest == digest, JobRecord.store.is_not(None)
    return session.scalar(select(JobRecord.store).where(*ended).order_by(JobRecord.number.desc()).limit(1))


def _allowed(large: Whose) -> ColumnElement[bool]:
    """Jobs that there is a place for: small ones, and some of the others."""
    if large is Whose.ANYONES:
        return true()
    small = JobRecord.places.between(1, SMALL_PLACES)
    return or_(small, _running_of(JobRecord.submitter) == 0) if large is Whose.NEWCOMERS else small


def _running_of(submitter: Any) -> Any:
    """Query for how many jobs of a submitter run."""
    other = aliased(JobRecord)
    held = other.state.in_(_HELD), other.lease_until >= database_time()
    return select(func.count(other.number)).where(other.submitter == submitter, *held).scalar_subquery()


def _next_in_turn(free: ColumnElement[bool]) -> Any:
    """Query for the number of the job whose turn it is."""
    waiting = (
        select(JobRecord.submitter, func.min(JobRecord.number).label("number"))
        .where(free)
        .group_by(JobRecord.submitter)
        .subquery()
    )
    other = aliased(JobRecord)
    served = select(func.max(other.started)).where(other.submitter == waiting.c.submitter).scalar_subquery()
    turn = _running_of(waiting.c.submitter), served.asc().nulls_first(), waiting.c.number
    return select(waiting.c.number).order_by(*turn).limit(1)

"""Changes of job records: submission, leases, states, progress."""

import uuid
from collections.abc import Callable, Collection
from datetime import UTC, datetime, timedelta
from enum import Enum
from typing import Any

from sqlalchemy import ColumnElement, and_, bindparam, delete, func, or_, select, text, true, update
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session, aliased

from service.errors import JobNotFound, LimitExceeded, TooMuch
from service.records.engine import DatabaseError, database_time, to_read
from service.records.events import delete_events, note_event
from service.records.job_record import LIVE, SMALL_PLACES, JobRecord, JobState
from service.records.reads import Reads
from service.records.replica import is_dead
from service.settings import Quotas
from worker.jobs.job import Job

LEASE_SECONDS = 20.0
"""Time without a renewal after which a job may be taken over."""
# Ends of jobs over so long say when there is room again.
_PACE_SECONDS = 60
_HELD = (JobState.RUNNING, JobState.CANCELLING)
# Statements that run most often are built once.
_BY_ID = select(JobRecord).where(JobRecord.id == bindparam("job_id"))
_ANSWERING = select(JobRecord).where(JobRecord.answering == bindparam("digest"))
# Any number will do; every replica uses the same one.
_SUBMISSION_LOCK = 6


def _now() -> datetime:
    return datetime.now(UTC)


def _lease_over() -> ColumnElement[bool]:
    return or_(JobRecord.lease_until.is_(None), JobRecord.lease_until < database_time())


class LargeJobsOf(Enum):
    """Submitters whose large jobs may be claimed."""

    ANYONE = "anyone"
    IDLE = "submitters that have nothing running"
    NOBODY = "nobody"


class Jobs:
    """The job records.

    Guarantees. The same request gets the same job as long as that job can answer it. After a failure or a cancellation
    it gets a new job, which continues from the store of the old one. A state changes only from the expected state, and
    a final state never. A job is leased to one claim at a time; changes on behalf of any other claim have no effect.

    Parameters
    ----------
    sessions : callable
        Makes database sessions.
    quotas : Quotas
        Limits that a submission may not exceed.
    """

    def __init__(self, sessions: Callable[[], Session], quotas: Quotas) -> None:
        self._sessions, self._quotas = sessions, quotas
        self.reads = Reads(sessions)

    def submit(self, job: Job, submitter: str) -> tuple[JobRecord, bool]:
        """Record of the job that answers a request, and whether it is new. A new job belongs to `submitter`.

        Raises
        ------
        TooMuch, LimitExceeded
            If a new job would exceed a quota.
        """
        while True:
            with self._sessions() as session:
                _lock_submissions(session)
                known = session.scalar(_ANSWERING, {"digest": job.digest})
                if known is not None:
                    return known, False
                _check_quotas(self._quotas, session, submitter, job.cell_count)
                job_id = uuid.uuid4().hex
                record = JobRecord(
                    id=job_id, kind=job.kind, digest=job.digest, answering=job.digest, state=JobState.QUEUED,
                    request=job.request(), submitter=submitter, created=_now(), places=job.cell_count,
                    store=_store_left(session, job.digest) or job_id,
                )  # fmt: skip
                session.add(record)
                try:
                    session.flush()
                    note_event(session, record.id, record.state)
                    session.commit()
                except IntegrityError:
                    continue  # another replica has just recorded the same request: return that job
                return record, True

    def leave_store(self, job: Job) -> str:
        """Record that a store is there whose job was cancelled: the next job of its request goes on from it.

        Parameters
        ----------
        job : Job

        Returns
        -------
        str
            Name of the store, at which it has to be before that job is submitted.
        """
        with self._sessions() as session:
            name = uuid.uuid4().hex
            session.add(
                JobRecord(
                    id=name, kind=job.kind, digest=job.digest, state=JobState.CANCELLED, request=job.request(),
                    submitter="local", created=_now(), places=job.cell_count, store=name,
                )
            )  # fmt: skip
            session.commit()
        return name

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

    def answering(self, job: Job) -> JobRecord | None:
        """Record of the job that answers a request, if there is one."""
        with to_read(self._sessions()) as session:
            return session.scalar(_ANSWERING, {"digest": job.digest})

    def page(self, before: int | None, size: int, state: JobState | None) -> list[JobRecord]:
        """Up to `size` records, newest first; optionally older than number `before` or in one state."""
        query = select(JobRecord).order_by(JobRecord.number.desc()).limit(size)
        if before is not None:
            query = query.where(JobRecord.number < before)
        if state is not None:
            query = query.where(JobRecord.state == state)
        with to_read(self._sessions()) as session:
            return list(session.scalars(query))

    def claim(
        self, owner: str, *, exclude: Collection[str] = (), large: LargeJobsOf = LargeJobsOf.ANYONE
    ) -> JobRecord | None:
        """Claim a job that is queued or whose lease has run out, and set it running. None if there is no such job.

        Submitters with the fewest running jobs come first, and among those the one served longest ago. Its oldest job
        is claimed.

        Parameters
        ----------
        owner : str
            Unique name of the claim.
        exclude : collection of str
            Jobs not to claim.
        large : LargeJobsOf
            Submitters whose large jobs may be claimed.
        """
        free = and_(
            or_(JobRecord.state == JobState.QUEUED, and_(JobRecord.state == JobState.RUNNING, _lease_over())),
            JobRecord.id.not_in(exclude),
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
        """Renew the leases of some claims, and return the states of the jobs whose claims still hold, by claim."""
        held = JobRecord.lease_owner.in_(owners), JobRecord.state.in_(_HELD)
        with self._sessions() as session:
            session.execute(update(JobRecord).where(*held).values(lease_until=database_time() + LEASE_SECONDS))
            session.commit()
            rows = session.execute(select(JobRecord.lease_owner, JobRecord.state).where(*held)).all()
        return {str(owner): state for owner, state in rows}

    def end_dead_leases(self) -> None:
        """End the leases of replicas known to be dead, and complete cancellations that have no owner left."""
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
            self.transition(job_id, JobState.CANCELLING, JobState.CANCELLED)

    def transition(
        self, job_id: str, expected: JobState, state: JobState, *, owner: str | None = None, **values: Any
    ) -> bool:
        """Change a state from the expected one. False if it was another one, or if `owner` is not the job's."""
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
        """Record the progress of a running job, if `owner` owns it."""
        change = update(JobRecord).where(JobRecord.id == job_id, JobRecord.lease_owner == owner)
        with self._sessions() as session:
            state = session.scalar(change.values(progress=progress).returning(JobRecord.state))
            if state is not None and not state.final:
                note_event(session, job_id, state, progress)
            session.commit()

    def request_cancel(self, job_id: str) -> JobRecord:
        """Cancel a queued job at once, or mark a running one to be stopped; a job that has ended is not changed."""
        for _ in range(3):  # the state may change meanwhile, twice at most
            record = self.get(job_id)
            if record.state == JobState.QUEUED and not self.transition(job_id, JobState.QUEUED, JobState.CANCELLED):
                continue
            if record.state == JobState.RUNNING and not self.transition(job_id, JobState.RUNNING, JobState.CANCELLING):
                continue
            break
        return self.get(job_id)

    def disown_result(self, job_id: str) -> None:
        """Let a job that has succeeded answer no more requests, because its result is gone."""
        change = update(JobRecord).where(JobRecord.id == job_id, JobRecord.state == JobState.SUCCEEDED)
        with self._sessions() as session:
            session.execute(change.values(answering=None))
            session.commit()

    def release_store(self, job_id: str) -> str | None:
        """Detach an ended job from its store, and return the store's name if no other job needs it.

        A job that continued from the store needs it.
        """
        with self._sessions() as session:
            _lock_submissions(session)
            store = session.scalar(select(JobRecord.store).where(JobRecord.id == job_id))
            own = JobRecord.id == job_id, JobRecord.state.not_in(LIVE)
            session.execute(update(JobRecord).where(*own).values(store=None))
            needed = JobRecord.store == store, JobRecord.answering.is_not(None)
            others = session.scalar(select(func.count()).where(*needed))
            session.commit()
        return None if others else store

    def delete(self, job_id: str) -> None:
        """Delete the record of a job that has ended."""
        with self._sessions() as session:
            deletion = delete(JobRecord).where(JobRecord.id == job_id, JobRecord.state.not_in(LIVE))
            if session.execute(deletion).rowcount == 1:  # type: ignore[attr-defined]
                delete_events(session, job_id)
            session.commit()

    def count(self) -> dict[JobState, int]:
        """Number of jobs in each state."""
        with self._sessions() as session:
            counts = select(JobRecord.state, func.count()).group_by(JobRecord.state)
            return dict(session.execute(counts).all())

    def answers(self) -> bool:
        """Whether the database answers."""
        try:
            with to_read(self._sessions()) as session:
                session.execute(select(1))
        except DatabaseError:
            return False
        return True


def _check_quotas(quotas: Quotas, session: Session, submitter: str, places: int) -> None:
    """Refuse a job that would exceed a quota, in the transaction that would record it.

    Raises
    ------
    TooMuch
        With the name of the quota, and the time after which to try again.
    LimitExceeded
        If the job alone exceeds a quota.
    """
    if places > quotas.places_each:
        raise LimitExceeded(
            f"{places} cells or points over all basins are more than one client may have queued and running: "
            f"{quotas.places_each} (RATTLE_MAX_PLACES_EACH)"
        )
    mine = JobRecord.submitter == submitter
    queued = select(func.count()).where(JobRecord.state == JobState.QUEUED)
    under_way = select(func.coalesce(func.sum(JobRecord.places), 0)).where(JobRecord.state.in_(LIVE), mine)
    for size, most, message in (
        (session.scalar(queued) or 0, quotas.queued - 1, f"{quotas.queued} jobs are queued (RATTLE_MAX_QUEUED)"),
        (
            session.scalar(queued.where(mine)) or 0, quotas.queued_each - 1,
            f"{quotas.queued_each} jobs of {submitter} are queued (RATTLE_MAX_QUEUED_EACH)",
        ),
        (
            session.scalar(under_way) or 0, quotas.places_each - places,
            f"queued and running jobs of {submitter} would have more than {quotas.places_each} cells or points "
            "together (RATTLE_MAX_PLACES_EACH)",
        ),
    ):  # fmt: skip
        if size > most:
            seconds = _seconds_to_the_next_end(session)
            raise TooMuch(f"{message}: try again in {seconds} s", seconds)


def _seconds_to_the_next_end(session: Session) -> int:
    """Mean time between ends of jobs over the last minute; a minute if none has ended in it."""
    since = datetime.now(UTC) - timedelta(seconds=_PACE_SECONDS)
    ended = session.scalar(select(func.count()).where(JobRecord.finished >= since)) or 0
    return max(1, round(_PACE_SECONDS / max(1, ended)))


def _lock_submissions(session: Session) -> None:
    """Hold off other submissions until this one is recorded. In SQLite every transaction does that by itself."""
    if session.get_bind().dialect.name == "postgresql":
        session.execute(text("SELECT pg_advisory_xact_lock(:lock)"), {"lock": _SUBMISSION_LOCK})


def _store_left(session: Session, digest: str) -> str | None:
    """Store of the last job with this digest that failed or was cancelled."""
    ended = JobRecord.digest == digest, JobRecord.store.is_not(None)
    return session.scalar(select(JobRecord.store).where(*ended).order_by(JobRecord.number.desc()).limit(1))


def _allowed(large: LargeJobsOf) -> ColumnElement[bool]:
    """Condition for jobs that have a slot: small ones, and some of the large ones."""
    if large is LargeJobsOf.ANYONE:
        return true()
    small = JobRecord.places.between(1, SMALL_PLACES)
    return or_(small, _running_of(JobRecord.submitter) == 0) if large is LargeJobsOf.IDLE else small


def _running_of(submitter: Any) -> Any:
    """Query for the number of running jobs of a submitter."""
    other = aliased(JobRecord)
    held = other.state.in_(_HELD), other.lease_until >= database_time()
    return select(func.count(other.number)).where(other.submitter == submitter, *held).scalar_subquery()


def _next_in_turn(free: ColumnElement[bool]) -> Any:
    """Query for the number of the next job in turn."""
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

"""Quotas on queued and running work, of all clients together and of each."""

from datetime import UTC, datetime, timedelta

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from service.errors import LimitExceeded, TooMuch
from service.records.job_record import LIVE, JobRecord, JobState
from service.settings import Quotas

_PACE_SECONDS = 60


def check_quotas(quotas: Quotas, session: Session, submitter: str, places: int) -> None:
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

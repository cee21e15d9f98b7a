"""How much may wait and be under way, of all submitters and of each: what is more is refused until there is room."""

from datetime import UTC, datetime, timedelta

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from service.errors import LimitExceeded, TooMuch
from service.records.job_record import LIVE, JobRecord, JobState
from service.settings import Quotas

_PACE_SECONDS = 60


def check_quotas(quotas: Quotas, session: Session, submitter: str, places: int) -> None:
    """Refuse one more job where it would exceed a quota; in the transaction that records it.

    Raises
    ------
    TooMuch
        Naming the quota, and when there may be room.
    LimitExceeded
        Where the job alone exceeds a quota, so that there never will be.
    """
    if places > quotas.places_each:
        raise LimitExceeded(
            f"{places} cells or points of all basins are more than one submitter may have under way: "
            f"{quotas.places_each} (RATTLE_MAX_PLACES_EACH)"
        )
    mine = JobRecord.submitter == submitter
    queued = select(func.count()).where(JobRecord.state == JobState.QUEUED)
    under_way = select(func.coalesce(func.sum(JobRecord.places), 0)).where(JobRecord.state.in_(LIVE), mine)
    for size, most, told in (
        (session.scalar(queued) or 0, quotas.queued - 1, f"{quotas.queued} jobs wait (RATTLE_MAX_QUEUED)"),
        (
            session.scalar(queued.where(mine)) or 0, quotas.queued_each - 1,
            f"{quotas.queued_each} jobs of {submitter} wait (RATTLE_MAX_QUEUED_EACH)",
        ),
        (
            session.scalar(under_way) or 0, quotas.places_each - places,
            f"jobs of {submitter} under way would compute more than {quotas.places_each} cells or points together "
            "(RATTLE_MAX_PLACES_EACH)",
        ),
    ):  # fmt: skip
        if size > most:
            seconds = _seconds_to_the_next_end(session)
            raise TooMuch(f"{told}: ask again in {seconds} s", seconds)


def _seconds_to_the_next_end(session: Session) -> int:
    """How long a job takes to end at the pace of the last minute; a minute where none has ended in it."""
    since = datetime.now(UTC) - timedelta(seconds=_PACE_SECONDS)
    ended = session.scalar(select(func.count()).where(JobRecord.finished >= since)) or 0
    return max(1, round(_PACE_SECONDS / max(1, ended)))

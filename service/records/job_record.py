"""Job records: the one truth about a job's life.

    queued --> running --> succeeded | failed
       |          |
       |          +--> cancelling --> cancelled
       +--> cancelled

A running job goes back to queued when the service stops under it, or the cluster is lost, and is resumed from its
store. The last three states never change again. Every change of state is a compare-and-swap in the database.

A job that runs is leased to the replica of the service that runs it, and stays so while that replica says in time that
it lives. A job whose lease has run out is taken over by any replica; the one that lost it can change nothing of it any
more.
"""

from datetime import datetime
from enum import StrEnum
from typing import Any

from sqlalchemy import JSON, BigInteger, DateTime, Enum, Float, Index, String, text
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column


class JobState(StrEnum):
    """State of a job."""

    QUEUED = "queued"
    RUNNING = "running"
    CANCELLING = "cancelling"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELLED = "cancelled"

    @property
    def final(self) -> bool:
        """Whether the state never changes again."""
        return self in (JobState.SUCCEEDED, JobState.FAILED, JobState.CANCELLED)


SMALL_PLACES = 250_000
"""A basin or sweep of up to so many cells or points is small: it waits for no place that large ones have taken."""
LIVE = (JobState.QUEUED, JobState.RUNNING, JobState.CANCELLING)
"""States that are not final."""


class Base(DeclarativeBase):
    """Tables of the service."""


class JobRecord(Base):
    """One job."""

    __tablename__ = "jobs"
    __table_args__ = (
        Index("ix_jobs_waiting", "state", "submitter", "number"),
        Index("ix_jobs_served", "submitter", "started"),
    )

    number: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    id: Mapped[str] = mapped_column(String(32), unique=True)
    kind: Mapped[str] = mapped_column(String(16))
    digest: Mapped[str] = mapped_column(String(64), index=True)
    # The digest while the job can still answer a request, NULL once it has failed or was cancelled: unique, so that the
    # same request is the same job, whoever sends it at whatever moment.
    answering: Mapped[str | None] = mapped_column(String(64), unique=True)
    state: Mapped[JobState] = mapped_column(
        Enum(JobState, native_enum=False, length=16, values_callable=lambda states: [state.value for state in states]),
        index=True,
    )
    request: Mapped[dict[str, Any]] = mapped_column(JSON)
    progress: Mapped[dict[str, Any] | None] = mapped_column(JSON)
    error: Mapped[dict[str, Any] | None] = mapped_column(JSON)
    # Who asked first: the name of a key, or "local" where the doors are open.
    submitter: Mapped[str] = mapped_column(String(64), index=True)
    created: Mapped[datetime] = mapped_column(DateTime(timezone=True))
    started: Mapped[datetime | None] = mapped_column(DateTime(timezone=True))
    finished: Mapped[datetime | None] = mapped_column(DateTime(timezone=True), index=True)
    # Which claim of which replica runs the job, and until when by the database's clock, in seconds since 1970.
    lease_owner: Mapped[str | None] = mapped_column(String(64))
    lease_until: Mapped[float | None] = mapped_column(Float)
    # Cells or points that it computes, which quotas count.
    places: Mapped[int] = mapped_column(BigInteger, server_default="0")
    # Counts its changes, whatever makes them: who has seen this one has seen all that stands here.
    revision: Mapped[int] = mapped_column(default=0, server_default="0", onupdate=text("revision + 1"))
    # Name of its result's store: its own id, or that of the failed or cancelled job whose result it goes on from; NULL
    # while it is being deleted.
    store: Mapped[str | None] = mapped_column(String(32), index=True)

    @property
    def small(self) -> bool:
        """Whether it is over soon; of analyses, which have no places, nobody knows."""
        return 1 <= self.places <= SMALL_PLACES

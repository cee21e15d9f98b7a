"""Job records: the state of each job, and everything known about it.

    queued --> running --> succeeded | failed
       |          |
       |          +--> cancelling --> cancelled
       +--> cancelled

A running job goes back to queued when the service stops or the cluster is lost, and later resumes from its store. The
last three states are final. Every change of state is a compare-and-swap in the database.

A running job is leased to the replica of the service that runs it. The replica renews the lease as long as it lives.
Any replica may take over a job whose lease has run out. The former owner can then no longer change it.
"""

from datetime import datetime
from enum import StrEnum
from typing import Any

from sqlalchemy import JSON, BigInteger, DateTime, Enum, Float, Index, String
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
        """Whether the state can no longer change."""
        return self in (JobState.SUCCEEDED, JobState.FAILED, JobState.CANCELLED)


SMALL_PLACES = 250_000
"""Most cells or points of a small job. Small jobs need not wait for slots that large ones occupy."""
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
    # The digest while the job can answer a request, NULL once it has failed or was cancelled. It is unique: the same
    # request gets the same job, no matter who sends it or when.
    answering: Mapped[str | None] = mapped_column(String(64), unique=True)
    state: Mapped[JobState] = mapped_column(
        Enum(JobState, native_enum=False, length=16, values_callable=lambda states: [state.value for state in states]),
        index=True,
    )
    request: Mapped[dict[str, Any]] = mapped_column(JSON)
    progress: Mapped[dict[str, Any] | None] = mapped_column(JSON)
    error: Mapped[dict[str, Any] | None] = mapped_column(JSON)
    # The first submitter: the name of a key, or "local" if no keys are required.
    submitter: Mapped[str] = mapped_column(String(64), index=True)
    created: Mapped[datetime] = mapped_column(DateTime(timezone=True))
    started: Mapped[datetime | None] = mapped_column(DateTime(timezone=True))
    finished: Mapped[datetime | None] = mapped_column(DateTime(timezone=True), index=True)
    # The claim under which the job runs, and the end of its lease: seconds since 1970 by the database's clock.
    lease_owner: Mapped[str | None] = mapped_column(String(64))
    lease_until: Mapped[float | None] = mapped_column(Float)
    # Cells or points to compute, which quotas count.
    places: Mapped[int] = mapped_column(BigInteger, server_default="0")
    # Name of the store of its result: its own id, or that of the failed or cancelled job that it continues; NULL while
    # it is being deleted.
    store: Mapped[str | None] = mapped_column(String(32), index=True)

    @property
    def small(self) -> bool:
        """Whether the job is short. Analyses have no cells, so this is unknown: they count as large."""
        return 1 <= self.places <= SMALL_PLACES

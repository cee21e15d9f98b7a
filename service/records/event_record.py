"""Numbered events of each job, which its event stream replays."""

from datetime import datetime
from typing import Any

from sqlalchemy import JSON, DateTime, Enum, String
from sqlalchemy.orm import Mapped, mapped_column

from service.records.job_record import Base, JobState


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

"""What has happened to each job, numbered: what its stream of events replays."""

from datetime import datetime
from typing import Any

from sqlalchemy import JSON, DateTime, Enum, String
from sqlalchemy.orm import Mapped, mapped_column

from service.records.job_record import Base, JobState


class EventRecord(Base):
    """One event of a job: it has changed its state, or it is further than before.

    Numbers rise by one from event to event of a job. All changes of state are kept as long as the job; of its progress
    what is recent, and nothing once it has ended. So the table has a few rows a job, and some dozens for one that runs.
    """

    __tablename__ = "events"

    job_id: Mapped[str] = mapped_column(String(32), primary_key=True)
    sequence: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    state: Mapped[JobState] = mapped_column(
        Enum(JobState, native_enum=False, length=16, values_callable=lambda states: [state.value for state in states])
    )
    # Set where the event is that the job is further.
    progress: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True))
    # Set where the state is failed.
    error: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True))
    moment: Mapped[datetime] = mapped_column(DateTime(timezone=True))

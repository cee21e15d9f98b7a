"""Events of a job over HTTP."""

from pydantic import BaseModel, Field

from service.models.progress import ErrorView, Moment, ProgressView
from service.records.events import EventRecord
from service.records.job_record import JobState


class EventView(BaseModel):
    """An event of a job: a change of state, or progress."""

    state: JobState
    at: Moment
    progress: ProgressView | None = Field(description="Set where the event is called progress")
    error: ErrorView | None = Field(description="Set where the state is failed")

    @classmethod
    def from_record(cls, record: EventRecord) -> "EventView":
        """View of an event record."""
        return cls(
            state=record.state, at=record.moment,
            progress=ProgressView(**record.progress) if record.progress else None,
            error=ErrorView(**record.error) if record.error else None,
        )  # fmt: skip

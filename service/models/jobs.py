"""Jobs over HTTP: their state, progress, events and links."""

from datetime import UTC, datetime
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import AfterValidator, BaseModel, Field

from service.models.requests import request_of_any_kind
from service.records.events import EventRecord
from service.records.job_record import JobRecord, JobState
from worker.kinds import KINDS
from worker.progress import Stage

if TYPE_CHECKING:
    AnyRequest = dict[str, Any]
else:
    AnyRequest = request_of_any_kind()

# SQLite stores no time zone. A time without one is in UTC, as all times in the database are.
Moment = Annotated[datetime, AfterValidator(lambda moment: moment if moment.tzinfo else moment.replace(tzinfo=UTC))]


class BasinProgressView(BaseModel):
    """Progress of one basin of a sweep."""

    basin: int = Field(description="Its number: the last swept parameter runs fastest")
    stage: Stage
    tiles_done: int
    tiles_total: int


class ProgressView(BaseModel):
    """Progress of a job. Counts are those of the stage; for a sweep, those of its complete basins."""

    stage: Stage
    tiles_done: int = Field(description="Tiles of basins, or pieces of an analysis")
    tiles_total: int
    cells_done: int
    cells_total: int
    cells_per_second: float
    seconds_left: float | None = Field(description="Estimate for this stage, null until there is one")
    basins_done: int = Field(0, description="Basins of a sweep that are complete")
    basins_total: int = Field(1, description="Basins of the job: 1 if nothing is swept, 0 for an analysis")
    under_way: tuple[BasinProgressView, ...] = Field(
        (), description="Basins of a sweep that have begun and are not complete"
    )


class ErrorView(BaseModel):
    """Why a job failed."""

    kind: str
    detail: str


class Links(BaseModel):
    """Addresses that belong to a job."""

    self: str
    cancel: str
    events: str
    result: str
    zarr: str
    picture: str
    shares: str | None = Field(None, description="Chart of shares over the swept parameters; sweeps only")


class JobView(BaseModel):
    """A job."""

    id: str
    kind: Annotated[str, Field(json_schema_extra={"enum": list(KINDS)})]
    state: JobState
    request: AnyRequest
    created: Moment
    started: Moment | None
    finished: Moment | None
    progress: ProgressView | None = Field(description="null until the job has started")
    error: ErrorView | None = Field(description="Set where the state is failed")
    links: Links

    @classmethod
    def from_record(cls, record: JobRecord) -> "JobView":
        """View of a job record."""
        here = f"/v1/jobs/{record.id}"
        return cls(
            id=record.id, kind=record.kind, state=record.state, request=record.request,
            created=record.created, started=record.started, finished=record.finished,
            progress=ProgressView(**record.progress) if record.progress else None,
            error=ErrorView(**record.error) if record.error else None,
            links=Links(
                self=here, cancel=f"{here}/cancel", events=f"{here}/events", result=f"{here}/result",
                zarr=f"{here}/result.zarr", picture=f"{here}/picture.png",
                shares=f"{here}/shares.png" if record.kind == "sweep" else None,
            ),
        )  # fmt: skip


class JobPage(BaseModel):
    """Some jobs, newest first."""

    jobs: list[JobView]
    next: str | None = Field(description="Link to the next page, null on the last")


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

"""Jobs over HTTP."""

from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BaseModel, Field

from service.models.described import request_of_any_kind
from service.models.progress import ErrorView, Moment, ProgressView
from service.records.job_record import JobRecord, JobState
from worker.kinds import KINDS

if TYPE_CHECKING:
    AnyRequest = dict[str, Any]
else:
    AnyRequest = request_of_any_kind()


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

"""Progress of jobs over HTTP."""

from datetime import UTC, datetime
from typing import Annotated

from pydantic import AfterValidator, BaseModel, Field

from worker.progress import Stage

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

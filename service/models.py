"""Shapes of requests and responses over HTTP, built to and from the worker's objects."""

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from rattle_kernels import Attractor, CellGrid, Oscillator
from service.job_record import JobRecord, JobState
from worker.basin_job import BasinJob
from worker.results import BasinSummary

# Strict: JSON's true is no number. Integers are welcome where a real number is asked for.
Real = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Count = Annotated[int, Field(strict=True, ge=1)]


class Request(BaseModel):
    """A request: unknown fields are refused, so that a typing error is not taken for a default."""

    model_config = ConfigDict(extra="forbid")


class OscillatorRequest(Request):
    """Parameters of the gear pair, nondimensional; the paper's by default."""

    model: Literal["impacting"] = Field("impacting", description="Model of contact: elastic impacts (Eqs. 4, 5)")
    damping: Real = Field(0.6, gt=0, description="delta")
    eccentricity: Real = Field(0.1, ge=0, description="epsilon, below the bound of Eq. (8)")
    half_backlash: Real = Field(0.6, gt=0, description="beta")


class TimeWindow(Request):
    """Cells along time, in forcing periods; the window may cross phase 0 (from 0.9 to 1.1)."""

    start: Real = Field(0.0, ge=0, lt=1)
    stop: Real = Field(1.0, gt=0, le=2)
    cells: Count = 1000


class VelocityWindow(Request):
    """Cells along velocity, nondimensional."""

    start: Real = Field(0.0, ge=0)
    stop: Real = Field(7.0, gt=0)
    cells: Count = 1000


class GridRequest(Request):
    """Window of the (t, v) plane, cut into equal cells."""

    time: TimeWindow = Field(default_factory=TimeWindow)
    velocity: VelocityWindow = Field(default_factory=VelocityWindow)


class BasinRequest(Request):
    """One basin of attraction."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [
                {
                    "oscillator": {"model": "impacting", "damping": 0.6, "eccentricity": 0.1, "half_backlash": 0.6},
                    "grid": {
                        "time": {"start": 0, "stop": 1, "cells": 1000},
                        "velocity": {"start": 0, "stop": 7, "cells": 1000},
                    },
                    "iterations": 1499,
                }
            ]
        },
    )

    oscillator: OscillatorRequest = Field(default_factory=OscillatorRequest)
    grid: GridRequest = Field(default_factory=GridRequest)
    iterations: Count = Field(1499, description="k of P_corr o P^k: 1 or a prime")

    def to_job(self) -> BasinJob:
        """Job that this asks for.

        Raises
        ------
        OutsideDomain, InvalidJob
            Saying what is wrong.
        """
        parameters = self.oscillator.model_dump(exclude={"model"})
        time, velocity = self.grid.time, self.grid.velocity
        grid = CellGrid(time.start, time.stop, time.cells, velocity.start, velocity.stop, velocity.cells)
        return BasinJob(Oscillator(**parameters), grid, self.iterations)


class ProgressView(BaseModel):
    """How far a job is; counts are those of the stage."""

    stage: Literal["mapping", "assembling", "labelling", "done"]
    tiles_done: int
    tiles_total: int
    cells_done: int
    cells_total: int
    cells_per_second: float
    seconds_left: float | None = Field(description="Estimate for this stage, null until there is one")
    basins_done: int = Field(0, description="Basins of a sweep that are complete")
    basins_total: int = Field(1, description="Basins of the job: one where nothing is swept")


class ErrorView(BaseModel):
    """Why a job failed."""

    kind: str
    detail: str


class Links(BaseModel):
    """Where to go from a job."""

    self: str
    cancel: str
    result: str
    zarr: str
    picture: str


class JobView(BaseModel):
    """A job."""

    id: str
    kind: Literal["basin"]
    state: JobState
    request: BasinRequest
    created: datetime
    started: datetime | None
    finished: datetime | None
    progress: ProgressView | None = Field(description="null until the job has started")
    error: ErrorView | None = Field(description="Set where the state is failed")
    links: Links

    @classmethod
    def from_record(cls, record: JobRecord) -> "JobView":
        """View of a job record."""
        here = f"/v1/jobs/{record.id}"
        return cls(
            id=record.id, kind="basin", state=record.state, request=BasinRequest.model_validate(record.request),
            created=record.created, started=record.started, finished=record.finished,
            progress=ProgressView(**record.progress) if record.progress else None,
            error=ErrorView(**record.error) if record.error else None,
            links=Links(
                self=here, cancel=f"{here}/cancel", result=f"{here}/result", zarr=f"{here}/result.zarr",
                picture=f"{here}/picture.png",
            ),
        )  # fmt: skip


class JobPage(BaseModel):
    """Some jobs, newest first."""

    jobs: list[JobView]
    next: str | None = Field(description="Link to the next page, null on the last")


class SolutionView(BaseModel):
    """One motion and its share of the cells."""

    name: str = Field(examples=["P(1,1,0)"])
    kind: Literal["periodic", "chaotic", "permanent_contact", "undecided"]
    share: float | None = Field(description="Part of the cells that end in it; null until every tile is labelled")
    forcing_periods: int
    upper_contacts: int
    lower_contacts: int
    lyapunov_exponent: float | None = Field(description="Per forcing period")
    points: list[tuple[float, float]] = Field(
        description="(t, v) of its departures; the first hundred of a chaotic one"
    )

    @classmethod
    def from_attractor(cls, attractor: Attractor, share: float) -> "SolutionView":
        """View of an attractor."""
        points = zip(attractor.time[:100].tolist(), attractor.velocity[:100].tolist(), strict=True)
        exponent = attractor.lyapunov_exponent
        return cls(
            name=attractor.name, kind=attractor.kind.name.lower(), share=share if share == share else None,
            forcing_periods=attractor.forcing_periods, upper_contacts=attractor.upper_contacts,
            lower_contacts=attractor.lower_contacts, lyapunov_exponent=exponent if exponent == exponent else None,
            points=list(points),
        )  # fmt: skip


class ResultView(BaseModel):
    """Summary of a basin; a result that is not complete says so."""

    complete: bool
    request: dict[str, Any]
    tiles: int
    tiles_computed: int
    tiles_assembled: int
    solutions: list[SolutionView]
    image_counts: dict[str, int] = Field(description="Cells with each reserved image; empty until all are mapped")
    seconds: dict[str, float] = Field(
        description="Wall time of each stage, and the kernels' own time summed over tiles"
    )
    zarr: str

    @classmethod
    def from_summary(cls, summary: BasinSummary, zarr: str) -> "ResultView":
        """View of a summary."""
        solutions = [
            SolutionView.from_attractor(attractor, share)
            for attractor, share in zip(summary.attractors, summary.shares, strict=True)
        ]
        return cls(
            complete=summary.complete, request=summary.request, tiles=summary.tiles,
            tiles_computed=summary.tiles_computed, tiles_assembled=summary.tiles_assembled, solutions=solutions,
            image_counts=summary.image_counts, seconds=summary.seconds, zarr=zarr,
        )  # fmt: skip


class FieldError(BaseModel):
    """One field at fault."""

    location: list[str | int] = Field(examples=[["body", "oscillator", "damping"]])
    message: str


class Problem(BaseModel):
    """An error, as RFC 9457 has it (application/problem+json)."""

    type: str = Field(examples=["/problems/invalid-request"])
    title: str
    status: int
    detail: str
    instance: str
    errors: list[FieldError] = []

"""Shapes of requests and responses over HTTP, built to and from the worker's objects."""

import dataclasses
import math
from datetime import UTC, datetime
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from rattle_kernels import Attractor, CellGrid, expected_applications, settled_iterations
from service.models.analysis_requests import ANALYSIS_REQUESTS, AnalysisKind, AnalysisRequest
from service.models.oscillator import ImpactingOscillator, OscillatorRequest, demand_quiet
from service.models.vary import VaryRequest
from service.records.event_record import EventRecord
from service.records.job_record import JobRecord, JobState
from service.strict import Count, Real, Request
from worker.errors import InvalidJob
from worker.jobs.basin_job import SETTLED, BasinJob
from worker.jobs.oscillator_request import PIECEWISE_LINEAR
from worker.jobs.sample import Sample
from worker.jobs.swept_parameter import MOST_SWEPT, SweptParameter
from worker.progress import Stage
from worker.stores.summary import BasinSummary, Change, SweptBasinSummary

# SQLite keeps no time zone: what comes from there without one is in UTC, as all moments are.
Moment = Annotated[datetime, AfterValidator(lambda moment: moment if moment.tzinfo else moment.replace(tzinfo=UTC))]


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


class SampleRequest(Request):
    """Points of the window to start from in place of a grid of cells: a scrambled Sobol sequence."""

    points: Count
    seed: Annotated[int, Field(strict=True, ge=0)] = Field(0, description="The same seed gives the same points")


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

    oscillator: OscillatorRequest = Field(default_factory=ImpactingOscillator)
    grid: GridRequest = Field(default_factory=GridRequest)
    iterations: Count | None = Field(
        None,
        description="k of P_corr o P^k: 1 or a prime. By default 1499 where the least damping is 0.5 or more, else the "
        "first prime from 900/damping",
    )

    sample: SampleRequest | None = Field(None, description="Points in place of cells; leave out `cells` then")

    def sizes(self) -> tuple[tuple[str, float, str], ...]:
        """What is large about the request: in words, how large, and the setting that bounds it."""
        # Where damping is weak no cell takes all of them. No float holds any integer.
        each = expected_applications(self.least_damping, min(self.k, 10**18))
        applications = round(self.places * each)
        return (
            ("cells or points", self.places, "max_cells"),
            ("iterations", self.k, "max_iterations"),
            ("cells times iterations", applications, "max_applications"),
            ("basins", self.basins, "max_basins"),
            ("cells times iterations of all basins", self.basins * applications, "max_sweep_applications"),
        )

    @property
    def basins(self) -> int:
        """Number of basins."""
        return 1

    @property
    def places(self) -> int:
        """Cells of the grid, or points of the sample."""
        return self.sample.points if self.sample else self.grid.time.cells * self.grid.velocity.cells

    @property
    def least_damping(self) -> float:
        """The damping, of a sweep the least one."""
        return self.oscillator.damping

    @property
    def k(self) -> int:
        """k, or the one of the damping where none is asked for."""
        return self.iterations or settled_iterations(self.least_damping)

    def to_job(self) -> BasinJob:
        """Job that this asks for.

        Raises
        ------
        OutsideDomain, InvalidJob
            Saying what is wrong.
        """
        time, velocity = self.grid.time, self.grid.velocity
        for name, window in (("time", time), ("velocity", velocity)):
            if self.sample and "cells" in window.model_fields_set:
                raise InvalidJob(f"a sample has no cells: leave out grid.{name}.cells", ("grid", name, "cells"))
        grid = CellGrid(time.start, time.stop, time.cells, velocity.start, velocity.stop, velocity.cells)
        sample = Sample(self.sample.points, self.sample.seed) if self.sample else None
        job = BasinJob(self.oscillator.to_oscillator(), grid, self.iterations or SETTLED, self._vary(), sample)
        demand_quiet(job.demand_quiet, unless=self.oscillator.allow_no_quiet_solution)
        return job

    def _vary(self) -> tuple[SweptParameter, ...]:
        return ()


class SweepRequest(BasinRequest):
    """Basins over one or two parameters, each combination of their values one basin."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [
                {
                    "oscillator": {"model": "impacting", "eccentricity": 0.1, "half_backlash": 0.6},
                    "vary": [{"parameter": "damping", "start": 0.5, "stop": 0.7, "count": 21}],
                    "grid": {"time": {"cells": 200}, "velocity": {"cells": 200}},
                }
            ]
        },
    )

    vary: Annotated[list[VaryRequest], Field(min_length=1, max_length=MOST_SWEPT)] = Field(
        description="Swept parameters; the last one runs fastest"
    )

    @model_validator(mode="before")
    @classmethod
    def _swept_stiffness_needs_no_other(cls, value: Any) -> Any:
        """Give a swept stiffness, where none stands beside it, a value that the first of the sweep then replaces."""
        oscillator = value.get("oscillator") if isinstance(value, dict) else None
        vary = value.get("vary") if isinstance(value, dict) else None
        if not isinstance(oscillator, dict) or not isinstance(vary, list):
            return value
        swept = any(isinstance(each, dict) and each.get("parameter") == "stiffness" for each in vary)
        if swept and oscillator.get("model") == PIECEWISE_LINEAR and "stiffness" not in oscillator:
            return value | {"oscillator": oscillator | {"stiffness": 1.0}}
        return value

    @property
    def basins(self) -> int:
        """Number of basins."""
        return math.prod(each.size for each in self.vary)

    @property
    def least_damping(self) -> float:
        """The least damping."""
        dampings = [each.least for each in self.vary if each.parameter == "damping"]
        return min(dampings, default=self.oscillator.damping)

    def _vary(self) -> tuple[SweptParameter, ...]:
        return tuple(each.to_swept(("vary", axis)) for axis, each in enumerate(self.vary))


class BasinProgressView(BaseModel):
    """How far one basin of a sweep is."""

    basin: int = Field(description="Its number: the last swept parameter runs fastest")
    stage: Stage
    tiles_done: int
    tiles_total: int


class ProgressView(BaseModel):
    """How far a job is; counts are those of the stage, of a sweep those of its complete basins."""

    stage: Stage
    tiles_done: int = Field(description="Tiles of basins; pieces of what has no tiles")
    tiles_total: int
    cells_done: int
    cells_total: int
    cells_per_second: float
    seconds_left: float | None = Field(description="Estimate for this stage, null until there is one")
    basins_done: int = Field(0, description="Basins of a sweep that are complete")
    basins_total: int = Field(1, description="Basins of the job: one where nothing is swept, none of an analysis")
    under_way: tuple[BasinProgressView, ...] = Field(
        (), description="Basins of a sweep that are begun and not complete"
    )


class ErrorView(BaseModel):
    """Why a job failed."""

    kind: str
    detail: str


class Links(BaseModel):
    """Where to go from a job."""

    self: str
    cancel: str
    events: str
    result: str
    zarr: str
    picture: str
    shares: str | None = Field(None, description="Chart of shares over the swept parameters, of sweeps")


class JobView(BaseModel):
    """A job."""

    id: str
    kind: Literal["basin", "sweep"] | AnalysisKind
    state: JobState
    request: SweepRequest | BasinRequest | AnalysisRequest
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
        models: dict[str, type[Request]] = {"sweep": SweepRequest, "basin": BasinRequest, **ANALYSIS_REQUESTS}
        request = models[record.kind].model_validate(record.request)
        return cls(
            id=record.id, kind=record.kind, state=record.state, request=request,
            created=record.created, started=record.started, finished=record.finished,
            progress=ProgressView(**record.progress) if record.progress else None,
            error=ErrorView(**record.error) if record.error else None,
            links=Links(
                self=here, cancel=f"{here}/cancel", events=f"{here}/events", result=f"{here}/result",
                zarr=f"{here}/result.zarr", picture=f"{here}/picture.png",
                shares=f"{here}/shares.png" if record.kind == "sweep" else None,
            ),
        )  # fmt: skip


class EventView(BaseModel):
    """Something that has happened to a job: it has changed its state, or it is further than before."""

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


class JobPage(BaseModel):
    """Some jobs, newest first."""

    jobs: list[JobView]
    next: str | None = Field(description="Link to the next page, null on the last")


class SolutionView(BaseModel):
    """One motion and its share of the cells: of all basins of a sweep together, and as the first that has it has it."""

    name: str = Field(examples=["P(1,1,0)"])
    kind: Literal["periodic", "chaotic", "chaotic_transient", "permanent_contact", "undecided"]
    share: float | None = Field(description="Part of the cells that end in it; null until every tile is labelled")
    forcing_periods: int
    upper_contacts: int
    lower_contacts: int
    lyapunov_exponent: float | None = Field(description="Per forcing period")
    mean_life: float | None = Field(
        description="Of chaos that motions leave again: impacts until one does, on average; null where none was seen to"
    )
    points: list[tuple[float, float]] = Field(
        description="(t, v) of its departures; the first hundred of a chaotic one"
    )

    @classmethod
    def from_attractor(cls, attractor: Attractor, share: float) -> "SolutionView":
        """View of an attractor."""
        points = zip(attractor.time[:100].tolist(), attractor.velocity[:100].tolist(), strict=True)
        exponent, life = attractor.lyapunov_exponent, attractor.mean_life
        return cls(
            name=attractor.name, kind=attractor.kind.name.lower(), share=share if share == share else None,
            forcing_periods=attractor.forcing_periods, upper_contacts=attractor.upper_contacts,
            lower_contacts=attractor.lower_contacts, lyapunov_exponent=exponent if exponent == exponent else None,
            mean_life=life if life == life else None, points=list(points),
        )  # fmt: skip


class ShareView(BaseModel):
    """Share of a solution in one basin."""

    solution: int = Field(description="Which: index into `solutions`")
    share: float
    standard_error: float | None = Field(description="Binomial; of samples, else null")


class BasinView(BaseModel):
    """One basin of a sweep."""

    parameters: dict[str, float] = Field(description="Values of the swept parameters")
    complete: bool
    shares: list[ShareView] = Field(description="Of the solutions that it has; empty until it is complete")

    @classmethod
    def from_swept(cls, swept: SweptBasinSummary) -> "BasinView":
        """View of a panel."""
        shares = [
            ShareView(solution=number, share=share, standard_error=swept.errors.get(number))
            for number, share in swept.shares.items()
        ]
        return cls(parameters=swept.values, complete=swept.complete, shares=shares)


class ChangeView(BaseModel):
    """Birth or death of a solution between two neighbouring values of a swept parameter."""

    kind: Literal["birth", "death"]
    solution: int = Field(description="Which: index into `solutions`")
    parameter: str
    before: float
    after: float
    beside: float | None = Field(description="Value of the other swept parameter")

    @classmethod
    def from_change(cls, change: Change) -> "ChangeView":
        """View of a change."""
        return cls(**dataclasses.asdict(change) | {"kind": change.kind.name.lower()})


class ResultView(BaseModel):
    """Summary of a basin or a sweep; a result that is not complete says so."""

    complete: bool
    request: dict[str, Any]
    tiles: int
    tiles_computed: int
    tiles_assembled: int
    solutions: list[SolutionView]
    basins: list[BasinView] = Field(description="Basin by basin, the last swept parameter fastest; one without `vary`")
    changes: list[ChangeView] = Field(description="Births and deaths of solutions along the swept parameters so far")
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
            basins=[BasinView.from_swept(swept) for swept in summary.basins],
            changes=[ChangeView.from_change(change) for change in summary.changes],
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

"""Shapes of periodic orbits, branches and special points over HTTP."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from service.models.analysis import AnalysisView, OscillatorsRequest, RegionRequest, SeedRequest
from service.models.oscillator import demand_quiet
from service.models.vary import Parameter
from service.strict import Count, Real, Request
from worker.errors import InvalidJob
from worker.jobs.orbits_job import Continuation, OrbitSeed, OrbitsJob


class OrbitSeedRequest(SeedRequest):
    """A departure close to a periodic orbit."""

    period: Annotated[int, Field(strict=True)] = Field(
        1, description="Impact period: n+ of P(m, n+, n-), or a multiple of it"
    )


class ContinuationRequest(Request):
    """A parameter to follow something in."""

    parameter: Parameter
    start: Real = Field(description="Lowest value")
    stop: Real = Field(description="Highest value")
    most_points: Count = Field(2000, description="Points each way at the most")

    def to_continuation(self) -> Continuation:
        """Continuation of the worker, not checked yet."""
        return Continuation(self.parameter, self.start, self.stop, self.most_points)


class OrbitsRequest(OscillatorsRequest):
    """Periodic orbits, stable or not: those of a region, or those near seeds; on request with their branches."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [
                {
                    "kind": "orbits",
                    "oscillator": {"model": "impacting", "damping": 0.575, "eccentricity": 0.1, "half_backlash": 0.6},
                    "longest": 4,
                    "continuation": {"parameter": "damping", "start": 0.45, "stop": 0.7},
                }
            ]
        },
    )

    kind: Literal["orbits"] = "orbits"
    longest: Count = Field(4, description="Greatest n+ that is searched for")
    region: RegionRequest = Field(default_factory=RegionRequest, description="Where it is searched")
    cells: Count = Field(40, description="The search starts from the centres of so many cells each way")
    seeds: Annotated[list[OrbitSeedRequest], Field(min_length=1, max_length=1000)] | None = Field(
        None, description="Start from these alone; leave out longest, region and cells then"
    )
    continuation: ContinuationRequest | None = Field(
        None, description="Follow every orbit in a parameter, through folds, and locate special points"
    )
    curves: ContinuationRequest | None = Field(
        None, description="Follow every special point in a second parameter, too"
    )

    def sizes(self) -> tuple[tuple[str, float, str], ...]:
        """What is large about the request: in words, how large, and the setting that bounds it."""
        points = max((each.most_points for each in (self.continuation, self.curves) if each), default=0)
        return (
            ("cells times cells times longest", self.cells**2 * self.longest, "max_orbit_starts"),
            ("points each way", points, "max_branch_points"),
        )

    def to_job(self) -> OrbitsJob:
        """Job that this asks for.

        Raises
        ------
        OutsideDomain, InvalidJob
            Saying what is wrong.
        """
        for name in ("longest", "region", "cells"):
            if self.seeds and name in self.model_fields_set:
                raise InvalidJob(f"give seeds, or a region to search, not both: leave out {name}", (name,))
        seeds = tuple(OrbitSeed(seed.time, seed.velocity, seed.period) for seed in self.seeds or ())
        asked = self.continuation, self.curves
        continuation, curves = (None if each is None else each.to_continuation() for each in asked)
        oscillator, region = self.oscillator.to_oscillator(), self.region.to_region()
        job = OrbitsJob(oscillator, self.longest, region, self.cells, seeds, continuation, curves)
        demand_quiet(job.demand_quiet, unless=self.oscillator.allow_no_quiet_solution)
        return job


class OrbitDeparture(BaseModel):
    """A departure of an orbit."""

    time: float
    velocity: float
    grazing_margin: float = Field(description="v - v*(t): above 0 where the flight meets -beta")
    lower_speed: float | None = Field(description="Speed at -beta; null where it is not met")


class OrbitView(BaseModel):
    """A periodic orbit."""

    name: str = Field(description="Its itinerary", examples=["P(1,1,0)"])
    forcing_periods: int
    upper_contacts: int
    lower_contacts: int
    attracts: bool
    multipliers: list[tuple[float, float]] = Field(description="Eigenvalues of DP^p: real and imaginary parts")
    residual: float
    grazing_distance: float
    departures: list[OrbitDeparture] = Field(description="From the slowest on, in order of time")
    branch: int | None = Field(None, description="Branch that it lies on; null where none was asked for")


class EndView(BaseModel):
    """Why a branch ends."""

    reason: Literal[
        "start", "bound", "closed", "grazing", "contact_loss", "halved", "domain", "points", "stalled"
    ]  # fmt: skip
    message: str
    value: float = Field(description="Value of the parameter there")


class BranchView(BaseModel):
    """A branch of orbits."""

    orbit: int = Field(description="Orbit that it began with: index into `orbits`")
    points: int
    lowest: float = Field(description="Least value of the parameter on it")
    highest: float
    ends: tuple[EndView, EndView]


class SpecialDeparture(BaseModel):
    """A departure of the orbit at a special point."""

    time: float
    velocity: float


class SpecialPointView(BaseModel):
    """A special point of branches."""

    kind: Literal["saddle-node", "period doubling", "grazing", "contact loss"]
    parameter: Parameter
    value: float
    error: float = Field(description="Last change of the value by Newton's method")
    residual: float
    orbit: str = Field(description="Itinerary of the orbit there; a contact that only grazes is not counted")
    branch: int = Field(description="First branch that has it: index into `branches`")
    multipliers: list[tuple[float | None, float | None]]
    departures: list[SpecialDeparture] = Field(description="The first one grazes, or loses contact")


class CurveView(BaseModel):
    """A curve of special points in two parameters."""

    special_point: int = Field(description="Which it began with: index into `special_points`")
    parameters: tuple[Parameter, Parameter]
    points: int
    first: tuple[float, float] = Field(description="Least and greatest value of the first parameter")
    second: tuple[float, float]
    ends: tuple[str, str] = Field(description="Why it ends, in words")


class OrbitsView(AnalysisView):
    """Summary of orbits; the points of branches and curves are in the store."""

    kind: Literal["orbits"]
    orbits: list[OrbitView]
    branches: list[BranchView]
    special_points: list[SpecialPointView]
    curves: list[CurveView]

"""Shapes of bifurcation diagrams over HTTP."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from service.models.analysis import AnalysisView, OscillatorsRequest, RegionRequest, SeedRequest
from service.models.oscillator import demand_quiet
from service.models.vary import Parameter, VaryRequest
from service.strict import Count
from worker.errors import InvalidJob
from worker.jobs.bifurcation_job import BifurcationJob, Direction


class BifurcationRequest(OscillatorsRequest):
    """A bifurcation diagram: at each value the last departures after a transient, the very last seeding the next."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [
                {
                    "kind": "bifurcation",
                    "oscillator": {"model": "impacting", "eccentricity": 0.1, "half_backlash": 0.6},
                    "vary": {"parameter": "damping", "start": 0.5, "stop": 0.6, "count": 1000},
                    "direction": "both",
                }
            ]
        },
    )

    kind: Literal["bifurcation"] = "bifurcation"
    vary: VaryRequest = Field(description="The parameter and its values")
    seeds: Annotated[list[SeedRequest], Field(min_length=1, max_length=100)] | None = Field(
        None, description="Departures to begin with; without them, the attractors found at the first value visited"
    )
    region: RegionRequest | None = Field(None, description="Where those attractors are looked for")
    direction: Direction = Field(Direction.UP, description="both: up and then, from where that ends, down again")
    transient: Annotated[int, Field(strict=True, ge=0)] = Field(1000, description="Impacts before any are kept")
    kept: Count = Field(20, description="Departures kept at each value")

    @property
    def visits(self) -> int:
        """Values visited, counted once for each seed; seeds that are to be found count as one."""
        return self.vary.size * (2 if self.direction == Direction.BOTH else 1) * len(self.seeds or [None])

    def sizes(self) -> tuple[tuple[str, float, str], ...]:
        """What is large about the request: in words, how large, and the setting that bounds it."""
        return (
            ("impacts", self.visits * (self.transient + self.kept), "max_diagram_applications"),
            ("departures kept", self.visits * self.kept, "max_diagram_points"),
        )

    def to_job(self) -> BifurcationJob:
        """Job that this asks for.

        Raises
        ------
        OutsideDomain, InvalidJob
            Saying what is wrong.
        """
        if self.seeds and self.region:
            raise InvalidJob("give seeds, or a region to look for attractors in, not both", ("region",))
        seeds = tuple((seed.time, seed.velocity) for seed in self.seeds or ())
        oscillator, vary = self.oscillator.to_oscillator(), self.vary.to_swept(("vary",))
        region = (self.region or RegionRequest()).to_region()
        job = BifurcationJob(oscillator, vary, seeds, region, self.direction, self.transient, self.kept)
        demand_quiet(job.demand_quiet, unless=self.oscillator.allow_no_quiet_solution)
        return job


class StretchView(BaseModel):
    """Neighbouring values at which a motion stays of one kind."""

    what: str = Field(examples=["impact period 2"])
    way: Literal["up", "down"]
    start: float
    stop: float
    values: int


class MotionView(BaseModel):
    """One motion along the parameter."""

    name: str = Field(description="Attractor at the first value visited, or given", examples=["P(1,2,0)"])
    time: float = Field(description="Phase of the departure that it began with")
    velocity: float
    stretches: list[StretchView] = Field(description="In the order of visits; the first 200")
    stretches_total: int


class BifurcationView(AnalysisView):
    """Summary of a bifurcation diagram."""

    kind: Literal["bifurcation"]
    parameter: Parameter
    values_visited: int
    motions: list[MotionView]

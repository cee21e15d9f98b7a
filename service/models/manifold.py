"""Shapes of manifolds over HTTP."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from rattle_kernels import CurveResolution, ManifoldLimits
from service.models.analysis import AnalysisView, Interval, OscillatorsRequest, RegionRequest
from service.models.orbits import OrbitView
from service.strict import Count, Real, Request
from worker.errors import InvalidJob
from worker.jobs.manifold_job import Itinerary, ManifoldJob, Side
from worker.jobs.orbits_job import OrbitSeed


def speeds_to_keep() -> Interval:
    """The paper's window."""
    return Interval(start=0.0, stop=7.0)


class SaddleRequest(Request):
    """A saddle: a departure close to it with its impact period, or its itinerary."""

    itinerary: str | None = Field(None, description="All saddles of that name", examples=["P(1,1,0)"])
    time: Real | None = None
    velocity: Real | None = None
    period: Annotated[int, Field(strict=True)] = Field(1, description="Impact period: n+ of P(m, n+, n-)")

    @model_validator(mode="after")
    def _one_way(self) -> "SaddleRequest":
        by_seed = self.time is not None and self.velocity is not None
        other = {"time", "velocity", "period"} & self.model_fields_set
        if (self.itinerary is None) != by_seed or (self.itinerary is not None and other):
            raise ValueError('give {"time": 0.6, "velocity": 3.77, "period": 1}, or {"itinerary": "P(1,1,0)"}')
        return self

    def to_saddle(self, place: tuple[str | int, ...]) -> OrbitSeed | Itinerary:
        """Saddle of the worker, not checked yet."""
        if self.itinerary is not None:
            return Itinerary.from_text(self.itinerary, (*place, "itinerary"))
        assert self.time is not None and self.velocity is not None
        return OrbitSeed(self.time, self.velocity, self.period)


class ResolutionRequest(Request):
    """How fine curves are, with speeds in units of the largest v*."""

    chord: Real = Field(0.01, description="Longest distance between neighbours")
    angle: Real = Field(0.2, description="Largest angle between chords, radians")
    finest: Real = Field(1e-4, description="Chords shorter than this are not divided to make an angle smaller")

    def to_resolution(self) -> CurveResolution:
        """Resolution of the kernels, not checked yet."""
        return CurveResolution(self.chord, self.angle, self.finest)


class ManifoldRequest(OscillatorsRequest):
    """Stable and unstable manifolds of saddles of the impacting model."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [
                {
                    "kind": "manifold",
                    "oscillator": {"model": "impacting", "damping": 0.6, "eccentricity": 0.1, "half_backlash": 0.6},
                    "saddles": [{"itinerary": "P(1,1,0)"}, {"time": 0.89, "velocity": 3.988}],
                    "side": "stable",
                    "arclength": 100,
                    "velocity": {"start": 0, "stop": 7},
                }
            ]
        },
    )

    kind: Literal["manifold"] = "manifold"
    saddles: Annotated[list[SaddleRequest], Field(min_length=1, max_length=100)]
    side: Side = Side.STABLE
    arclength: Real = Field(20.0, description="Of each branch, within the window of speeds")
    velocity: Interval = Field(default_factory=speeds_to_keep, description="Speeds to keep")
    most_points: Count = Field(1_000_000, description="Of each branch")
    resolution: ResolutionRequest = Field(default_factory=ResolutionRequest)
    region: RegionRequest = Field(
        default_factory=RegionRequest, description="Where saddles of an itinerary are looked for"
    )
    cells: Count = Field(40, description="Cells of that search each way")

    def sizes(self) -> tuple[tuple[str, float, str], ...]:
        """What is large about the request: in words, how large, and the setting that bounds it."""
        itineraries = [Itinerary.from_text(each.itinerary) for each in self.saddles if each.itinerary is not None]
        longest = max((each.upper_contacts for each in itineraries), default=0)
        return (
            ("units of arclength", self.arclength, "max_arclength"),
            ("points of a branch", self.most_points, "max_curve_points"),
            ("cells times cells times n+", self.cells**2 * longest, "max_orbit_starts"),
        )

    def to_job(self) -> ManifoldJob:
        """Job that this asks for.

        Raises
        ------
        OutsideDomain, InvalidJob
            Saying what is wrong.
        """
        saddles = tuple(saddle.to_saddle(("saddles", i)) for i, saddle in enumerate(self.saddles))
        if self.arclength <= 0.0:
            raise InvalidJob(f"arclength must be above 0, not {self.arclength:g}", ("arclength",))
        limits = ManifoldLimits(self.arclength, self.velocity.start, self.velocity.stop, self.most_points)
        return ManifoldJob(
            self.oscillator.to_oscillator(), saddles, self.side, limits, self.resolution.to_resolution(),
            self.region.to_region(), self.cells,
        )  # fmt: skip


class ManifoldBranchView(BaseModel):
    """One branch of a manifold."""

    saddle: int = Field(description="Whose: index into `saddles`")
    manifold: Literal["stable", "unstable"]
    departure: int = Field(description="Which of the saddle's departures it leaves")
    side: Literal[1, -1] = Field(description="1 where it leaves it towards later phases")
    arclength: float
    end: str = Field(description="Why it was grown no further")
    vertices: int
    pieces: int
    pieces_by_end: dict[str, int] = Field(
        description="Pieces that end at a corner, leave the window, or end the branch"
    )


class ManifoldView(AnalysisView):
    """Summary of manifolds; their vertices are in the store."""

    kind: Literal["manifold"]
    saddles: list[OrbitView]
    branches: list[ManifoldBranchView]

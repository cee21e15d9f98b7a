"""Results of searches for periodic orbits over HTTP."""

from typing import Literal

from pydantic import BaseModel, Field

from service.models.analysis import AnalysisView
from worker.jobs.swept_parameter import Parameter


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


class BranchEndView(BaseModel):
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
    ends: tuple[BranchEndView, BranchEndView]


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

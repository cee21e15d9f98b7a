"""Results of bifurcation diagrams over HTTP."""

from typing import Literal

from pydantic import BaseModel, Field

from service.models.analysis import AnalysisView
from worker.jobs.swept_parameter import Parameter


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

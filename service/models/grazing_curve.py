"""Shapes of grazing curves and their pre-images over HTTP."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from service.models.analysis import AnalysisView, Interval, OscillatorsRequest
from service.models.manifold import ResolutionRequest, speeds_to_keep
from service.strict import Count
from worker.jobs.grazing_curve_job import GrazingCurveJob


class GrazingCurveRequest(OscillatorsRequest):
    """The grazing curve of the impacting model and its pre-images."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [
                {
                    "kind": "grazing_curve",
                    "oscillator": {"model": "impacting", "damping": 0.6, "eccentricity": 0.1, "half_backlash": 0.6},
                    "order": 4,
                }
            ]
        },
    )

    kind: Literal["grazing_curve"] = "grazing_curve"
    order: Annotated[int, Field(strict=True)] = Field(2, description="Highest; 0 is the grazing curve itself")
    velocity: Interval = Field(default_factory=speeds_to_keep, description="Speeds to keep")
    resolution: ResolutionRequest = Field(default_factory=ResolutionRequest)
    most_points: Count = Field(1_000_000, description="Of one order; an order that needs more is left incomplete")

    def sizes(self) -> tuple[tuple[str, float, str], ...]:
        """What is large about the request: in words, how large, and the setting that bounds it."""
        return (
            ("orders", self.order, "max_order"),
            ("points of an order", self.most_points, "max_curve_points"),
        )

    def to_job(self) -> GrazingCurveJob:
        """Job that this asks for.

        Raises
        ------
        OutsideDomain, InvalidJob
            Saying what is wrong.
        """
        velocity, resolution = (self.velocity.start, self.velocity.stop), self.resolution.to_resolution()
        return GrazingCurveJob(self.oscillator.to_oscillator(), self.order, velocity, resolution, self.most_points)


class OrderView(BaseModel):
    """A pre-image of one order."""

    order: int
    complete: bool = Field(description="False where it is not there yet, or needs more points than were allowed")
    pieces: int
    vertices: int
    arclength: float


class GrazingCurveView(AnalysisView):
    """Summary of a grazing curve; its vertices are in the store."""

    kind: Literal["grazing_curve"]
    orders: list[OrderView]

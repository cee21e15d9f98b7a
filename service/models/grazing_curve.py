"""Results of grazing curves over HTTP."""

from typing import Literal

from pydantic import BaseModel, Field

from service.models.analysis import AnalysisView


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

"""Results of curves over HTTP: grazing curves and manifolds."""

from typing import Literal

from pydantic import BaseModel, Field

from service.models.analysis import AnalysisView
from service.models.orbits import OrbitView


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

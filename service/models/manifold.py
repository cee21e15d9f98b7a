"""Results of manifolds over HTTP."""

from typing import Literal

from pydantic import BaseModel, Field

from service.models.analysis import AnalysisView
from service.models.orbits import OrbitView


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

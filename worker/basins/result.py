"""Results of basins and sweeps, as JSON describes them: the model of what `worker.stores.summary` says."""

import math
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, Field

from worker.additions import additions, with_fields


def _finite_or_none(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


FiniteOrNone = Annotated[float | None, BeforeValidator(_finite_or_none)]
"""A number, or None in place of NaN and infinity, which JSON cannot hold."""


class Loud(BaseModel):
    """Loudness of a motion: 0 for permanent contact, null where it is not known."""

    impacts_per_period: FiniteOrNone = Field(description="Impacts on both walls in a forcing period")
    largest_impact_speed: FiniteOrNone = Field(description="Of arrival at a wall; of chaos the largest that was met")
    impact_power: FiniteOrNone = Field(description="Sum of v²/2 over the impacts of a forcing period")
    impacts_per_period_error: FiniteOrNone = Field(description="Standard error; 0 if the motion is not chaotic")
    impact_power_error: FiniteOrNone = Field(description="Standard error; 0 if the motion is not chaotic")


class ExpectedView(BaseModel):
    """Mean loudness over the window of a basin: shares times loudness."""

    impacts_per_period: float
    largest_impact_speed: float
    impact_power: float
    impacts_per_period_error: float = Field(description="Standard error, from chaos and from shares of samples")
    largest_impact_speed_error: float = Field(description="Standard error, from shares of samples")
    impact_power_error: float = Field(description="Standard error, from chaos and from shares of samples")
    undecided_share: float = Field(description="Share of the cells whose motion is not known; they count as silent")


class EndView(BaseModel):
    """What a part of the motions on a chaotic transient end in."""

    solution: int = Field(description="Which: index into `solutions`")
    share: float = Field(description="Part of an ensemble of motions that ended in it")
    standard_error: float


class SolutionView(Loud):
    """One motion and its share of the cells. In a sweep: the share of all basins, the points of the first with it."""

    name: str = Field(examples=["P(1,1,0)"])
    kind: Literal["periodic", "chaotic", "chaotic_transient", "permanent_contact", "undecided"]
    share: FiniteOrNone = Field(description="Part of the cells that end in it; null until every tile is labelled")
    forcing_periods: int
    upper_contacts: int
    lower_contacts: int
    lyapunov_exponent: FiniteOrNone = Field(description="Per forcing period")
    mean_life: FiniteOrNone = Field(
        description="Mean number of impacts until a motion leaves a chaotic transient; null if none was seen to leave"
    )
    mean_life_error: FiniteOrNone = Field(description="Standard error of `mean_life`, at most")
    ends: list[EndView] = Field(
        description="What a chaotic transient ends in; the rest of its ensemble had not ended. Empty of other motions"
    )
    points: list[tuple[float, float]] = Field(
        description="(t, v) of its departures; the first hundred of a chaotic one"
    )


if not TYPE_CHECKING:
    for _addition in additions():
        SolutionView = with_fields(SolutionView, _addition.solution_fields())


class ShareView(BaseModel):
    """Share of a solution in one basin."""

    solution: int = Field(description="Which: index into `solutions`")
    share: float
    standard_error: float | None = Field(description="Of samples, as of independent points; otherwise null")


class BasinView(BaseModel):
    """One basin of a sweep."""

    parameters: dict[str, float] = Field(description="Values of the swept parameters")
    complete: bool
    shares: list[ShareView] = Field(description="Shares of its solutions; empty until it is complete")
    expected: ExpectedView | None = Field(description="Mean loudness over its window; null until it is complete")


class ChangeView(BaseModel):
    """Birth or death of a solution between two neighbouring values of a swept parameter."""

    kind: Literal["birth", "death"]
    solution: int = Field(description="Which: index into `solutions`")
    parameter: str
    before: float
    after: float
    beside: float | None = Field(description="Value of the other swept parameter")


class ResultView(BaseModel):
    """Summary of a basin or a sweep, complete or not."""

    complete: bool
    request: dict[str, Any]
    tiles: int
    tiles_computed: int
    tiles_assembled: int
    solutions: list[SolutionView]
    basins: list[BasinView] = Field(description="All basins, the last swept parameter fastest; one if nothing is swept")
    changes: list[ChangeView] = Field(description="Births and deaths of solutions along the swept parameters so far")
    image_counts: dict[str, int] = Field(description="Cells with each reserved image; empty until all cells are mapped")
    seconds: dict[str, float] = Field(
        description="Wall time of each stage, and the kernels' own time summed over tiles"
    )
    zarr: str

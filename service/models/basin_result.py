"""Results of basins and sweeps over HTTP."""

import dataclasses
from typing import Any, Literal

from pydantic import BaseModel, Field

from rattle_kernels import Attractor
from service.models.numbers import FiniteOrNone
from worker.stores.summary import BasinSummary, Change, SweptBasinSummary


class SolutionView(BaseModel):
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
    points: list[tuple[float, float]] = Field(
        description="(t, v) of its departures; the first hundred of a chaotic one"
    )

    @classmethod
    def from_attractor(cls, attractor: Attractor, share: float) -> "SolutionView":
        """View of an attractor."""
        points = zip(attractor.time[:100].tolist(), attractor.velocity[:100].tolist(), strict=True)
        return cls(
            name=attractor.name, kind=attractor.kind.name.lower(), share=share,
            forcing_periods=attractor.forcing_periods, upper_contacts=attractor.upper_contacts,
            lower_contacts=attractor.lower_contacts, lyapunov_exponent=attractor.lyapunov_exponent,
            mean_life=attractor.mean_life, points=list(points),
        )  # fmt: skip


class ShareView(BaseModel):
    """Share of a solution in one basin."""

    solution: int = Field(description="Which: index into `solutions`")
    share: float
    standard_error: float | None = Field(description="Binomial, for samples; otherwise null")


class BasinView(BaseModel):
    """One basin of a sweep."""

    parameters: dict[str, float] = Field(description="Values of the swept parameters")
    complete: bool
    shares: list[ShareView] = Field(description="Shares of its solutions; empty until it is complete")

    @classmethod
    def from_swept(cls, swept: SweptBasinSummary) -> "BasinView":
        """View of a basin's summary."""
        shares = [
            ShareView(solution=number, share=share, standard_error=swept.errors.get(number))
            for number, share in swept.shares.items()
        ]
        return cls(parameters=swept.values, complete=swept.complete, shares=shares)


class ChangeView(BaseModel):
    """Birth or death of a solution between two neighbouring values of a swept parameter."""

    kind: Literal["birth", "death"]
    solution: int = Field(description="Which: index into `solutions`")
    parameter: str
    before: float
    after: float
    beside: float | None = Field(description="Value of the other swept parameter")

    @classmethod
    def from_change(cls, change: Change) -> "ChangeView":
        """View of a change."""
        return cls(**dataclasses.asdict(change) | {"kind": change.kind.name.lower()})


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

    @classmethod
    def from_summary(cls, summary: BasinSummary, zarr: str) -> "ResultView":
        """View of a summary."""
        solutions = [
            SolutionView.from_attractor(attractor, share)
            for attractor, share in zip(summary.attractors, summary.shares, strict=True)
        ]
        return cls(
            complete=summary.complete, request=summary.request, tiles=summary.tiles,
            tiles_computed=summary.tiles_computed, tiles_assembled=summary.tiles_assembled, solutions=solutions,
            image_counts=summary.image_counts, seconds=summary.seconds, zarr=zarr,
            basins=[BasinView.from_swept(swept) for swept in summary.basins],
            changes=[ChangeView.from_change(change) for change in summary.changes],
        )  # fmt: skip

"""What to compute: periodic orbits, their branches in one parameter, and curves of special points in two."""

import math
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

from pydantic import ConfigDict, Field

from rattle_kernels import Oscillator
from rattle_kernels.model.domain import closed_edges
from rattle_kernels.orbits.orbit_equations import check_followed
from worker.errors import InvalidJob
from worker.jobs.job import AnalysisJob, Sizes
from worker.jobs.region import SEARCH_CELLS, Departure, Region
from worker.jobs.request import Count, Real, Whole, as_real, in_schema
from worker.jobs.swept_parameter import Parameter, is_phase

_EXAMPLE: dict[str, Any] = {
    "kind": "orbits",
    "oscillator": {"model": "impacting", "damping": 0.575, "eccentricity": 0.1, "half_backlash": 0.6},
    "longest": 4,
    "continuation": {"parameter": "damping", "start": 0.45, "stop": 0.7},
}
# Seeds, or a region to search; curves only beside a continuation.
_TOGETHER: list[Any] = [
    {
        "if": {"properties": {"seeds": {"type": "array"}}, "required": ["seeds"]},
        "then": {"properties": {"longest": False, "region": False, "cells": False}},
    },
    {
        "if": {"properties": {"curves": {"type": "object"}}, "required": ["curves"]},
        "then": {"properties": {"continuation": {"type": "object"}}, "required": ["continuation"]},
    },
]
# Of the impact equations, until a start has converged or is given up; a step takes the map and its derivative.
_NEWTON_STEPS = 40
# Of a search (`rattle_kernels.orbits.orbit_seeds`): impacts for each cell, to see what recurs; departures of its finer
# grid, which are mapped once for each period; and for each column and period the starts beside the grazing curve.
_RECURRENCES, _FINER, _BESIDE = 200, 100, 72
_LONGEST_PERIOD = 9999
"""Longest impact period of a saddle that an itinerary can name, too. A turn takes a hundredth of a second."""
PERIODS = in_schema(minimum=1, maximum=_LONGEST_PERIOD)


@dataclass(frozen=True)
class OrbitSeed(Departure):
    """A departure close to a periodic orbit, and the impact period to look for.

    Raises
    ------
    InvalidJob
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid", title="OrbitSeedRequest")

    period: Annotated[Whole, Field(description="Impact period: n+ of P(m, n+, n-), or a multiple of it"), PERIODS] = 1

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.period < 1:
            raise InvalidJob(
                f"period must be 1 or more, the number of impacts with +beta in one turn, not {self.period}",
                ("period",),
            )
        if self.period > _LONGEST_PERIOD:
            raise InvalidJob(f"period must be at most {_LONGEST_PERIOD}, not {self.period}", ("period",))


@dataclass(frozen=True)
class Continuation:
    """A parameter to follow something in, from where to where, and the most points each way."""

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid", title="ContinuationRequest")

    parameter: Parameter
    start: Annotated[Real, Field(description="Lowest value")]
    stop: Annotated[Real, Field(description="Highest value")]
    most_points: Annotated[Count, Field(description="Most points each way"), in_schema(minimum=2)] = 2000

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", as_real(self.start))
        object.__setattr__(self, "stop", as_real(self.stop))

    def check(self, oscillator: Oscillator, place: str) -> None:
        """Check the bounds against the oscillator's own value.

        Parameters
        ----------
        oscillator : Oscillator
        place : str
            Location of the continuation in the request.

        Raises
        ------
        InvalidJob
        """
        if self.parameter not in oscillator.parameters:
            message = f"{self.parameter} is none of its parameters: {', '.join(oscillator.parameters)}"
            raise InvalidJob(message, (place, "parameter"))
        value = oscillator.value_of(self.parameter)
        lowest, highest = -math.inf if is_phase(self.parameter) else 0.0, closed_edges(self.parameter)[1]
        edge = lowest if self.start < lowest else highest if self.stop > highest else None
        if edge is not None:
            message = f"{self.parameter} ends at {edge:g}: it cannot be followed from {self.start:g} to {self.stop:g}"
            raise InvalidJob(message, (place,))
        if not (self.start <= value <= self.stop and math.isfinite(self.stop - self.start)):
            message = f"{self.parameter} must be followed between bounds that hold its value {value:g}"
            raise InvalidJob(f"{message}, not {self.start:g} and {self.stop:g}", (place,))
        if self.most_points < 2:
            raise InvalidJob(f"most_points must be 2 or more, not {self.most_points}", (place, "most_points"))


def search_impacts(cells: int, longest: int) -> int:
    """Usual number of applications of P in a search of a region, within a factor of 4 and seldom more.

    Parameters
    ----------
    cells : int
        Each way.
    longest : int
        Greatest n+ that is searched for.

    Returns
    -------
    int
    """
    # A start, and often a recurrence near it, for each cell and period; a turn has as many impacts as the period.
    turns = (2 * cells**2 + _BESIDE * cells) * longest * (longest + 1) // 2
    return cells**2 * (_RECURRENCES + _FINER * longest) + _NEWTON_STEPS * turns


class OrbitsJob(AnalysisJob):
    """Periodic orbits, stable or not: those of a region, or those near seeds; on request with their branches.

    Examples
    --------
    >>> import rattle
    >>> rattle.OrbitsJob(longest=2, continuation={"parameter": "damping", "start": 0.5, "stop": 0.7}).longest
    2
    """

    model_config = ConfigDict(title="OrbitsRequest", json_schema_extra={"examples": [_EXAMPLE], "allOf": _TOGETHER})

    loose_gears = True

    kind_: Literal["orbits"] = "orbits"
    longest: Annotated[Count, in_schema(maximum=_LONGEST_PERIOD)] = Field(
        4, description="Greatest n+ that is searched for"
    )
    region: Region = Field(default_factory=Region, description="Where it is searched")
    cells: Count = Field(SEARCH_CELLS, description="The search starts from the centres of so many cells each way")
    seeds: Annotated[list[OrbitSeed], Field(min_length=1, max_length=1000)] | None = Field(
        None, description="Start from these alone; leave out longest, region and cells then"
    )
    continuation: Continuation | None = Field(
        None, description="Follow every orbit in a parameter, through folds, and locate special points"
    )
    curves: Continuation | None = Field(None, description="Follow every special point in a second parameter, too")

    @property
    def fastest(self) -> float:
        """Highest speed of the region, or of the seeds."""
        return max((seed.velocity for seed in self.seeds or ()), default=self.region.velocity.stop)

    def sizes(self) -> Sizes:
        """Sizes of the request, for limits."""
        points = max((each.most_points for each in (self.continuation, self.curves) if each), default=0)
        return (
            ("cells times cells times longest", self.cells**2 * self.longest, "max_orbit_starts"),
            ("points each way", points, "max_branch_points"),
        )

    @property
    def impacts(self) -> int:
        """Usual number of applications of P: Newton's method from every start, and from point to point of a branch."""
        turns = sum(seed.period for seed in self.seeds or ()) or self.longest * (self.longest + 1) // 2
        searched = _NEWTON_STEPS * turns if self.seeds else search_impacts(self.cells, self.longest)
        points = sum(each.most_points for each in (self.continuation, self.curves) if each)
        return searched + _NEWTON_STEPS * 2 * points * turns

    @property
    def tasks_at_once(self) -> float:
        """As many as there are seeds; a region has bands enough."""
        return len(self.seeds) if self.seeds else super().tasks_at_once

    @property
    def bytes(self) -> int:
        """Usual number of bytes: those of branches, if there are any."""
        points = sum(each.most_points for each in (self.continuation, self.curves) if each)
        return 100 * (1000 + 2 * points * (len(self.seeds) if self.seeds else self.longest))

    def _settled(self) -> dict[str, Any]:
        search = ("longest", "region", "cells")
        for name in search:
            if self.seeds and name in self.model_fields_set:
                raise InvalidJob(f"give seeds, or a region to search, not both: leave out {name}", (name,))
        if self.longest > _LONGEST_PERIOD:
            raise InvalidJob(f"longest must be at most {_LONGEST_PERIOD}, not {self.longest}", ("longest",))
        if self.continuation:
            check_followed(self.oscillator)
            self.continuation.check(self.oscillator, "continuation")
        if self.curves:
            self._check_curves(self.curves)
        names = ("kind_", *(("seeds",) if self.seeds else search), "continuation", "curves")
        return {name: getattr(self, name) for name in names if getattr(self, name) is not None}

    def _check_curves(self, curves: Continuation) -> None:
        if self.continuation is None:
            raise InvalidJob("curves start from the special points of branches: give a continuation, too", ("curves",))
        if curves.parameter == self.continuation.parameter:
            message = f"the second parameter must be another than the first, {curves.parameter}"
            raise InvalidJob(message, ("curves", "parameter"))
        curves.check(self.oscillator, "curves")

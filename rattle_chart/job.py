"""What to compute: a window of two parameters, its special points and curves, and what machines do in it."""

import math
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import ConfigDict, Field

from rattle_kernels import Oscillator
from rattle_kernels.model.domain import closed_edges
from rattle_kernels.orbits.orbit_equations import check_followed
from worker.errors import InvalidJob
from worker.jobs.job import AnalysisJob, Sizes
from worker.jobs.orbits_job import search_impacts
from worker.jobs.region import Interval, Region
from worker.jobs.request import Count, Whole, in_schema
from worker.jobs.swept_parameter import Parameter, is_phase

_EXAMPLE: dict[str, Any] = {
    "kind": "chart",
    "oscillator": {"half_backlash": 0.6},
    "first": {"parameter": "damping", "start": 0.75, "stop": 0.78},
    "second": {"parameter": "eccentricity", "start": 0.094, "stop": 0.0995},
}
_LONGEST = 99
STARTS = 3
"""Machines of a line at which orbits are searched for."""
# Of a branch, and of a curve: usual numbers of points, Newton steps of each, and what a step takes beside P, as
# applications.
_POINTS, _NEWTON_STEPS, _OF_A_STEP = 300, 5, 90
# Branches of each length that a search finds at a machine, and special points of a line, usually.
_BRANCHES, _CURVES = 4, 6
SETTLING, GROWING = 2048, 512
"""Impacts of a machine's departures before their exponents are taken, and while they are."""
FOLLOWED = 48
"""Departures of a machine that are followed on at the next one."""
# Usual part of the departures that do not fall quiet, and what an impact takes while exponents grow, as impacts.
_FOLLOWED_ON, _OF_A_GROWTH = 0.5, 12


@dataclass(frozen=True)
class ChartAxis(Interval):
    """A parameter of a chart, from where to where."""

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid", title="ChartAxisRequest")

    parameter: Parameter

    @property
    def middle(self) -> float:
        """Value in the middle."""
        return 0.5 * (self.start + self.stop)

    def middles(self, count: int) -> np.ndarray:
        """Middles of so many equal parts, shape (count,)."""
        parts: np.ndarray = self.start + (np.arange(count) + 0.5) / count * (self.stop - self.start)
        return parts

    def check(self, oscillator: Oscillator, place: str) -> None:
        """Check that the oscillator has the parameter, and that it may have all values.

        Parameters
        ----------
        oscillator : Oscillator
        place : str
            Location in the request.

        Raises
        ------
        InvalidJob
        """
        if self.parameter not in oscillator.parameters:
            message = f"{self.parameter} is none of its parameters: {', '.join(oscillator.parameters)}"
            raise InvalidJob(message, (place, "parameter"))
        if not (self.start < self.stop and math.isfinite(self.stop - self.start)):
            raise InvalidJob(f"{self.parameter} must ascend, not run from {self.start:g} to {self.stop:g}", (place,))
        lowest, highest = -math.inf if is_phase(self.parameter) else 0.0, closed_edges(self.parameter)[1]
        for value, beyond in ((self.start, self.start < lowest), (self.stop, self.stop > highest)):
            if beyond:
                edge = lowest if value == self.start else highest
                raise InvalidJob(f"{self.parameter} ends at {edge:g}: a chart cannot reach to {value:g}", (place,))


class ChartJob(AnalysisJob):
    """A chart of two parameters: special points, their curves, points of codimension two, and what machines do.

    Examples
    --------
    >>> window = {"first": {"parameter": "damping", "start": 0.75, "stop": 0.78},
    ...           "second": {"parameter": "eccentricity", "start": 0.094, "stop": 0.0995}}
    >>> ChartJob(**window, longest=2).longest
    2
    """

    model_config = ConfigDict(title="ChartRequest", json_schema_extra={"examples": [_EXAMPLE]})

    kind_: Literal["chart"] = "chart"
    first: ChartAxis = Field(description="The parameter along the chart")
    second: ChartAxis = Field(description="The parameter up the chart")
    longest: Annotated[Count, in_schema(maximum=_LONGEST)] = Field(
        2, description="Greatest n+ of the orbits that are searched for"
    )
    lines: Annotated[Count, in_schema(maximum=1000)] = Field(
        3, description="Orbits are followed along so many lines each way"
    )
    region: Region = Field(default_factory=Region, description="Departures among which orbits are searched for")
    cells: Count = Field(16, description="The search starts from the centres of so many cells each way")
    pixels: Annotated[Whole, in_schema(minimum=0)] = Field(
        40, description="So many machines each way have a quiet share and an exponent; 0 for none"
    )
    departures: Count = Field(16, description="Departures of each of them, so many each way")

    @property
    def own_values(self) -> dict[str, float]:
        """Both parameters at the middle of the chart."""
        return {axis.parameter: axis.middle for axis in (self.first, self.second)}

    @property
    def fastest(self) -> float:
        """Highest speed of the region."""
        return self.region.velocity.stop

    def sizes(self) -> Sizes:
        """Sizes of the request, for limits."""
        starts = 2 * self.lines * STARTS * self.cells**2 * self.longest
        return (
            ("cells times cells times longest, of six searches for each of the lines", starts, "max_orbit_starts"),
            ("machines", self.pixels**2, "max_basins"),
            ("pixels times pixels times departures times departures", self._landings, "max_cells"),
        )

    @property
    def _landings(self) -> int:
        return (self.pixels * self.departures) ** 2

    @property
    def impacts(self) -> int:
        """Usual number of applications of P: searches, branches and curves, and the departures of the machines."""
        turns = self.longest * (self.longest + 1) // 2
        lines = 2 * self.lines
        searched = lines * STARTS * search_impacts(self.cells, self.longest)
        followed = lines * (STARTS * _BRANCHES + _CURVES) * _POINTS * _NEWTON_STEPS * (turns + _OF_A_STEP)
        return searched + followed + self.impacts_together

    @property
    def impacts_together(self) -> int:
        """Those of the departures of the machines, and of what is followed to them from both sides."""
        lasting = int(_FOLLOWED_ON * self.departures**2)
        return self.pixels**2 * (lasting * SETTLING + (lasting + 2 * FOLLOWED) * GROWING * _OF_A_GROWTH)

    @property
    def bytes(self) -> int:
        """Usual number of bytes."""
        return 100 * 2 * self.lines * _CURVES * _POINTS + 32 * self.pixels**2

    def _settled(self) -> dict[str, Any]:
        for place, axis in (("first", self.first), ("second", self.second)):
            axis.check(self.oscillator_.value, place)
        if self.first.parameter == self.second.parameter:
            message = f"the second parameter must be another than the first, {self.first.parameter}"
            raise InvalidJob(message, ("second", "parameter"))
        if self.longest > _LONGEST:
            raise InvalidJob(f"longest must be at most {_LONGEST}, not {self.longest}", ("longest",))
        if self.pixels < 0:
            raise InvalidJob(f"pixels must be 0 or more, not {self.pixels}", ("pixels",))
        check_followed(self.oscillator)
        names = "kind_", "first", "second", "longest", "lines", "region", "cells", "pixels", "departures"
        return {name: getattr(self, name) for name in names}

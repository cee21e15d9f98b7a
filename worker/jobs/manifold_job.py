"""What to compute: stable and unstable manifolds of saddles."""

import math
import re
from enum import StrEnum
from functools import cached_property
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import BeforeValidator, ConfigDict, Field, model_validator

from rattle_kernels import CurveResolution, ManifoldLimits
from rattle_kernels.manifolds.stable_manifold import check_limits
from rattle_kernels.orbits.periodic_orbit import orbit_name
from worker.errors import FieldPath, InvalidJob
from worker.jobs.job import IMPACTING_ALONE, AnalysisJob, Sizes
from worker.jobs.orbits_job import PERIODS, OrbitSeed, search_impacts
from worker.jobs.region import (
    MOST_POINTS,
    SEARCH_CELLS,
    SPEEDS,
    Interval,
    Region,
    Resolution,
    ResolutionRequest,
    check_speeds,
    papers_speeds,
)
from worker.jobs.request import Count, Real, Request, Whole, accepting, in_schema

_EXAMPLE: dict[str, Any] = {
    "kind": "manifold",
    "oscillator": {"model": "impacting", "damping": 0.6, "eccentricity": 0.1, "half_backlash": 0.6},
    "saddles": [{"itinerary": "P(1,1,0)"}, {"time": 0.89, "velocity": 3.988}],
    "side": "stable",
    "arclength": 100,
    "velocity": {"start": 0, "stop": 7},
}
_IMAGES_OF_A_POINT = 20
_AS_ITINERARY = r"^\s*P\((?!0+,)[0-9]{1,4},\s*(?!0+,)[0-9]{1,4},\s*[0-9]{1,4}\)\s*$"
# By its itinerary alone, or by a departure.
_ONE_WAY: dict[str, Any] = {
    "if": {"properties": {"itinerary": {"type": "string"}}, "required": ["itinerary"]},
    "then": {"properties": {"time": False, "velocity": False, "period": False}},
    "else": {
        "properties": {"time": {"type": "number"}, "velocity": {"type": "number"}},
        "required": ["time", "velocity"],
    },
}


class Side(StrEnum):
    """Which manifolds of a saddle."""

    STABLE = "stable"
    """Departures that P takes to it."""
    UNSTABLE = "unstable"
    """Departures that come from it."""
    BOTH = "both"

    @property
    def each(self) -> tuple["Side", ...]:
        """Stable and unstable one by one."""
        return (Side.STABLE, Side.UNSTABLE) if self is Side.BOTH else (self,)


class Itinerary(NamedTuple):
    """P(m, n+, n-) of the only saddle of that name that a search of the region finds."""

    forcing_periods: int
    upper_contacts: int
    lower_contacts: int

    @classmethod
    def from_text(cls, text: str, place: FieldPath = ()) -> "Itinerary":
        """Itinerary written as P(m, n+, n-).

        Parameters
        ----------
        text : str
        place : tuple of str and int
            Its location in the request.

        Returns
        -------
        Itinerary

        Raises
        ------
        InvalidJob
        """
        found = re.fullmatch(r"P\((\d{1,4}),\s*(\d{1,4}),\s*(\d{1,4})\)", text.strip())
        if found is None or 0 in map(int, found.groups()[:2]):
            raise InvalidJob(f"an itinerary is P(m, n+, n-) with m and n+ above 0, as in P(1,1,0), not {text!r}", place)
        return cls(*(int(number) for number in found.groups()))

    @property
    def name(self) -> str:
        """Name, in the form of an orbit's."""
        return orbit_name(self.forcing_periods, self.upper_contacts, self.lower_contacts)


class SaddleRequest(Request):
    """A saddle: a departure close to it with its impact period, or its itinerary."""

    model_config = ConfigDict(json_schema_extra=_ONE_WAY)

    itinerary: Annotated[str, in_schema(pattern=_AS_ITINERARY)] | None = Field(
        None, description="The only saddle of that name in the region", examples=["P(1,1,0)"]
    )
    time: Real | None = None
    velocity: Annotated[Real, in_schema(exclusiveMinimum=0)] | None = None
    period: Annotated[Whole, PERIODS] = Field(1, description="Impact period: n+ of P(m, n+, n-)")

    @model_validator(mode="after")
    def _one_way(self) -> "SaddleRequest":
        by_seed = self.time is not None and self.velocity is not None
        other = {"time", "velocity", "period"} & self.model_fields_set
        if (self.itinerary is None) != by_seed or (self.itinerary is not None and other):
            raise ValueError('give {"time": 0.6, "velocity": 3.77, "period": 1}, or {"itinerary": "P(1,1,0)"}')
        # In canonical form: the itinerary as an orbit's name, the phase within a period.
        settled = _saddle_of(self.value)
        self.__dict__.update(settled)
        object.__setattr__(self, "__pydantic_fields_set__", set(settled))
        return self

    @cached_property
    def value(self) -> OrbitSeed | Itinerary:
        """Starting point of Newton's method, or itinerary of the saddle.

        Raises
        ------
        InvalidJob
        """
        if self.itinerary is not None:
            return Itinerary.from_text(self.itinerary, ("itinerary",))
        assert self.time is not None and self.velocity is not None
        return OrbitSeed(self.time, self.velocity, self.period)


def _saddle_of(saddle: OrbitSeed | Itinerary) -> dict[str, Any]:
    """A saddle that Python gives, as JSON."""
    if isinstance(saddle, Itinerary):
        return {"itinerary": saddle.name}
    return {"time": saddle.time, "velocity": saddle.velocity, "period": saddle.period}


Saddle = Annotated[SaddleRequest, BeforeValidator(accepting((OrbitSeed, Itinerary), _saddle_of))]
"""From Python also an `OrbitSeed` or an `Itinerary`."""


class ManifoldJob(AnalysisJob):
    """Stable and unstable manifolds of saddles of the impacting model.

    Examples
    --------
    >>> import rattle
    >>> rattle.ManifoldJob(saddles=[{"time": 0.6017, "velocity": 3.7699}], arclength=20).side.value
    'stable'
    """

    model_config = ConfigDict(title="ManifoldRequest", json_schema_extra={"examples": [_EXAMPLE]} | IMPACTING_ALONE)

    impacting_only = True
    loose_gears = True

    kind_: Literal["manifold"] = "manifold"
    saddles_: Annotated[list[Saddle], Field(min_length=1, max_length=100)]
    side: Side = Field(Side.STABLE, description="Which manifolds")
    arclength: Annotated[Real, in_schema(exclusiveMinimum=0)] = Field(
        ManifoldLimits().arclength, description="Of each branch, within the window of speeds"
    )
    velocity: Annotated[Interval, SPEEDS] = Field(default_factory=papers_speeds, description="Speeds to keep")
    most_points: Annotated[Count, in_schema(minimum=100)] = Field(MOST_POINTS, description="Of each branch")
    resolution_: Resolution = Field(default_factory=ResolutionRequest)
    region: Region = Field(default_factory=Region, description="Where saddles of an itinerary are looked for")
    cells: Count = Field(SEARCH_CELLS, description="Cells of that search each way")

    @property
    def fastest(self) -> float:
        """Highest speed that is kept."""
        return self.velocity.stop

    def sizes(self) -> Sizes:
        """Sizes of the request, for limits."""
        longest = max((each.upper_contacts for each in self.saddles if isinstance(each, Itinerary)), default=0)
        return (
            ("units of arclength", self.arclength, "max_arclength"),
            ("points of a branch", self.most_points, "max_curve_points"),
            ("cells times cells times n+", self.cells**2 * longest, "max_orbit_starts"),
        )

    @property
    def impacts(self) -> int:
        """Usual number of applications of P: each point is mapped some times until neighbours are close enough.

        Saddles that are named by their itineraries are searched for.
        """
        named = (each for each in self.saddles if isinstance(each, Itinerary))
        searched = sum(search_impacts(self.cells, each.upper_contacts) for each in named)
        return searched + self._points * _IMAGES_OF_A_POINT

    @property
    def tasks_at_once(self) -> int:
        """As many as there are branches."""
        return 2 * len(self.side.each) * len(self.saddles_)

    @property
    def bytes(self) -> int:
        """Usual number of bytes: phase and speed of each point."""
        return self._points * 16

    @property
    def _points(self) -> int:
        branch = math.ceil(min(self.most_points, self.arclength / self.resolution_.chord))
        return self.tasks_at_once * branch

    def _settled(self) -> dict[str, Any]:
        if self.arclength <= 0.0:
            raise InvalidJob(f"arclength must be above 0, not {self.arclength:g}", ("arclength",))
        check_speeds(self.velocity)
        try:
            check_limits(self.limits)
        except ValueError as error:
            raise InvalidJob(str(error)) from error
        names = ["kind_", "side", "arclength", "velocity", "most_points"]
        if any(isinstance(saddle, Itinerary) for saddle in self.saddles):
            names += ["region", "cells"]
        settled = {name: getattr(self, name) for name in ("saddles_", *names)}
        return settled | {"resolution_": self.resolution_.settled_to()}

    @cached_property
    def saddles(self) -> tuple[OrbitSeed | Itinerary, ...]:
        """Starting points of Newton's method, or itineraries of the saddles."""
        return tuple(saddle.value for saddle in self.saddles_)

    @cached_property
    def limits(self) -> ManifoldLimits:
        """How far each branch is grown."""
        return ManifoldLimits(self.arclength, *self.velocity.ends, self.most_points)

    @cached_property
    def resolution(self) -> CurveResolution:
        """How fine the curves are, checked."""
        return self.resolution_.value

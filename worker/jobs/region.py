"""What requests of analyses name of the (t, v) plane: departures, intervals, regions, and how fine curves in it are."""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, ClassVar, Self

from pydantic import BeforeValidator, ConfigDict, Field, model_validator

from rattle_kernels import CellGrid, CurveResolution, ManifoldLimits
from rattle_kernels.manifolds.polyline import check_resolution
from worker.errors import FieldPath, InvalidJob
from worker.jobs.request import Real, Request, accepting, as_real, in_schema

_WINDOW = CellGrid()
_RESOLUTION = CurveResolution()
MOST_POINTS = ManifoldLimits().points
"""Most points of a curve by default."""
SEARCH_CELLS = 40
"""Default number of cells each way in a search for orbits."""


@dataclass(frozen=True)
class Departure:
    """A departure from +beta to start from; its phase is reduced to [0, 1).

    Raises
    ------
    InvalidJob
        If it does not lie in the section of departures from +beta.
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid", title="SeedRequest")

    time: Annotated[Real, Field(description="Phase t, forcing periods")]
    velocity: Annotated[Real, Field(description="Speed v of the departure, above 0"), in_schema(exclusiveMinimum=0)]

    def __post_init__(self) -> None:
        if not math.isfinite(self.time):
            raise InvalidJob(f"the phase of a departure must be finite, not {self.time}", ("time",))
        if not (math.isfinite(self.velocity) and self.velocity > 0.0):
            raise InvalidJob(
                "a seed lies in the section of departures from +beta, where speeds are above 0, "
                f"not at the speed {self.velocity:g}",
                ("velocity",),
            )
        object.__setattr__(self, "time", float(self.time) - math.floor(self.time) + 0.0)
        object.__setattr__(self, "velocity", float(self.velocity))


@dataclass(frozen=True)
class Interval:
    """An interval from ``start`` to ``stop``."""

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid", title="Interval")

    start: Real
    stop: Real

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", as_real(self.start))
        object.__setattr__(self, "stop", as_real(self.stop))

    @property
    def ends(self) -> tuple[float, float]:
        """Start and stop."""
        return self.start, self.stop


def papers_speeds() -> Interval:
    """Speeds of the paper's window."""
    return Interval(_WINDOW.velocity_start, _WINDOW.velocity_stop)


def papers_phases() -> Interval:
    """Phases of the paper's window: the whole period."""
    return Interval(_WINDOW.time_start, _WINDOW.time_stop)


PHASES = in_schema(
    properties={"start": {"minimum": 0, "exclusiveMaximum": 1}, "stop": {"exclusiveMinimum": 0, "maximum": 1}}
)
SPEEDS = in_schema(properties={"start": {"minimum": 0}, "stop": {"exclusiveMinimum": 0}})
"""What the schema says of intervals of phases, and of speeds."""


def check_speeds(speeds: Interval, place: FieldPath = ("velocity",)) -> None:
    """Check a window of speeds.

    Parameters
    ----------
    speeds : Interval
    place : tuple of str and int
        Its location in the request.

    Raises
    ------
    InvalidJob
    """
    start, stop = speeds.ends
    if not (0.0 <= start < stop and math.isfinite(stop)):
        raise InvalidJob(f"speeds must ascend from 0 or more and be finite, not run from {start:g} to {stop:g}", place)


@dataclass(frozen=True)
class Region:
    """Window of the (t, v) plane that is searched.

    Raises
    ------
    InvalidJob
        If phases do not ascend within [0, 1], or speeds do not ascend from 0 or more.
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid", title="RegionRequest")

    time: Annotated[Interval, Field(description="Phases within 0 and 1"), PHASES] = field(default_factory=papers_phases)
    velocity: Annotated[Interval, Field(description="Speeds of departure"), SPEEDS] = field(
        default_factory=papers_speeds
    )

    def __post_init__(self) -> None:
        start, stop = self.time.ends
        if not 0.0 <= start < stop <= 1.0:
            message = f"phases of the region must ascend within 0 and 1, not run from {start:g} to {stop:g}"
            raise InvalidJob(message, ("time",))
        check_speeds(self.velocity)


Positive = Annotated[Real, in_schema(exclusiveMinimum=0)]


class ResolutionRequest(Request):
    """How fine curves are, with speeds in units of the largest v*."""

    chord: Positive = Field(_RESOLUTION.chord, description="Longest distance between neighbouring points")
    angle: Positive = Field(_RESOLUTION.angle, description="Largest angle between chords, radians")
    finest: Positive = Field(
        _RESOLUTION.finest, description="Chords shorter than this are not divided to make an angle smaller"
    )

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        try:
            check_resolution(self.value)
        except ValueError as error:
            raise InvalidJob(str(error)) from error
        return self

    @cached_property
    def value(self) -> CurveResolution:
        """Resolution of the kernels."""
        return CurveResolution(self.chord, self.angle, self.finest)


Resolution = Annotated[ResolutionRequest, BeforeValidator(accepting(CurveResolution, CurveResolution._asdict))]
"""From Python also a `CurveResolution`."""

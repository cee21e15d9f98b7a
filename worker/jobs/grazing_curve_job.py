"""What to compute: the grazing curve and its pre-images."""

from functools import cached_property
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field

from rattle_kernels import CurveResolution, FirstCurve
from rattle_kernels.manifolds.grazing_preimages import STRETCHES, check_first
from worker.errors import InvalidJob
from worker.jobs.job import IMPACTING_ALONE, AnalysisJob, Sizes
from worker.jobs.region import MOST_POINTS, SPEEDS, Interval, Resolution, ResolutionRequest, check_speeds, papers_speeds
from worker.jobs.request import Count, Whole, in_schema

_EXAMPLE: dict[str, Any] = {
    "kind": "grazing_curve",
    "oscillator": {"model": "impacting", "damping": 0.6, "eccentricity": 0.1, "half_backlash": 0.6},
    "order": 4,
}
_LEAST_POINTS = 1000


class GrazingCurveJob(AnalysisJob):
    """The grazing curve of the impacting model and its pre-images (Sec. 6.1).

    Examples
    --------
    >>> import rattle
    >>> rattle.GrazingCurveJob(order=1).order
    1
    """

    model_config = ConfigDict(title="GrazingCurveRequest", json_schema_extra={"examples": [_EXAMPLE]} | IMPACTING_ALONE)

    impacting_only = True
    loose_gears = True

    kind_: Literal["grazing_curve"] = "grazing_curve"
    order: Annotated[Whole, in_schema(minimum=0)] = Field(
        2, description="Highest order of pre-images; 0 is the grazing curve itself"
    )
    first: FirstCurve = Field(
        FirstCurve.LOWER,
        description="The curve of order 0: departures that next touch -beta; of a loose gear also those "
        'that next touch +beta from below ("upper"), or those up to which it comes to rest on +beta ("rest")',
    )
    velocity: Annotated[Interval, SPEEDS] = Field(default_factory=papers_speeds, description="Speeds to keep")
    resolution_: Resolution = Field(default_factory=ResolutionRequest)
    most_points: Annotated[Count, in_schema(minimum=_LEAST_POINTS)] = Field(
        MOST_POINTS, description="Of one order; an order that needs more is left incomplete"
    )

    @property
    def fastest(self) -> float:
        """Highest speed that is kept."""
        return self.velocity.stop

    def sizes(self) -> Sizes:
        """Sizes of the request, for limits."""
        return (
            ("orders", self.order, "max_order"),
            ("points of an order", self.most_points, "max_curve_points"),
        )

    @property
    def impacts(self) -> int:
        """Most applications of P: each point is the pre-image of one of the order before."""
        return self.order * self.most_points

    @property
    def tasks_at_once(self) -> int:
        """As many as there are stretches of the curve."""
        return STRETCHES

    @property
    def bytes(self) -> int:
        """Most bytes: phase and speed of each point."""
        return (self.order + 1) * self.most_points * 16

    def _settled(self) -> dict[str, Any]:
        if self.order < 0:
            raise InvalidJob(f"order must be 0 (the grazing curve itself) or more, not {self.order}", ("order",))
        if self.most_points < _LEAST_POINTS:
            raise InvalidJob(f"most_points must be {_LEAST_POINTS} or more, not {self.most_points}", ("most_points",))
        check_speeds(self.velocity)
        check_first(self.oscillator, self.first)
        names = ("kind_", "order", "velocity", "most_points", *(("first",) if self.first != FirstCurve.LOWER else ()))
        settled = {name: getattr(self, name) for name in names}
        return settled | {"resolution_": self.resolution_.settled_to()}

    @cached_property
    def resolution(self) -> CurveResolution:
        """How fine the curves are, checked."""
        return self.resolution_.value

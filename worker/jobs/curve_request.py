"""How fine the curves of a request are."""

from functools import cached_property
from typing import Annotated, Self

from pydantic import BeforeValidator, Field, model_validator

from rattle_kernels import CurveResolution, ManifoldLimits
from rattle_kernels.manifolds.polyline import check_resolution
from worker.errors import InvalidJob
from worker.jobs.request import Real, Request, accepting, told

_DEFAULT = CurveResolution()
Positive = Annotated[Real, told(exclusiveMinimum=0)]
MOST_POINTS = ManifoldLimits().points
"""Most points of a curve by default."""


class ResolutionRequest(Request):
    """How fine curves are, with speeds in units of the largest v*."""

    chord: Positive = Field(_DEFAULT.chord, description="Longest distance between neighbouring points")
    angle: Positive = Field(_DEFAULT.angle, description="Largest angle between chords, radians")
    finest: Positive = Field(
        _DEFAULT.finest, description="Chords shorter than this are not divided to make an angle smaller"
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

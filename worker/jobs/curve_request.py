"""How fine the curves of a request are."""

from typing import Annotated

from pydantic import BeforeValidator, Field

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

    def to_resolution(self) -> CurveResolution:
        """Resolution of the kernels, checked.

        Raises
        ------
        InvalidJob
        """
        try:
            return check_resolution(CurveResolution(self.chord, self.angle, self.finest))
        except ValueError as error:
            raise InvalidJob(str(error), ("resolution",)) from error


def resolution_request(resolution: CurveResolution) -> ResolutionRequest:
    """Resolution of the kernels as requests describe it, unchecked.

    Parameters
    ----------
    resolution : CurveResolution

    Returns
    -------
    ResolutionRequest
    """
    return ResolutionRequest.model_construct(**resolution._asdict())


Resolution = Annotated[ResolutionRequest, BeforeValidator(accepting(CurveResolution, resolution_request))]
"""From Python also a `CurveResolution`."""

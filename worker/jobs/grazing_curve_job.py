"""What to compute: the grazing curve and its pre-images."""

from dataclasses import dataclass
from typing import Any, ClassVar

from rattle_kernels import CurveResolution, check_impacting, check_resolution
from worker.errors import InvalidJob
from worker.jobs.analysis_job import AnalysisJob, check_velocity
from worker.jobs.oscillator_request import oscillator_from


@dataclass(frozen=True)
class GrazingCurveJob(AnalysisJob):
    """Pre-images of the grazing curve of the impacting model (Sec. 6.1).

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model.
    order : int
        Highest; 0 is the grazing curve itself.
    velocity : (float, float)
        Speeds to keep.
    resolution : CurveResolution
    most_points : int
        Of one order.
    """

    kind: ClassVar[str] = "grazing_curve"

    order: int = 2
    velocity: tuple[float, float] = (0.0, 7.0)
    resolution: CurveResolution = CurveResolution()
    most_points: int = 1_000_000

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "oscillator", check_impacting(self.oscillator))
        if self.order < 0:
            raise InvalidJob(f"order must be 0 (the grazing curve itself) or more, not {self.order}", ("order",))
        if self.most_points < 1000:
            raise InvalidJob(f"most_points must be 1000 or more, not {self.most_points}", ("most_points",))
        object.__setattr__(self, "velocity", tuple(float(speed) for speed in self.velocity))
        check_velocity(*self.velocity)
        try:
            object.__setattr__(self, "resolution", check_resolution(self.resolution))
        except ValueError as error:
            raise InvalidJob(str(error), ("resolution",)) from error

    def asked(self) -> dict[str, Any]:
        """What is asked about the oscillator, as JSON."""
        return {
            "order": self.order,
            "velocity": {"start": self.velocity[0], "stop": self.velocity[1]},
            "resolution": self.resolution._asdict(),
            "most_points": self.most_points,
        }

    @classmethod
    def from_request(cls, request: dict[str, Any]) -> "GrazingCurveJob":
        """Job that a request in the shape of `request` asks for."""
        velocity = request["velocity"]["start"], request["velocity"]["stop"]
        resolution = CurveResolution(**request["resolution"])
        return cls(
            oscillator_from(request["oscillator"]), request["order"], velocity, resolution, request["most_points"]
        )

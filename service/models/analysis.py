"""What the requests and results of analyses have in common."""

from typing import Any

from pydantic import BaseModel, Field

from service.models.oscillator import ImpactingOscillator, OscillatorRequest
from service.strict import Real, Request
from worker.jobs.analysis_job import Region


class SeedRequest(Request):
    """A departure from +beta to start from."""

    time: Real = Field(description="Phase t, forcing periods")
    velocity: Real = Field(description="Speed v of the departure, above 0")


class Interval(Request):
    """From where to where."""

    start: Real
    stop: Real


class RegionRequest(Request):
    """Window of the (t, v) plane in which something is looked for."""

    time: Interval = Field(default_factory=lambda: Interval(start=0.0, stop=1.0), description="Phases within 0 and 1")
    velocity: Interval = Field(default_factory=lambda: Interval(start=0.0, stop=7.0), description="Speeds of departure")

    def to_region(self) -> Region:
        """Region of the worker, not checked yet."""
        return Region(self.time.start, self.time.stop, self.velocity.start, self.velocity.stop)


class OscillatorsRequest(Request):
    """A request about one oscillator."""

    oscillator: OscillatorRequest = Field(default_factory=ImpactingOscillator)


class AnalysisView(BaseModel):
    """What all results of analyses say; a result that is not complete says so."""

    complete: bool
    request: dict[str, Any]
    pieces_done: int = Field(description="Parts of the work that are done and not yet put together; 0 when complete")
    seconds: dict[str, float] = Field(description="Time of the kernels in each stage, summed over pieces")
    zarr: str

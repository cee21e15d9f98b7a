from typing import Annotated, Any, Literal

from pydantic import Field

from worker.jobs.job import AnalysisJob


class ImpactSpeedsJob(AnalysisJob):
    """Impacts of one motion that departs from the upper wall."""

    kind_: Literal["impact_speeds"] = "impact_speeds"
    phase: float = Field(0.25, description="When it departs")
    speed: Annotated[float, Field(gt=0.0)] = Field(3.0, description="How fast it departs")
    periods: Annotated[int, Field(strict=True, ge=1)] = Field(20, description="Forcing periods")

    @property
    def fastest(self):
        """Its first speed."""
        return self.speed

    def sizes(self):
        """What is large about the request."""
        return (("periods", self.periods, "max_iterations"),)

    @property
    def impacts(self):
        """A few a period."""
        return 4 * self.periods

    @property
    def bytes(self):
        """Time, wall and speed of each impact."""
        return 4 * self.periods * 17

    def _settled(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in ("kind_", "phase", "speed", "periods")}

"""What to compute at once, without a job: one time history."""

from typing import Annotated, Any

from pydantic import AfterValidator, ConfigDict, Field

from rattle_kernels import Oscillator, OutsideDomain, TimeHistory, check_oscillator, check_quiet, time_history
from worker.errors import InvalidJob
from worker.jobs.oscillator_request import ImpactingOscillator, OscillatorRequest, check_quiet_unless_allowed
from worker.jobs.request import Count, Real, Request, as_real
from worker.precision_limits import check_decidable, check_fastest, fastest_resolved

# Bounds stand before the validator, or the schema lacks them.
_Displacement = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-1e6, le=1e6), AfterValidator(as_real)]
# Without a displacement the velocity is the speed of a departure.
_DEPARTURE: dict[str, Any] = {
    "if": {"properties": {"displacement": {"type": "number"}}, "required": ["displacement"]},
    "else": {"properties": {"velocity": {"exclusiveMinimum": 0}}},
}


class StartRequest(Request):
    """Initial condition; without a displacement, a departure from +beta."""

    model_config = ConfigDict(json_schema_extra=_DEPARTURE)

    time: Real = Field(0.0, ge=-1e6, le=1e6, description="t, forcing periods")
    displacement: _Displacement | None = Field(
        None, description="Phi; within the backlash in the impacting model. Without it, +beta is left"
    )
    velocity: Real = Field(
        ge=-1e6, le=1e6, description="Signed velocity Phi'; without a displacement, the speed v > 0 of the departure"
    )

    def state(self, oscillator: Oscillator) -> tuple[float, float, float]:
        """Initial t, Phi and Phi' of the kernels.

        Raises
        ------
        InvalidJob
            If a departure's speed is not positive.
        """
        if self.displacement is not None:
            return self.time, self.displacement, self.velocity
        if not self.velocity > 0.0:
            raise InvalidJob(
                f"velocity must be positive, not {self.velocity:g}: without a displacement it is the speed of a "
                "departure from +beta"
            )
        return self.time, oscillator.half_backlash, -self.velocity


class TrajectoryRequest(Request):
    """One time history."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [
                {
                    "oscillator": {"model": "piecewise_linear", "stiffness": 1000},
                    "start": {"time": 0.3, "velocity": 4},
                    "periods": 20,
                    "samples_per_period": 200,
                }
            ]
        },
    )

    oscillator: OscillatorRequest = Field(default_factory=ImpactingOscillator)
    start: StartRequest
    periods: Real = Field(20.0, gt=0, description="Span, forcing periods")
    samples_per_period: Count = Field(200, le=1_000_000)

    def follow(self, most_contacts: int = 100_000) -> TimeHistory:
        """Compute the history.

        Parameters
        ----------
        most_contacts : int
            The history is truncated after this many.

        Returns
        -------
        TimeHistory

        Raises
        ------
        OutsideDomain, InvalidJob
            Naming what is wrong.
        """
        oscillator = check_decidable(check_oscillator(self.oscillator.value))
        why = f"at half backlash {oscillator.half_backlash:g} double precision does not resolve shorter flights"
        check_fastest(abs(self.start.velocity), fastest_resolved(oscillator), why, ("start", "velocity"))
        check_quiet_unless_allowed(lambda: check_quiet(oscillator), allowed=self.oscillator.allow_no_quiet_solution)
        state = self.start.state(oscillator)
        try:
            return time_history(
                oscillator, *state, periods=self.periods, samples_per_period=self.samples_per_period,
                most_contacts=most_contacts,
            )  # fmt: skip
        except OutsideDomain:
            raise
        except ValueError as error:
            raise InvalidJob(str(error)) from error

"""One time history over HTTP: the request and the answer."""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from rattle_kernels import (
    Direction,
    Oscillator,
    Outcome,
    OutsideDomain,
    TimeHistory,
    check_domain,
    check_quiet,
    time_history,
)
from service.models.numbers import FiniteOrNone
from worker.errors import InvalidJob
from worker.jobs.oscillator_request import ImpactingOscillator, OscillatorRequest, demand_quiet
from worker.jobs.request import Count, Real, Request

_OUTCOMES: dict[Outcome, Literal["rattling", "permanent_contact", "undecided"]] = {
    Outcome.RETURNED: "rattling",
    Outcome.PERMANENT_CONTACT: "permanent_contact",
    Outcome.NOT_CONVERGED: "undecided",
}
_DIRECTIONS: dict[int, Literal["in", "out", "impact"]] = {
    Direction.IN: "in",
    Direction.OUT: "out",
    Direction.IMPACT: "impact",
}


def initial_state(
    oscillator: Oscillator, time: float, velocity: float, displacement: float | None
) -> tuple[float, float, float]:
    """Initial t, Phi, Phi'; without a displacement, those of a departure from +beta with speed `velocity`.

    Parameters
    ----------
    oscillator : Oscillator
    time, velocity : float
    displacement : float or None

    Returns
    -------
    tuple of float

    Raises
    ------
    InvalidJob
        If a departure's speed is not positive.
    """
    if displacement is not None:
        return time, displacement, velocity
    if not velocity > 0.0:
        raise InvalidJob(
            f"velocity must be positive, not {velocity:g}: without a displacement it is the speed of a departure "
            "from +beta"
        )
    return time, oscillator.half_backlash, -velocity


class StartRequest(Request):
    """Initial condition; without a displacement, a departure from +beta."""

    time: Real = Field(0.0, ge=-1e6, le=1e6, description="t, forcing periods")
    displacement: Real | None = Field(
        None, ge=-1e6, le=1e6, description="Phi; within the backlash in the impacting model. Without it, +beta is left"
    )
    velocity: Real = Field(
        ge=-1e6, le=1e6, description="Signed velocity Phi'; without a displacement, the speed v > 0 of the departure"
    )


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
    samples_per_period: Count = 200

    def follow(self, most_contacts: int) -> TimeHistory:
        """Compute the history.

        Parameters
        ----------
        most_contacts : int
            The history is truncated there.

        Returns
        -------
        TimeHistory

        Raises
        ------
        OutsideDomain, InvalidJob
            Naming what is wrong.
        """
        oscillator = check_domain(self.oscillator.to_oscillator())
        demand_quiet(lambda: check_quiet(oscillator), unless=self.oscillator.allow_no_quiet_solution)
        state = initial_state(oscillator, self.start.time, self.start.velocity, self.start.displacement)
        try:
            return time_history(
                oscillator, *state, periods=self.periods, samples_per_period=self.samples_per_period,
                most_contacts=most_contacts,
            )  # fmt: skip
        except OutsideDomain:
            raise
        except ValueError as error:
            raise InvalidJob(str(error)) from error


class ContactView(BaseModel):
    """A crossing of a backlash boundary, or an impact on it."""

    time: float
    wall: Literal[1, -1] = Field(description="+1: Phi = +beta, -1: Phi = -beta")
    direction: Literal["in", "out", "impact"] = Field(
        description="Beyond the wall, back into freeplay, or both at once"
    )
    speed: float


class TrajectoryView(BaseModel):
    """A time history. Every contact is among the samples; an impact is two of them, before and after."""

    time: list[float] = Field(description="Forcing periods, not reduced, never decreasing")
    displacement: list[float]
    velocity: list[float]
    contacts: list[ContactView]
    outcome: Literal["rattling", "permanent_contact", "undecided"] = Field(
        description="permanent_contact: within the span a contact has begun that counts as permanent, or ever lower "
        "bounces that never rattle again; undecided: a root-finder gave up where the history ends"
    )
    truncated: bool = Field(description="The history ends early, at the largest number of contacts allowed")
    permanent_from: FiniteOrNone = Field(
        description="When the contact begins that counts as permanent; null if there is none"
    )

    @classmethod
    def from_history(cls, history: TimeHistory) -> "TrajectoryView":
        """View of a history."""
        rows = zip(*(field.tolist() for field in history.contacts), strict=True)
        contacts = [
            ContactView(time=time, wall=wall, direction=_DIRECTIONS[direction], speed=speed)
            for time, wall, direction, speed in rows
        ]
        return cls(
            time=history.time.tolist(), displacement=history.displacement.tolist(), velocity=history.velocity.tolist(),
            contacts=contacts, outcome=_OUTCOMES[history.outcome], truncated=history.truncated,
            permanent_from=history.permanent_from,
        )  # fmt: skip

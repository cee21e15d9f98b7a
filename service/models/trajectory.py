"""One time history over HTTP."""

from typing import Literal

from pydantic import BaseModel, Field

from rattle_kernels import Direction, Outcome, TimeHistory
from service.models.numbers import FiniteOrNone

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

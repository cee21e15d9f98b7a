"""One time history over HTTP."""

from typing import Literal

from pydantic import BaseModel, Field

from rattle_kernels import AttractorKind, Direction, Outcome, TimeHistory
from service.models.numbers import FiniteOrNone
from worker.views.motion_end import MotionEnd

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
_ENDS: dict[AttractorKind, Literal["permanent_contact", "periodic"]] = {
    AttractorKind.PERMANENT_CONTACT: "permanent_contact",
    AttractorKind.PERIODIC: "periodic",
}


class ContactView(BaseModel):
    """A crossing of a backlash boundary, or an impact on it."""

    time: float
    wall: Literal[1, -1] = Field(description="+1: Phi = +beta, -1: Phi = -beta")
    direction: Literal["in", "out", "impact"] = Field(
        description="Beyond the wall, back into freeplay, or both at once"
    )
    speed: float


class RepeatedView(BaseModel):
    """What a motion nearly repeats at first, and leaves, as one that starts beside a saddle does."""

    name: str = Field(description="P(m,n+,n-)")
    periods: float = Field(description="Forcing periods from its start")


class MotionEndView(BaseModel):
    """What this very motion does in the end, as far as it was followed."""

    kind: Literal["rattling", "permanent_contact", "periodic"] = Field(
        description="rattling: it has settled on no attracting motion within the periods followed"
    )
    name: str | None = Field(description="Of the motion that it has settled on; null while it rattles without one")
    periods: float = Field(
        description="Forcing periods from its start until it has settled, or else all that were followed"
    )
    impacts: int = Field(description="Impacts within these periods")
    first: RepeatedView | None = Field(description="What it nearly repeats before; null if nothing")

    @classmethod
    def from_end(cls, end: MotionEnd) -> "MotionEndView":
        """View of an end."""
        kind = _ENDS[end.settled.kind] if end.settled else "rattling"
        name = end.settled.name if end.settled else None
        first = end.first and RepeatedView(**end.first._asdict())
        return cls(kind=kind, name=name, periods=end.periods, impacts=end.impacts, first=first)


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
    end: MotionEndView | None = Field(
        None, exclude_if=lambda end: end is None,
        description="What the motion does in the end; left out unless the query asks for it",
    )  # fmt: skip

    @classmethod
    def from_history(cls, history: TimeHistory, end: MotionEnd | None = None) -> "TrajectoryView":
        """View of a history, and of what its motion does in the end."""
        rows = zip(*(field.tolist() for field in history.contacts), strict=True)
        contacts = [
            ContactView(time=time, wall=wall, direction=_DIRECTIONS[direction], speed=speed)
            for time, wall, direction, speed in rows
        ]
        return cls(
            time=history.time.tolist(), displacement=history.displacement.tolist(), velocity=history.velocity.tolist(),
            contacts=contacts, outcome=_OUTCOMES[history.outcome], truncated=history.truncated,
            permanent_from=history.permanent_from, end=end and MotionEndView.from_end(end),
        )  # fmt: skip

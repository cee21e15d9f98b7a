"""Time histories Phi(t), Phi'(t) of both models from any initial condition: closed form, nothing is integrated.

The motion is followed piece by piece, then sampled at equal steps and at every contact, so that kinks are where they
belong. A piece is a flight in freeplay or a contact beyond +beta or -beta. Only its first end has to be searched for. A
contact of the impacting model lasts no time and reverses the velocity. The exception is rest on +beta, where the
forcing presses against the wall for ever.

*A flight from inside the backlash* is one that leaves a wall of a narrower backlash. A falling one has left an upper
wall at its own level, with the gap beta + Phi below. `flights.next_contact` finds whether it reaches -beta or comes
back to its level, from where it rises. A rising one has left a lower wall at its own level, with the gap beta - Phi
above. It grows strictly until it meets +beta, because every turning point in freeplay is a minimum (Eq. 8). *A contact
from inside* is `contact_end.follow_contact_from`.

Contacts are finitely many in any finite time, so following ends. In the piecewise linear model they could pile up only
at ``Phi = +-beta, Phi' = 0``. The acceleration is positive there (Eq. 8): the motion leaves such a point for good, as
it leaves any point where the acceleration is not zero. In the impacting model a bounce of duration tau at speed v has
``v = a tau/2 + O(tau^2)`` at both its ends, so each speed is ``1 + O(tau)`` times the one before. If infinitely many
tau summed up to a finite time, the product of these factors would stay away from zero, hence the speeds, hence tau. But
ever lower bounces shrink like ``e^{-delta t/3}``, and their number in a period grows accordingly. So the number of
contacts is bounded. Impacts that lose energy may be infinitely many within a finite time, after which the teeth stay
together: `_end_of_impact` ends them there.

*Beyond Eq. (8)* a flight goes from arc to arc (`arc_flights`). What is left of a chatter of the impacting model once
its bounces are too low to be seen is a rest, which lasts until the arc ends (`complete_chatter`). Contacts of the
piecewise linear model could pile up only where the acceleration is zero as well, at the ends of arcs.
"""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.adiabatic_invariant import capture_bound
from rattle_kernels.impact_map.arc_flights import next_loose_contact_from
from rattle_kernels.impact_map.chatter import is_captured
from rattle_kernels.impact_map.flights import LOWER, UPPER, FlightEnd, next_contact
from rattle_kernels.impact_map.loose_map import RELEASED, leave
from rattle_kernels.model.contact import enter_contact, state_in_contact
from rattle_kernels.model.contact_end import follow_contact_from
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.flight import displacement_rate, fall_speed, start_flight, velocity_after
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import (
    OUTCOME_NOT_CONVERGED,
    OUTCOME_PERMANENT_CONTACT,
    OUTCOME_RETURNED,
    Outcome,
)
from rattle_kernels.numerics.jit import chosen_by_field, inlined, kernel
from rattle_kernels.numerics.phase import part_turn

# Bounces as slow as this part of the scale of speeds, times 1 - r, take less than 1e-12 of a period all together.
_NO_BOUNCE = 1e-12
# Errors of a phase that is counted on over a rest add up to less: the gear leaves at the end of its arc or just behind.
_BEHIND = 2.0**-51
# The third regime, beside UPPER and LOWER.
FREEPLAY = 0.0


class MotionPiece(NamedTuple):
    """Beginning of a piece: its regime, phase (any value), displacement and velocity."""

    regime: float
    phase: float
    displacement: float
    velocity: float


class MotionPieceEnd(NamedTuple):
    """End of a piece: how long it lasts (infinite where it never ends), the piece after it, and an outcome code."""

    duration: float
    next_piece: MotionPiece
    outcome: int


@inlined
def _loose_rests_below(oscillator, velocity):
    return velocity == 0.0


@chosen_by_field("arcs", _loose_rests_below)
def _rests_below(oscillator, velocity):
    return False


@inlined
def piece_from(oscillator, phase, displacement, velocity):
    """Piece that begins with a state.

    At rest on a wall the forcing presses towards +beta (Eq. 8). A loose gear at rest on -beta is in contact first.
    """
    beta = oscillator.half_backlash
    regime = FREEPLAY
    if displacement > beta or (displacement == beta and velocity >= 0.0):
        regime = UPPER
    elif displacement < -beta or (displacement == -beta and (velocity < 0.0 or _rests_below(oscillator, velocity))):
        regime = LOWER
    return MotionPiece(regime, phase, displacement, velocity)


@inlined
def _with_gap(oscillator, gap):
    damping, eccentricity, _, _, _, restitution, contact_damping, harmonics = oscillator
    return Oscillator(damping, eccentricity, 0.5 * gap, math.inf, math.inf, restitution, contact_damping, harmonics)


@inlined
def _end_of_flight(oscillator, piece):
    """First contact of a flight from anywhere in freeplay."""
    beta = oscillator.half_backlash
    velocity = piece.velocity
    if velocity >= 0.0:
        return next_contact(_with_gap(oscillator, beta - piece.displacement), LOWER, piece.phase, velocity, 1.0)
    fall = next_contact(_with_gap(oscillator, beta + piece.displacement), UPPER, piece.phase, velocity, 1.0)
    if fall.wall == LOWER or piece.displacement == beta:
        return fall
    # Back at the level where it began; the rest of the flight rises.
    rise = next_contact(_with_gap(oscillator, beta - piece.displacement), LOWER, fall.phase, fall.velocity, 1.0)
    phase = math.floor(fall.phase + 0.5) + rise.phase
    return FlightEnd(UPPER, phase, fall.duration + rise.duration, rise.velocity, fall.found and rise.found)


@inlined
def _end_of_impact(oscillator, piece):
    """End of a contact of the impacting model.

    Bounces on +beta that lose energy are infinitely many in a finite time. Where what is left of it is nothing, contact
    begins.
    """
    restitution = oscillator.restitution
    velocity = restitution * piece.velocity
    if velocity <= _NO_BOUNCE * (1.0 - restitution) * fall_speed(oscillator):
        velocity = 0.0 if piece.regime == UPPER else velocity
    next_piece = MotionPiece(FREEPLAY, part_turn(piece.phase), piece.displacement, -velocity)
    if piece.regime == UPPER and velocity == 0.0:
        return MotionPieceEnd(math.inf, next_piece, OUTCOME_PERMANENT_CONTACT)
    return MotionPieceEnd(0.0, next_piece, OUTCOME_RETURNED)


@inlined
def _end_of_flight_piece(beta, end):
    """End of a piece in freeplay."""
    # Arriving at almost no speed, rounding may leave the wrong sign of nothing.
    into = end.wall * max(end.wall * end.velocity, 0.0)
    next_piece = MotionPiece(end.wall, end.phase, end.wall * beta, into)
    return MotionPieceEnd(end.duration, next_piece, OUTCOME_RETURNED if end.found else OUTCOME_NOT_CONVERGED)


@inlined
def _end_of_contact(oscillator, piece):
    """First end of a contact of the piecewise linear model, by the exact rule."""
    beta, side = oscillator.half_backlash, piece.regime
    exact = Oscillator(
        oscillator.damping, oscillator.eccentricity, beta, oscillator.stiffness, math.inf, oscillator.restitution,
        oscillator.contact_damping, oscillator.harmonics,
    )  # fmt: skip
    contact = follow_contact_from(exact, side, piece.phase, side * piece.displacement - beta, side * piece.velocity)
    next_piece = MotionPiece(FREEPLAY, part_turn(piece.phase) + contact.duration, side * beta, -side * contact.speed)
    duration = math.inf if contact.outcome == OUTCOME_PERMANENT_CONTACT else contact.duration
    return MotionPieceEnd(duration, next_piece, contact.outcome)


@inlined
def _end_of_loose_piece(oscillator, piece):
    """`end_of_piece` beyond Eq. (8): an impact lasts no time, or until a release."""
    beta, side = oscillator.half_backlash, piece.regime
    if side == FREEPLAY:
        above, below = beta - piece.displacement, beta + piece.displacement
        return _end_of_flight_piece(
            beta, next_loose_contact_from(oscillator, above, below, piece.phase, piece.velocity)
        )
    if math.isfinite(oscillator.stiffness):
        return _end_of_contact(oscillator, piece)
    restitution = oscillator.restitution
    no_bounce = _NO_BOUNCE * (1.0 - restitution) * fall_speed(oscillator)
    leaves = leave(oscillator, side, piece.phase, restitution * abs(piece.velocity), no_bounce)
    phase = part_turn(piece.phase) + (leaves.after + _BEHIND if leaves.rests else 0.0)
    speed = leaves.speed if leaves.speed > RELEASED else 0.0
    outcome = OUTCOME_RETURNED if math.isfinite(leaves.after) else OUTCOME_PERMANENT_CONTACT
    return MotionPieceEnd(leaves.after, MotionPiece(FREEPLAY, phase, side * beta, -side * speed), outcome)


@chosen_by_field("arcs", _end_of_loose_piece)
def end_of_piece(oscillator, piece):
    """Follow a piece to its first end.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller. A contact is followed by the exact rule, whatever ``permanent_after`` says.
    piece : MotionPiece

    Returns
    -------
    MotionPieceEnd
        Outcome RETURNED where the piece ends, PERMANENT_CONTACT where it never does, or NOT_CONVERGED. The phase
        of the next piece counts on from that of this one less its nearest whole number.
    """
    if piece.regime == FREEPLAY:
        return _end_of_flight_piece(oscillator.half_backlash, _end_of_flight(oscillator, piece))
    return _end_of_impact(oscillator, piece) if math.isinf(oscillator.stiffness) else _end_of_contact(oscillator, piece)


@inlined
def flight_along(oscillator, piece, elapsed, displacement, velocity):
    """Write the state of a flight at some times after its beginning, all positive, into the two arrays."""
    flight = start_flight(oscillator, piece.phase, piece.velocity)
    for i in range(elapsed.size):
        change = elapsed[i] * displacement_rate(flight, elapsed[i])
        displacement[i] = piece.displacement + change
        velocity[i] = velocity_after(flight, elapsed[i], change)


@inlined
def contact_along(oscillator, piece, elapsed, displacement, velocity):
    """Write the state of a contact at some times after its beginning into the two arrays."""
    side, beta = piece.regime, oscillator.half_backlash
    if math.isinf(oscillator.stiffness):
        displacement[:], velocity[:] = piece.displacement, 0.0  # a rest: other contacts last no time
        return
    entered = enter_contact(oscillator, side, piece.phase, side * piece.displacement - beta, side * piece.velocity)
    for i in range(elapsed.size):
        state = state_in_contact(entered, elapsed[i])
        displacement[i] = side * (beta + state.depth)
        velocity[i] = side * state.rate


# Columns of the list of pieces.
_BEGIN, _REGIME, _PHASE, _DISPLACEMENT, _VELOCITY = range(5)


class Direction(IntEnum):
    """What happens at a wall. A contact of the impacting model has no duration and is one event."""

    OUT = -1
    """Back into freeplay."""
    IMPACT = 0
    """There and back at once."""
    IN = 1
    """Beyond the wall."""


class Contacts(NamedTuple):
    """What happens at the walls, in order; arrays of one shape.

    ``time`` counts forcing periods and is not reduced. ``wall`` is +1 or -1. ``direction`` holds `Direction` codes.
    ``speed`` is the speed of crossing, or of arrival at an impact. A rest of a loose gear begins with IN and ends with
    OUT, the release.
    """

    time: np.ndarray
    wall: np.ndarray
    direction: np.ndarray
    speed: np.ndarray


class TimeHistory(NamedTuple):
    """A motion, sampled.

    ``time`` (forcing periods, not reduced) never decreases. Every contact is among the samples; an impact is two
    samples at one time, with the velocity before and after. ``outcome`` is RETURNED, PERMANENT_CONTACT (seen to begin
    within the span) or NOT_CONVERGED. ``truncated`` says that the history ends at a contact before its goal: there were
    more contacts than allowed, or a root-finder gave up. ``permanent_from`` is the time from which contact counts as
    permanent, infinite where it never does.
    """

    time: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    contacts: Contacts
    outcome: Outcome
    truncated: bool
    permanent_from: float

    @property
    def departures(self) -> np.ndarray:
        """Indices of the contacts that are departures from +beta; an impact leaves r times its speed to the next."""
        contacts = self.contacts
        return np.flatnonzero((contacts.wall > 0) & (contacts.direction != Direction.IN))


class _Followed(NamedTuple):
    """How following ended: pieces, end of the last one, outcome, whether the goal was missed, when it is permanent."""

    pieces: int
    end: float
    outcome: int
    truncated: bool
    permanent_from: float


@inlined
def _is_permanent(oscillator, capture_bound, piece, duration):
    """Whether a piece is permanent contact by the oscillator's rule, or captured (impacting model)."""
    if piece.regime == UPPER:
        return duration > oscillator.permanent_after or math.isinf(duration)
    leaves_upper = piece.regime == FREEPLAY and piece.displacement == oscillator.half_backlash
    return leaves_upper and is_captured(oscillator, capture_bound, piece.phase, -piece.velocity)


@kernel
def _follow(oscillator, capture_bound, state, span, departures, pieces):
    """Fill the list of pieces until the span has passed, or departures are reached, or the list is full."""
    piece = piece_from(oscillator, *state)
    first, whole, left = piece.phase, 0.0, 0
    outcome, permanent_from = OUTCOME_RETURNED, math.inf
    for i in range(pieces.shape[0]):
        begin = whole + piece.phase
        pieces[i] = (begin, piece.regime, piece.phase, piece.displacement, piece.velocity)
        left += 1 if i > 0 and piece.regime == FREEPLAY and piece.displacement == oscillator.half_backlash else 0
        ended = end_of_piece(oscillator, piece)
        if ended.outcome == OUTCOME_NOT_CONVERGED:
            return _Followed(i + 1, begin, OUTCOME_NOT_CONVERGED, True, permanent_from)
        if _is_permanent(oscillator, capture_bound, piece, ended.duration):
            outcome, permanent_from = OUTCOME_PERMANENT_CONTACT, min(permanent_from, begin)
        if left == departures:
            return _Followed(i + 1, begin, outcome, False, permanent_from)
        if math.isinf(ended.duration):
            end = first + span if math.isfinite(span) else begin
            return _Followed(i + 1, end, outcome, False, permanent_from)
        whole += math.floor(piece.phase + 0.5)
        regime, phase, displacement, velocity = ended.next_piece
        turns = math.floor(phase)
        whole += turns
        piece = MotionPiece(regime, phase - turns, displacement, velocity)
        if whole + piece.phase > first + span:
            return _Followed(i + 1, first + span, outcome, False, permanent_from)
    return _Followed(pieces.shape[0], pieces[-1, _BEGIN], outcome, True, permanent_from)


@inlined
def _sample_piece(oscillator, row, elapsed, displacement, velocity):
    piece = MotionPiece(row[_REGIME], row[_PHASE], row[_DISPLACEMENT], row[_VELOCITY])
    if piece.regime == FREEPLAY:
        flight_along(oscillator, piece, elapsed, displacement, velocity)
    else:
        contact_along(oscillator, piece, elapsed, displacement, velocity)


@kernel
def _sample(oscillator, pieces, end, samples_per_period, time, displacement, velocity):
    """Sample the pieces at their beginnings, at equal steps between, and at the end; return the number of samples."""
    first = pieces[0, _BEGIN]
    ticks, filled = 0, 0
    for i in range(pieces.shape[0]):
        last = i + 1 == pieces.shape[0]
        begin, stop = pieces[i, _BEGIN], end if last else pieces[i + 1, _BEGIN]
        time[filled], displacement[filled], velocity[filled] = begin, pieces[i, _DISPLACEMENT], pieces[i, _VELOCITY]
        filled += 1
        inside = filled
        while first + ticks / samples_per_period < stop:
            tick = first + ticks / samples_per_period
            ticks += 1
            if tick > begin:
                time[filled] = tick
                filled += 1
        if last and end > begin:
            time[filled] = end
            filled += 1
        here = slice(inside, filled)
        _sample_piece(oscillator, pieces[i], time[here] - begin, displacement[here], velocity[here])
    return filled


def _contacts(oscillator: Oscillator, pieces: np.ndarray, end: float, shift: float) -> Contacts:
    """Contacts: where all pieces but the first begin; in the impacting model, where the flights among them begin.

    Contacts of the impacting model that last are rests of a loose gear.
    """
    free = pieces[:, _REGIME] == FREEPLAY
    direction, kept = np.where(free, Direction.OUT, Direction.IN), np.ones(len(pieces), bool)
    if math.isinf(oscillator.stiffness):
        rests = ~free & (np.diff(pieces[:, _BEGIN], append=end) > 0.0) & oscillator.is_loose
        direction = np.where(rests, Direction.IN, np.where(np.roll(rests, 1), Direction.OUT, Direction.IMPACT))
        kept = free | rests
    kept[0] = False
    later, direction = pieces[kept], direction[kept].astype(np.int8)
    wall = np.sign(later[:, _DISPLACEMENT]).astype(np.int8)
    # A flight begins with what its impact has left of the speed.
    speed = np.abs(later[:, _VELOCITY]) / np.where(direction == Direction.IMPACT, oscillator.restitution, 1.0)
    return Contacts(later[:, _BEGIN] + shift, wall, direction, speed)


def _check_start(oscillator: Oscillator, state: tuple[float, float, float]) -> None:
    for name, value in zip(("time", "displacement", "velocity"), state, strict=True):
        if not math.isfinite(value):
            raise ValueError(f"{name} must be finite, not {value}")
    if math.isinf(oscillator.stiffness) and abs(state[1]) > oscillator.half_backlash:
        raise ValueError(
            f"displacement must lie within the backlash, at most {oscillator.half_backlash:g} either way, "
            f"not {state[1]:g}: nothing lies beyond the walls of the impacting model"
        )


def _check_goal(periods: float, departures: int | None, samples_per_period: int, most_contacts: int) -> None:
    if not periods >= 0.0:
        raise ValueError(f"periods must not be negative, not {periods}")
    if math.isinf(periods) and departures is None:
        raise ValueError("say how far to follow: a finite number of periods, or a number of departures")
    counts = {"samples_per_period": samples_per_period, "most_contacts": most_contacts}
    if departures is not None:
        counts["departures"] = departures
    for name, count in counts.items():
        if count < 1:
            raise ValueError(f"{name} must be at least 1, not {count}")


def time_history(
    oscillator: Oscillator, time: float, displacement: float, velocity: float, *, periods: float = math.inf,
    departures: int | None = None, samples_per_period: int = 200, most_contacts: int = 100_000,
) -> TimeHistory:  # fmt: skip
    """Follow a motion of either model from any initial condition.

    Parameters
    ----------
    oscillator : Oscillator
        Infinite stiffness for the impacting model.
    time, displacement, velocity : float
        Initial condition: t (forcing periods), Phi and the signed velocity Phi'. A departure from +beta of speed v is
        ``(t, +beta, -v)``. A start on a wall is no contact, except one of the impacting model that moves into it.
    periods : float
        Span to follow, forcing periods. It may be infinite where ``departures`` ends the history.
    departures : int, optional
        The history ends with this many departures from +beta, unless the span ends before. Without a span it also
        ends where a contact begins that never ends.
    samples_per_period : int
        Equal steps; every contact is sampled as well.
    most_contacts : int
        The history is truncated at this many contacts.

    Returns
    -------
    TimeHistory
        Contacts are followed by the exact rule; ``permanent_after`` only decides what the outcome calls permanent.

    Raises
    ------
    OutsideDomain
        Where the oscillator's parameters lie outside the domain.
    ValueError
        Where the initial condition or the goal is not valid.

    Examples
    --------
    >>> history = time_history(Oscillator(), 0.25, 0.6, -1.0, periods=3)
    >>> history.contacts.wall[0], round(float(history.time[-1]), 3)
    (np.int8(1), 3.25)
    """
    checked = check_oscillator(oscillator)
    _check_start(checked, (time, displacement, velocity))
    _check_goal(periods, departures, samples_per_period, most_contacts)
    impacting = math.isinf(checked.stiffness)
    # Times count from the last whole period before the start, so that they keep their digits however late it is.
    shift = math.floor(time)
    rows = np.empty((2 * most_contacts + 1 if impacting else most_contacts + 1, 5))
    bound = capture_bound(checked) if impacting else 0.0
    state = (float(time) - shift, float(displacement), float(velocity))
    followed = _follow(checked, bound, state, float(periods), -1 if departures is None else departures, rows)
    pieces = rows[: followed.pieces].copy()
    room = int((followed.end - pieces[0, _BEGIN]) * samples_per_period) + len(pieces) + 3
    samples = tuple(np.empty(room) for _ in range(3))
    filled = _sample(checked, pieces, followed.end, samples_per_period, *samples)
    t, phi, rate = (array[:filled].copy() for array in samples)
    outcome = Outcome(followed.outcome)
    return TimeHistory(
        t + shift, phi, rate, _contacts(checked, pieces, followed.end, shift), outcome, followed.truncated,
        followed.permanent_from + shift,
    )  # fmt: skip

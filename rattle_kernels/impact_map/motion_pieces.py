"""The pieces of a motion in both models, from anywhere: where each ends, and where it is at any time before.

A piece is a flight in freeplay or a contact beyond +beta or -beta. Both are known in closed form; only the first end
has to be searched for. A contact of the impacting model lasts no time and reverses the velocity. The exception is rest
on +beta, where the forcing presses against the wall for ever.

*A flight from inside the backlash* is one that leaves a wall of a narrower backlash. A falling one has left an upper
wall at its own level, with the gap beta + Phi below. `flights.next_contact` finds whether it reaches -beta or comes
back to its level, from where it rises. A rising one has left a lower wall at its own level, with the gap beta - Phi
above. It grows strictly until it meets +beta, because every turning point in freeplay is a minimum (Eq. 8).

*A contact from inside* is `model.contact.follow_contact_from`.
"""

import math
from typing import NamedTuple

from rattle_kernels.impact_map.flights import LOWER, UPPER, FlightEnd, next_contact
from rattle_kernels.model.contact import enter_contact, state_in_contact
from rattle_kernels.model.contact_end import follow_contact_from
from rattle_kernels.model.flight import displacement_rate, fall_speed, start_flight, velocity_after
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_NOT_CONVERGED, OUTCOME_PERMANENT_CONTACT, OUTCOME_RETURNED
from rattle_kernels.numerics.jit import inlined
from rattle_kernels.numerics.phase import part_turn

# Bounces as slow as this part of the scale of speeds, times 1 - r, take less than 1e-12 of a period all together.
_NO_BOUNCE = 1e-12
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
def piece_from(oscillator, phase, displacement, velocity):
    """Piece that begins with a state. At rest on a wall the forcing presses towards +beta (Eq. 8)."""
    beta = oscillator.half_backlash
    regime = FREEPLAY
    if displacement > beta or (displacement == beta and velocity >= 0.0):
        regime = UPPER
    elif displacement < -beta or (displacement == -beta and velocity < 0.0):
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
    damping, eccentricity, beta, stiffness, _, restitution, contact_damping, harmonics = oscillator
    side = piece.regime
    if side == FREEPLAY:
        end = _end_of_flight(oscillator, piece)
        # Arriving at almost no speed, rounding may leave the wrong sign of nothing.
        into = end.wall * max(end.wall * end.velocity, 0.0)
        next_piece = MotionPiece(end.wall, end.phase, end.wall * beta, into)
        return MotionPieceEnd(end.duration, next_piece, OUTCOME_RETURNED if end.found else OUTCOME_NOT_CONVERGED)
    if math.isinf(stiffness):
        return _end_of_impact(oscillator, piece)
    exact = Oscillator(damping, eccentricity, beta, stiffness, math.inf, restitution, contact_damping, harmonics)
    contact = follow_contact_from(exact, side, piece.phase, side * piece.displacement - beta, side * piece.velocity)
    next_piece = MotionPiece(FREEPLAY, part_turn(piece.phase) + contact.duration, side * beta, -side * contact.speed)
    duration = math.inf if contact.outcome == OUTCOME_PERMANENT_CONTACT else contact.duration
    return MotionPieceEnd(duration, next_piece, contact.outcome)


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
        displacement[:] = piece.displacement  # at rest: other contacts last no time
        velocity[:] = 0.0
        return
    entered = enter_contact(oscillator, side, piece.phase, side * piece.displacement - beta, side * piece.velocity)
    for i in range(elapsed.size):
        state = state_in_contact(entered, elapsed[i])
        displacement[i] = side * (beta + state.depth)
        velocity[i] = side * state.rate

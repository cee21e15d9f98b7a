"""The pieces of a motion in both models, from anywhere: where each ends, and where it is at any time before.

A piece is a flight in freeplay or a stay beyond +beta or -beta. Both are known in closed form; what has to be searched
is only the first end. A stay of the impacting model lasts no time and reverses the velocity, save at rest on +beta,
where the forcing presses against the wall for ever.

*A flight from inside the backlash* is one that leaves a wall of a narrower backlash. Falling, it has left an upper wall
at its own level with the gap beta + Phi below, and `impact_map.next_contact` says for sure whether it reaches -beta or
comes back to its level; it then rises. Rising, it has left a lower wall at its own level with the gap beta - Phi above,
and grows strictly until it meets +beta, because every turning point in freeplay is a minimum (Eq. 8).

*A stay from inside* is `contact_flight.rest_of_stay`.
"""

import math
from typing import NamedTuple

from rattle_kernels.impact_map.apply import LOWER, NOT_CONVERGED, RETURNED, UPPER, Contact, next_contact
from rattle_kernels.model.contact import enter_contact, motion_in_contact, rest_of_stay
from rattle_kernels.model.flight import displacement_rate, part_turn, start_flight, velocity_after
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import Outcome
from rattle_kernels.numerics.jit import inlined

PERMANENT_CONTACT = int(Outcome.PERMANENT_CONTACT)
# The third regime, beside UPPER and LOWER.
FREEPLAY = 0.0


class Piece(NamedTuple):
    """Beginning of a piece: its regime, phase (any value), displacement and velocity."""

    regime: float
    phase: float
    displacement: float
    velocity: float


class PieceEnd(NamedTuple):
    """End of a piece: how long it lasts (infinite where it never ends), the piece after it, and an outcome code."""

    duration: float
    following: Piece
    outcome: int


@inlined
def piece_from(oscillator, phase, displacement, velocity):
    """Piece that a state begins; on a wall at rest the forcing presses towards +beta (Eq. 8)."""
    beta = oscillator.half_backlash
    regime = FREEPLAY
    if displacement > beta or (displacement == beta and velocity >= 0.0):
        regime = UPPER
    elif displacement < -beta or (displacement == -beta and velocity < 0.0):
        regime = LOWER
    return Piece(regime, phase, displacement, velocity)


@inlined
def _with_gap(oscillator, gap):
    return Oscillator(oscillator.damping, oscillator.eccentricity, 0.5 * gap, math.inf, math.inf)


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
    return Contact(UPPER, phase, fall.duration + rise.duration, rise.velocity, fall.found and rise.found)


@inlined
def _end_of_impact(piece):
    """End of a stay of the impacting model."""
    following = Piece(FREEPLAY, part_turn(piece.phase), piece.displacement, -piece.velocity)
    if piece.regime == UPPER and piece.velocity == 0.0:
        return PieceEnd(math.inf, following, PERMANENT_CONTACT)
    return PieceEnd(0.0, following, RETURNED)


@inlined
def end_of_piece(oscillator, piece):
    """Follow a piece to its first end.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller. A stay is followed by the exact rule, whatever ``permanent_after`` says.
    piece : Piece

    Returns
    -------
    PieceEnd
        Outcome RETURNED where the piece ends, PERMANENT_CONTACT where it never does, or NOT_CONVERGED. The phase after
        it counts on from that before it less its nearest whole number.
    """
    damping, eccentricity, beta, stiffness, _ = oscillator
    side = piece.regime
    if side == FREEPLAY:
        contact = _end_of_flight(oscillator, piece)
        # Arriving at almost no speed, round-off may leave the wrong sign of nothing.
        into = contact.wall * max(contact.wall * contact.velocity, 0.0)
        following = Piece(contact.wall, contact.phase, contact.wall * beta, into)
        return PieceEnd(contact.duration, following, RETURNED if contact.found else NOT_CONVERGED)
    if math.isinf(stiffness):
        return _end_of_impact(piece)
    exact = Oscillator(damping, eccentricity, beta, stiffness, math.inf)
    stay = rest_of_stay(exact, side, piece.phase, side * piece.displacement - beta, side * piece.velocity)
    following = Piece(FREEPLAY, part_turn(piece.phase) + stay.duration, side * beta, -side * stay.speed)
    duration = math.inf if stay.outcome == PERMANENT_CONTACT else stay.duration
    return PieceEnd(duration, following, stay.outcome)


@inlined
def fly_along(oscillator, piece, elapsed, displacement, velocity):
    """State of a flight at times after its beginning, all positive, into the two arrays."""
    flight = start_flight(oscillator, piece.phase, piece.velocity)
    for i in range(elapsed.size):
        change = elapsed[i] * displacement_rate(flight, elapsed[i])
        displacement[i] = piece.displacement + change
        velocity[i] = velocity_after(flight, elapsed[i], change)


@inlined
def stay_along(oscillator, piece, elapsed, displacement, velocity):
    """State of a stay at times after its beginning, into the two arrays."""
    side, beta = piece.regime, oscillator.half_backlash
    if math.isinf(oscillator.stiffness):
        displacement[:] = piece.displacement  # at rest: others last no time
        velocity[:] = 0.0
        return
    contact = enter_contact(oscillator, side, piece.phase, side * piece.displacement - beta, side * piece.velocity)
    for i in range(elapsed.size):
        motion = motion_in_contact(contact, elapsed[i])
        displacement[i] = side * (beta + motion.depth)
        velocity[i] = side * motion.rate

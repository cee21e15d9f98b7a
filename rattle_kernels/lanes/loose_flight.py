"""One flight of every lane of a loose gear, and the contact at its end.

A flight is followed from arc to arc as in `arc_flights`, with the same brackets. To know how far they are, all lanes
that fly are evaluated side by side, each at one time: the end of an arc (`_ARC`), a guessed turning point (`_TURN`) or
a guessed contact (`_ROOT`). Then each decides for itself at which time it is looked at next. Those that fly are kept
together at the front of a buffer, so what has arrived costs nothing.

Bounces that may accumulate are followed in the same way until that is certain (`complete_chatter`). If they do not, the
first of them is the next departure, and the lane remembers that its bounces need not be followed again.

Contacts of finite stiffness are followed one by one by the scalar path: their ends have no table of guesses here.

What is too close to call is left to the scalar path: an end of an arc next to a wall or to a turning point, a graze.

The fields of the lanes are those of `flight`. A motion that chatters to rest departs next at its release: its time
includes the bounces and the rest, and its speed of arrival is that of the first of them.
"""

import math
from typing import NamedTuple

from rattle_kernels.impact_map.arc_flights import next_loose_contact
from rattle_kernels.impact_map.complete_chatter import accumulates, is_sure_to_rest
from rattle_kernels.impact_map.flights import LOWER, UPPER
from rattle_kernels.impact_map.loose_map import RELEASED, leave, leave_contact
from rattle_kernels.lanes.flight import evaluate, fifth_order_step, turn_phases
from rattle_kernels.lanes.harmonics import (
    RATE_1,
    RATE_2,
    RATE_3,
    bounds_on_error,
    highest_order,
    plus,
    plus_acceleration_after,
    plus_error,
    plus_rate_after,
    turn,
)
from rattle_kernels.lanes.lane_fields import (
    COSINE,
    COSINE_CHANGE,
    DROPS,
    DURATION,
    END_ACCELERATION,
    END_PHASE,
    END_VELOCITY,
    FLIGHT_FIELDS,
    IDLE_SPEED,
    LANES,
    MISS,
    PHASE,
    RATE,
    SINE,
    SINE_CHANGE,
    TARGET,
    VELOCITY,
    unset_lane_buffer,
)
from rattle_kernels.model.flight import FOUR_PI, TWO_PI
from rattle_kernels.numerics.jit import always_inlined, chosen_by_field, inlined
from rattle_kernels.numerics.phase import part_turn, wrap
from rattle_kernels.numerics.polynomials import second_phi_of_part

# Fields of the lanes that no other flight of a loose gear uses: how long it has rested (0 where it has not), its speed
# of arrival, and a departure whose bounces are known not to accumulate.
_REST, _ARRIVAL, _KNOWN_PHASE, _KNOWN_VELOCITY = SINE, COSINE, SINE_CHANGE, COSINE_CHANGE
# Time left on the arc for the bounces that are followed; negative where none are.
_LEFT = TARGET
# Fields of those that fly, beside those of a flight: second to fourth derivative, the step to the target, its last
# term. They lie in a buffer of their own, where that of the lanes has the ends of flights.
_BEND, _JERK, _SNAP, _STEP, _LAST = END_PHASE, END_VELOCITY, END_ACCELERATION, DROPS, DROPS + LANES

# Fields of all lanes, in their own order: the piece on which each flies, the row of its arc's end in the table, what is
# to be added to the phase there to have a time, the first such end, what is looked for, and how often it was.
_BEGIN, _BEGIN_AT, _BEGIN_RATE, _END, _END_AT, _END_RATE, _WAY, _ROW_AT, _BASE, _ARC_END, _MODE, _LOOKS_SO_FAR = (
    (FLIGHT_FIELDS + n) * LANES for n in range(12)
)
# e and e' where the flight has begun.
_ERROR, _ERROR_RATE = ((FLIGHT_FIELDS + n) * LANES for n in (12, 13))
_FIELDS = FLIGHT_FIELDS + 14
# Behind the fields is a table. It has a row for each end of an arc: its phase, e and e' there, the sign of a(t) before.
_TABLE, _ROW = _FIELDS * LANES, 4

_ARC, _TURN, _ROOT = 0, 1, 2
_UNSURE, _LOOKS, _PASSES, _ARRIVES = 0, 1, 2, 3
# Evaluated side by side, with none left over, whose arithmetic would be another.
_BLOCK = 8
# A number that comes from memory is an index below this, so the compiler need not mind one below 0.
_INDEX = 0xFFFFFF
_MOST_LOOKS = 60
# Of what is compared. What is closer than that is left to the scalar path.
_CLOSE = 1e-11
_SUM = 1e-13
# Of a duration: what a step leaves out is less than its last term.
_LAST_TERM = 1e-13
_LARGEST_STEP = 4e-3
# Of a period of the highest order: so far Taylor's polynomial of fourth order about a guess holds.
_NEAR_TURN = 0.08
# Beyond it the series of a step is no use.
_SERIES = 0.3


class _Machine(NamedTuple):
    """Numbers of an oscillator that decisions need, bounds on ``|a|``, ``|a'|``, ``|e|`` and ``|e'|`` among them.

    Arrays are no part of it: taking one out of a tuple counts references, with other processors locked out.
    """

    after_last: int
    damping: float
    two_beta: float
    restitution: float
    strongest: float
    change: float
    error: float
    error_rate: float
    highest: float


class _Piece(NamedTuple):
    """Part of a flight on one arc: state at its beginning and at its end, displacements from the wall that was left.

    It ends with the arc, or at a turning point that lies beyond a wall. The gear moves in the direction ``way`` to what
    is looked for.
    """

    velocity: float
    begin: float
    begin_at: float
    begin_rate: float
    end: float
    end_at: float
    end_rate: float
    way: float


class _Seen(NamedTuple):
    """What a lane sees at the time at which it is evaluated."""

    tau: float
    miss: float
    rate: float
    bend: float
    jerk: float
    snap: float
    step: float
    last: float


class _Next(NamedTuple):
    """What comes next for a lane: at which time it is looked at, for what, and on which piece."""

    comes: int
    mode: int
    target: float
    tau: float
    piece: _Piece


@inlined
def _wall_ahead(machine, velocity, way):
    """Displacement from the wall that was left, at the wall towards which a gear goes."""
    if velocity < 0.0:
        return 0.0 if way > 0.0 else -machine.two_beta
    return machine.two_beta if way > 0.0 else 0.0


@inlined
def _closeness(machine, velocity, tau):
    """Of what displacements are made, the part by which they have to differ."""
    return _CLOSE * tau * (abs(velocity) + machine.strongest * tau)


@inlined
def _rounding(machine, velocity, tau):
    """Bounds on what rounding does to a displacement and a velocity that are sums of large terms."""
    largest = FOUR_PI + machine.error_rate + abs(velocity)
    return _SUM * (largest * tau + machine.error), _SUM * largest


@inlined
def _ends_unsure(piece):
    return _Next(_UNSURE, _ARC, 0.0, 0.0, piece)


@inlined
def _after_turn(machine, piece, way, rounding):
    """Next look at a piece that turns before it meets a wall: it may meet that behind before it ends."""
    back, span = -way, piece.end - piece.begin
    wall = _wall_ahead(machine, piece.velocity, back)
    beyond = back * (piece.end_at - wall)
    if abs(beyond) <= _closeness(machine, piece.velocity, piece.end) + rounding:
        return _ends_unsure(piece)
    if beyond < 0.0:
        return _Next(_PASSES, _ARC, 0.0, 0.0, piece)
    if wall == 0.0 and piece.begin == 0.0:
        # From the wall and back: y/tau as a parabola through its values and slopes at both ends.
        first = piece.velocity
        mean, change = piece.end_at / span - first, piece.end_rate - first
        half, twist = 0.5 * (3.0 * mean - change) / span, (change - 2.0 * mean) / (span * span)
        root = math.sqrt(max(half * half - first * twist, 0.0))
        tau = -first / (half + (root if half > 0.0 else -root))
    else:
        pull, rate = back * (piece.end_rate - piece.begin_rate) / span, abs(piece.end_rate)
        tau = piece.end - 2.0 * beyond / (rate + math.sqrt(max(rate * rate - 2.0 * pull * beyond, 0.0)))
    if not piece.begin < tau < piece.end:
        tau = 0.5 * (piece.begin + piece.end)
    towards = _Piece(
        piece.velocity, piece.begin, piece.begin_at, piece.begin_rate, piece.end, piece.end_at, piece.end_rate, back
    )
    return _Next(_LOOKS, _ROOT, wall, tau, towards)


@inlined
def _at_arc_end(machine, piece, sign, end, at, rate, rounding):
    """Next look after the end of an arc on which a(t) has this sign; state there, with the errors of both."""
    velocity, begin, begin_at = piece.velocity, piece.begin, piece.begin_at
    speed, span = abs(piece.begin_rate), end - begin
    if not abs(rate) > _CLOSE * (abs(velocity) + machine.strongest * end) + rounding[1]:
        return _ends_unsure(piece)
    way = 1.0 if piece.begin_rate > 0.0 else -1.0
    whole = _Piece(velocity, begin, begin_at, piece.begin_rate, end, at, rate, way)
    wall = _wall_ahead(machine, velocity, way)
    left, close = way * (wall - begin_at), _closeness(machine, velocity, end) + rounding[0]
    if sign == way or sign * rate < 0.0:
        beyond = way * (at - wall)
        if abs(beyond) <= close:
            return _ends_unsure(whole)
        if beyond < 0.0:
            return _Next(_PASSES, _ARC, 0.0, 0.0, whole)
        # A parabola through both ends, with the right slope at the beginning.
        half_pull = (way * (at - begin_at) - speed * span) / (span * span)
        tau = begin + 2.0 * left / (speed + math.sqrt(max(speed * speed + 4.0 * half_pull * left, 0.0)))
        return _Next(_LOOKS, _ROOT, wall, tau if begin < tau < end else 0.5 * (begin + end), whole)
    # It turns. Before that it is below its tangent at the beginning. After it, seen from the end, the speed was
    # e^(delta span) times that at the end, at most. So the turning point is below where these two lines meet.
    fastest = abs(rate) * (1.0 + 2.0 * machine.damping * span)
    if speed * (way * (at - begin_at) + fastest * span) < (left - close) * (speed + fastest):
        return _after_turn(machine, whole, way, rounding[0])
    return _Next(_LOOKS, _TURN, 0.0, begin + span * speed / (speed + abs(rate)), whole)


@inlined
def _step(miss, inverse, bend, jerk, snap):
    """Step to the zero of ``-miss``, and the last term of it: by Halley's method, without one, where it is long."""
    q = miss * inverse
    curve = bend * inverse * q
    if abs(curve) > _SERIES:
        return q / max(1.0 + 0.5 * curve, _SERIES), math.inf
    return fifth_order_step(q, bend * inverse, jerk * inverse, snap * inverse)


@inlined
def _kept_inside(piece, tau, step):
    """A time a step later, which stays between the ends of its piece."""
    if not tau + step > piece.begin:
        return 0.5 * (tau + piece.begin)
    return tau + step if tau + step < piece.end else 0.5 * (tau + piece.end)


@inlined
def _at_turn(machine, piece, seen):
    """Next look after a guessed turning point."""
    tau, way, rate, begin, end = seen.tau, piece.way, seen.rate, piece.begin, piece.end
    if not way * seen.bend < 0.0:
        return _Next(_LOOKS, _TURN, 0.0, 0.5 * (tau + (end if way * rate > 0.0 else begin)), piece)
    step, last = _step(-rate, 1.0 / seen.bend, seen.jerk, seen.snap, 0.0)
    if begin < tau + step < end and abs(step) * machine.highest <= _NEAR_TURN and abs(last) <= 0.05 * abs(step):
        bent = 0.5 * seen.bend + step * (seen.jerk * (1.0 / 6.0) + step * seen.snap * (1.0 / 24.0))
        at = -seen.miss + step * (rate + step * bent)
        wall = _wall_ahead(machine, piece.velocity, way)
        beyond = way * (at - wall)
        # What Taylor leaves out, and what is missing to the turning point, are 3e-3 of that together.
        margin = 4e-3 * machine.strongest * step * step + _closeness(machine, piece.velocity, tau)
        if beyond < -margin:
            return _after_turn(machine, piece, way, _rounding(machine, piece.velocity, piece.end)[0])
        if beyond > margin:
            part = min(max((wall - piece.begin_at) / (at - piece.begin_at), 0.0), 1.0)
            until = _Piece(piece.velocity, begin, piece.begin_at, piece.begin_rate, tau + step, at, 0.0, way)
            return _Next(_LOOKS, _ROOT, wall, begin + (tau + step - begin) * (1.0 - math.sqrt(1.0 - part)), until)
        if abs(step) <= 1e-9 * tau:
            return _ends_unsure(piece)
    return _Next(_LOOKS, _TURN, 0.0, _kept_inside(piece, tau, step), piece)


@inlined
def _at_root(machine, piece, target, seen):
    """Next look after a guessed contact."""
    tau, way = seen.tau, piece.way
    if not way * seen.rate > 0.0:
        # Before its turning point a piece goes away from the wall behind it; after it, from the wall ahead.
        nearer = piece.begin if way * piece.begin_rate > 0.0 else piece.end
        return _Next(_LOOKS, _ROOT, target, 0.5 * (tau + nearer), piece)
    inside = piece.begin < tau + seen.step < piece.end
    if inside and abs(seen.last) <= _LAST_TERM * tau and abs(seen.step) * machine.highest <= _LARGEST_STEP:
        return _Next(_ARRIVES, _ROOT, target, tau, piece)
    return _Next(_LOOKS, _ROOT, target, _kept_inside(piece, tau, seen.step), piece)


@always_inlined
def _look(work, oscillator):
    """Evaluate the first lanes of a buffer: displacement and its derivatives, and the step to their target.

    Their number is known to the compiler: else it minds indices below 0, and makes no vectors.
    """
    evaluate(work, oscillator, 0, _BLOCK)
    d, e, harmonics = oscillator.damping, oscillator.eccentricity, oscillator.harmonics
    for i in range(_BLOCK):
        y1 = work[RATE + i]
        s, c = work[SINE + i] + work[SINE_CHANGE + i], work[COSINE + i] + work[COSINE_CHANGE + i]
        y2 = plus(harmonics, FOUR_PI * d - d * y1 - TWO_PI * e * (TWO_PI * c + d * s), work[RATE_1 + i])
        y3 = plus(harmonics, TWO_PI * TWO_PI * e * (TWO_PI * s - d * c) - d * y2, work[RATE_2 + i])
        y4 = plus(harmonics, TWO_PI * TWO_PI * TWO_PI * e * (TWO_PI * c + d * s) - d * y3, work[RATE_3 + i])
        work[_BEND + i], work[_JERK + i], work[_SNAP + i] = y2, y3, y4
        inverse = 1.0 / y1
        q = work[MISS + i] * inverse
        step, term = fifth_order_step(q, y2 * inverse, y3 * inverse, y4 * inverse)
        curve = y2 * inverse * q
        far = abs(curve) > _SERIES
        work[_STEP + i] = q / max(1.0 + 0.5 * curve, _SERIES) if far else step
        work[_LAST + i] = math.inf if far else term


class _Contact(NamedTuple):
    """Where and how a flight meets a wall; ``acceleration`` is a there."""

    phase: float
    speed: float
    duration: float
    acceleration: float


@always_inlined
def _meet(work, j, oscillator, target):
    """State at the contact, a small step after the time at which place j is evaluated, as `flight` has it."""
    d, e, harmonics, step = oscillator.damping, oscillator.eccentricity, oscillator.harmonics, work[_STEP + j]
    s0, c0, ds, dc = work[SINE + j], work[COSINE + j], work[SINE_CHANGE + j], work[COSINE_CHANGE + j]
    s, c = s0 + ds, c0 + dc
    angle = TWO_PI * step
    z = angle * angle
    turns = angle * (1.0 - z * (1.0 / 6.0) * (1.0 - z * (1.0 / 20.0)))
    versine = 0.5 * z * (1.0 - z * (1.0 / 12.0) * (1.0 - z * (1.0 / 30.0)))
    ds, dc = ds + (c * turns - s * versine), dc - (s * turns + c * versine)
    tau = work[DURATION + j] + step
    velocity = work[VELOCITY + j] + d * (FOUR_PI * tau - target) + e * (d * dc - TWO_PI * ds)
    acceleration = FOUR_PI * d - TWO_PI * e * (TWO_PI * (c0 + dc) + d * (s0 + ds))
    velocity = plus_rate_after(harmonics, velocity, (work, j, step))
    acceleration = plus_acceleration_after(harmonics, acceleration, (work, j, step))
    return _Contact(wrap(work[PHASE + j] + tau), abs(velocity), tau, acceleration)


@always_inlined
def _land(lanes, i, upper, phase, speed, after):
    """Write down how the flight of lane i has ended: it leaves a wall some time after the contact, or never."""
    if after == math.inf:
        after = speed = 0.0
    lanes[DURATION + i] += after
    lanes[END_PHASE + i] = phase
    lanes[END_VELOCITY + i] = -speed if upper else speed
    lanes[DROPS + i] = 0.0 if upper else 1.0


@always_inlined
def _next_end(work, after_last, phase):
    """Row of the first end of an arc after a phase in [0, 1), and 1.0 where it is in the next period.

    As `arcs.next_end`, which reads arrays in a tuple.
    """
    at = _TABLE
    while at < after_last and work[at] <= phase:
        at += _ROW
    return (_TABLE, 1.0) if at == after_last else (at, 0.0)


@always_inlined
def _bounces_on(lanes, work, i, machine, tables, wall, same_wall, same_arc, contact):
    """Whether a contact of lane i is a bounce that is to be followed further; if not its flight ends, or it is lost."""
    phase, speed, upper = contact.phase, machine.restitution * contact.speed, wall == UPPER
    at, later = _next_end(work, machine.after_last, phase)
    left = (work[at] + later) - phase
    if lanes[_LEFT + i] < 0.0:  # the end of the flight, unless it rests
        lanes[DURATION + i], lanes[_ARRIVAL + i], lanes[_REST + i] = contact.duration, contact.speed, 0.0
        known = lanes[PHASE + i] == lanes[_KNOWN_PHASE + i] and lanes[VELOCITY + i] == lanes[_KNOWN_VELOCITY + i]
        known = known and same_wall and same_arc
        _land(lanes, i, upper, phase, speed, 0.0)
        if known:
            lanes[_KNOWN_PHASE + i], lanes[_KNOWN_VELOCITY + i] = phase, lanes[END_VELOCITY + i]
        jumps_below = tables.upper_jumps_below if upper else tables.lower_jumps_below
        # A bounce takes that long at least: it is slowed by so much, and falls no faster.
        shortest = 2.0 * speed / (machine.strongest + machine.damping * speed)
        pressed = work[at + 3] == wall and machine.restitution < 1.0
        if known or not (pressed and speed < jumps_below and shortest <= left):
            return False
    elif not same_wall or contact.duration >= lanes[_LEFT + i]:
        # They do not accumulate: the first of them is where the flight has ended.
        lanes[_KNOWN_PHASE + i], lanes[_KNOWN_VELOCITY + i] = lanes[END_PHASE + i], lanes[END_VELOCITY + i]
        return False
    lanes[_LEFT + i] = left
    if not is_sure_to_rest(machine, wall * contact.acceleration, left, speed):
        return True
    first = lanes[END_PHASE + i]
    at, later = _next_end(work, machine.after_last, first)
    # Where a keeps its sign it rests for ever.
    lanes[_REST + i] = (work[at] + later) - first if machine.after_last > _TABLE + _ROW else math.inf
    _land(lanes, i, upper, wrap(work[at]), RELEASED, lanes[_REST + i])
    return False


@inlined
def _fly_alone(lanes, i, oscillator, tables):
    """One flight of lane i by the scalar path."""
    velocity = lanes[VELOCITY + i]
    wall = LOWER if velocity > 0.0 else UPPER
    end = next_loose_contact(oscillator, wall, lanes[PHASE + i], velocity)
    speed, upper = abs(end.velocity), end.wall == UPPER
    jumps_below = tables.upper_jumps_below if upper else tables.lower_jumps_below
    leaves = leave(oscillator, end.wall, end.phase, oscillator.restitution * speed, jumps_below)
    lanes[_REST + i], lanes[_ARRIVAL + i] = leaves.after if leaves.rests else 0.0, speed
    lanes[DURATION + i] = end.duration
    _land(lanes, i, upper, leaves.phase if end.found else math.nan, leaves.speed, leaves.after)


@always_inlined
def _follow_arcs(work, i, j, machine):
    """Follow the flight of lane i, at place j, from arc to arc until a piece has to be looked at.

    As ``(y - 4 pi tau - e)'' = -delta (y - 4 pi tau - e)'``, with e and e' from the table this needs no sine. It needs
    more digits than displacements have where they are small: there the end of the arc is looked at.
    """
    velocity, at, base = work[VELOCITY + j], int(work[_ROW_AT + i]) & _INDEX, work[_BASE + i]
    begin, begin_at, begin_rate = work[_BEGIN + i], work[_BEGIN_AT + i], work[_BEGIN_RATE + i]
    excess = velocity - FOUR_PI - work[_ERROR_RATE + i]
    while True:
        end = work[at] + base
        piece = _Piece(velocity, begin, begin_at, begin_rate, end, 0.0, 0.0, 1.0)
        comes = _ends_unsure(piece)
        x = machine.damping * end
        if x <= 1.0:
            phi1 = 1.0 - x * second_phi_of_part(x)
            y = FOUR_PI * end + (work[at + 1] - work[_ERROR + i]) + excess * end * phi1
            rate = FOUR_PI + work[at + 2] + excess * (1.0 - x * phi1)
            comes = _at_arc_end(machine, piece, work[at + 3], end, y, rate, _rounding(machine, velocity, end))
        if comes.comes != _PASSES:
            break
        begin, begin_at, begin_rate = end, comes.piece.end_at, comes.piece.end_rate
        at += _ROW
        if at == machine.after_last:
            at, base = _TABLE, base + 1.0
    work[_ROW_AT + i], work[_BASE + i] = at, base
    work[_BEGIN + i], work[_BEGIN_AT + i], work[_BEGIN_RATE + i] = begin, begin_at, begin_rate
    looks = comes.comes == _LOOKS
    work[_MODE + i], work[_LOOKS_SO_FAR + i] = comes.mode if looks else _ARC, 0.0
    work[TARGET + j], work[DURATION + j] = comes.target if looks else 0.0, comes.tau if looks else end
    work[_END + i], work[_END_AT + i], work[_END_RATE + i], work[_WAY + i] = (
        end, comes.piece.end_at, comes.piece.end_rate, comes.piece.way,
    )  # fmt: skip


@always_inlined
def _begin(work, i, j, machine, oscillator, phase, velocity):
    """Let lane i, at place j of those that fly, leave a wall."""
    at, later = _next_end(work, machine.after_last, phase)
    base = later - phase
    first = oscillator.eccentricity * work[COSINE + j], -TWO_PI * oscillator.eccentricity * work[SINE + j]
    work[_ERROR + i], work[_ERROR_RATE + i] = plus_error(oscillator.harmonics, first, phase)
    work[_ROW_AT + i], work[_BASE + i], work[_ARC_END + i] = at, base, work[at] + base
    work[_BEGIN + i], work[_BEGIN_AT + i], work[_BEGIN_RATE + i] = 0.0, 0.0, velocity
    work[PHASE + j], work[VELOCITY + j] = phase, velocity
    _follow_arcs(work, i, j, machine)


@inlined
def fly_loosely(lanes, corners, oscillator, tables):
    """Fly every lane to the next wall; return how many took the scalar path.

    Parameters
    ----------
    lanes : ndarray of float64
        The buffer.
    corners : ndarray of int64
        Becomes the lanes that fly, in their order.
    oscillator : LooseOscillator
        Checked by the caller.
    tables : LooseTables

    Returns
    -------
    int
    """
    arcs = oscillator.arcs
    after_last = _TABLE + _ROW * arcs.begin.size
    work = unset_lane_buffer(_FIELDS + -(-(after_last - _TABLE) // LANES))
    for m in range(arcs.begin.size):
        row = arcs.begin[m], arcs.error[m], arcs.error_rate[m], arcs.sign[m - 1]
        for n in range(_ROW):
            work[_TABLE + _ROW * m + n] = row[n]
    error, error_rate = bounds_on_error(oscillator)
    highest = highest_order(oscillator.harmonics, 1.0, None)
    two_beta = 2.0 * oscillator.half_backlash
    machine = _Machine(
        after_last,
        oscillator.damping,
        two_beta,
        oscillator.restitution,
        arcs.strongest,
        arcs.change,
        error,
        error_rate,
        highest,
    )
    careful, flying = 0, 0
    idle = -IDLE_SPEED * tables.largest_grazing_speed
    for i in range(LANES):
        work[PHASE + i] = 0.0
        lanes[_LEFT + i], lanes[END_ACCELERATION + i] = -1.0, 1.0
        if lanes[VELOCITY + i] == idle:
            lanes[DURATION + i], lanes[END_PHASE + i], lanes[END_VELOCITY + i], lanes[DROPS + i] = 0.0, 0.0, -idle, 1.0
        else:
            corners[flying], work[PHASE + flying] = i, lanes[PHASE + i]
            flying += 1
    turn_phases(work, PHASE)
    for j in range(flying):
        i = corners[j] & _INDEX
        _begin(work, i, j, machine, oscillator, lanes[PHASE + i], lanes[VELOCITY + i])
    while flying > 0:
        for first in range(0, flying, _BLOCK):
            _look(work[first:], oscillator)
        kept = 0
        for j in range(flying):
            i = corners[j] & _INDEX
            velocity, mode, target = work[VELOCITY + j], work[_MODE + i], work[TARGET + j]
            piece = _Piece(
                velocity, work[_BEGIN + i], work[_BEGIN_AT + i], work[_BEGIN_RATE + i], work[_END + i],
                work[_END_AT + i], work[_END_RATE + i], work[_WAY + i],
            )  # fmt: skip
            seen = _Seen(
                work[DURATION + j], work[MISS + j], work[RATE + j], work[_BEND + j], work[_JERK + j],
                work[_SNAP + j], work[_STEP + j], work[_LAST + j],
            )  # fmt: skip
            if mode == _ROOT:
                comes = _at_root(machine, piece, target, seen)
            elif mode == _TURN:
                comes = _at_turn(machine, piece, seen)
            elif machine.damping * seen.tau <= 1.0:
                sign = work[(int(work[_ROW_AT + i]) & _INDEX) + 3]
                comes = _at_arc_end(machine, piece, sign, seen.tau, -seen.miss, seen.rate, (0.0, 0.0))
            else:  # phi2 is no polynomial there
                comes = _ends_unsure(piece)
            work[_LOOKS_SO_FAR + i] += 1.0
            flies = comes.comes == _LOOKS and work[_LOOKS_SO_FAR + i] < _MOST_LOOKS
            if flies:
                work[_MODE + i], work[TARGET + j], work[DURATION + j] = comes.mode, comes.target, comes.tau
                work[_END + i], work[_END_AT + i], work[_END_RATE + i], work[_WAY + i] = (
                    comes.piece.end, comes.piece.end_at, comes.piece.end_rate, comes.piece.way,
                )  # fmt: skip
            elif comes.comes == _PASSES:
                flies = True
                work[_BEGIN + i], work[_BEGIN_AT + i], work[_BEGIN_RATE + i] = (
                    comes.piece.end, comes.piece.end_at, comes.piece.end_rate,
                )  # fmt: skip
                work[_ROW_AT + i] += _ROW
                if int(work[_ROW_AT + i]) == machine.after_last:
                    work[_ROW_AT + i], work[_BASE + i] = _TABLE, work[_BASE + i] + 1.0
                _follow_arcs(work, i, j, machine)
            elif comes.comes == _ARRIVES:
                contact, wall = _meet(work, j, oscillator, target), piece.way
                same_wall, same_arc = wall * velocity < 0.0, contact.duration < work[_ARC_END + i]
                speed = machine.restitution * contact.speed
                if not speed >= RELEASED:
                    comes = _ends_unsure(piece)
                elif _bounces_on(lanes, work, i, machine, tables, wall, same_wall, same_arc, contact):
                    flies = True
                    work[SINE + j], work[COSINE + j] = turn(part_turn(contact.phase))
                    _begin(work, i, j, machine, oscillator, contact.phase, -wall * speed)
            if flies:
                corners[kept] = i
                for field in (PHASE, VELOCITY, SINE, COSINE, TARGET, DURATION):
                    work[field + kept] = work[field + j]
                kept += 1
            elif comes.comes != _ARRIVES:
                _fly_alone(lanes, i, oscillator, tables)
                careful += 1
        flying = kept
    return careful


@inlined
def stay_loosely(lanes, corners, oscillator, tables, slow):
    """Follow the contact of every lane after its flight (finite stiffness), by the scalar path; return how many.

    A lane in permanent contact ends with velocity 0; one whose end was not found with a phase of NaN.
    """
    followed, idle = 0, IDLE_SPEED * tables.largest_grazing_speed
    for i in range(LANES):
        velocity = lanes[END_VELOCITY + i]
        if velocity == idle or not math.isfinite(lanes[END_PHASE + i]):
            continue
        followed += 1
        wall = LOWER if velocity > 0.0 else UPPER
        leaves = leave_contact(oscillator, wall, lanes[END_PHASE + i], abs(velocity))
        if leaves.after == math.inf:
            lanes[END_VELOCITY + i] = 0.0
            continue
        lanes[DURATION + i], lanes[END_PHASE + i] = leaves.after, leaves.phase
        lanes[END_VELOCITY + i] = -wall * leaves.speed
    return followed


@inlined
def _loose_arrival_speed(oscillator, lanes, i):
    return lanes[_ARRIVAL + i]


@chosen_by_field("arcs", _loose_arrival_speed)
def arrival_speed(oscillator, lanes, i):
    """Speed with which lane i has met the wall at the end of its flight."""
    return abs(lanes[END_VELOCITY + i]) / oscillator.restitution


@inlined
def _loose_rest_time(oscillator, lanes, i):
    return lanes[_REST + i]


@chosen_by_field("arcs", _loose_rest_time)
def rest_time(oscillator, lanes, i):
    """How long lane i has rested after its flight, with the low bounces before that; 0 where it has not."""
    return 0.0


@inlined
def _loose_chatters_on(oscillator, lanes, i):
    return accumulates(oscillator, UPPER, lanes[PHASE + i], -lanes[VELOCITY + i])


@chosen_by_field("arcs", _loose_chatters_on)
def chatters_on(oscillator, lanes, i):
    """Whether lane i, which is at a departure, is on its way to a rest: P leads from before it to the release."""
    return False

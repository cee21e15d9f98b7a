"""Enclosures of one flight: where and how fast all departures of a box arrive, and the derivative of that.

With E = (1 - e^{-delta tau})/delta and D = e^{-delta tau} a flight that leaves a wall at time t with velocity w is, at
time s = t + tau and counted from that wall,

    y  = 4 pi tau + e(s) - e(t) + (w - 4 pi - e'(t)) E
    y' = 4 pi + e'(s) + (w - 4 pi - e'(t)) D.

It arrives where y is `height`: 0, or -+2 beta. The derivative of the arrival (s, y') by the departure (t, w) is

    s_t = (w D + a(t) E)/y'                       s_w = -E/y'
    w_t = (a(s) - delta y') s_t - (a(t) - delta w) D    w_w = (a(s) - delta y') s_w + D.

By a parameter p it is ``(h_p - y_p)/y'`` and ``y'_p + (a(s) - delta y') s_p``, h the height, y_p and y'_p taken at a
fixed departure and time (`_drift`).

First the arrival of the centre is enclosed by an interval Newton step, for one machine. Then an interval S is found
which the arrival cannot leave, however the departure moves through the box and the parameters through their tolerances:
the slopes over S and the box lead to its interior (theorem 2 of `docs/theory/proof.md`).
"""

import math
from typing import NamedTuple

from rattle_kernels.numerics.jit import inlined_as_written
from rattle_proof.enclosures.enclosed_functions import TWO_PI, decay, first_phi, phi_drop, wave
from rattle_proof.enclosures.interval import (
    Interval,
    add,
    around,
    divide,
    lies_within,
    multiply,
    negative,
    point,
    reach,
    scale,
    subtract,
    up,
)
from rattle_proof.enclosures.machine import FOUR_PI, acceleration, error_at

# Half-width in which the centre's arrival is sought, and how far the others' is widened at a try.
_NEAR = 1e-9
_TRIES = 6
_WIDER = 1.3


class Matrix(NamedTuple):
    """Enclosure of a 2 x 2 matrix, of (time, velocity) by (time, velocity)."""

    tt: Interval
    tv: Interval
    vt: Interval
    vv: Interval


class Box(NamedTuple):
    """Departures: all times and signed velocities of two intervals."""

    t: Interval
    w: Interval


@inlined_as_written
def halves_of_part(part):
    """The later or upper half of a part, and the other: times and speeds, least and greatest, and how often it was cut.

    Times are cut first, then speeds, in turn.
    """
    early, late, low, high, cuts = part
    if cuts % 2.0 == 0.0:
        half = 0.5 * (early + late)
        return (half, late, low, high, cuts + 1.0), (early, half, low, high, cuts + 1.0)
    half = 0.5 * (low + high)
    return (early, late, half, high, cuts + 1.0), (early, late, low, half, cuts + 1.0)


class Arrivals(NamedTuple):
    """Arrivals of a box; ``found`` says whether this is proven.

    ``centre`` is where the centre arrives in the machine that is the centre of its tolerances, ``slope`` the derivative
    over the box and the tolerances, and ``drift`` what the parameters add: an arrival is the sum of ``centre``,
    ``slope`` times the departure less its centre, and ``drift``. ``all`` holds all arrivals.
    """

    found: bool
    centre: Box
    slope: Matrix
    drift: Box
    all: Box


class Departure(NamedTuple):
    """What does not change while the arrival is sought."""

    t: Interval
    w: Interval
    error: tuple
    felt: Interval
    lag: Interval


@inlined_as_written
def leave(machine, t, w):
    """What a departure knows of itself."""
    error = error_at(machine, t)
    lag = subtract(subtract(w, FOUR_PI), error.rate)
    return Departure(t, w, error, acceleration(machine, error), lag)


@inlined_as_written
def fall_factors(machine, tau):
    """E and D after tau, of which only what is not negative counts: no arrival comes before its departure."""
    tau = Interval(max(tau.low, 0.0), tau.high)
    x = multiply(machine.damping, tau)
    return multiply(tau, first_phi(x)), decay(x)


@inlined_as_written
def displacement(machine, departure, s):
    """Y at all times of s."""
    tau = subtract(s, departure.t)
    reached, _ = fall_factors(machine, tau)
    swing = subtract(error_at(machine, s).value, departure.error.value)
    return add(add(multiply(FOUR_PI, tau), swing), multiply(departure.lag, reached))


@inlined_as_written
def no_arrivals():
    """What is returned where nothing is proven."""
    nothing = Interval(math.nan, math.nan)
    box = Box(nothing, nothing)
    return Arrivals(False, box, Matrix(nothing, nothing, nothing, nothing), box, box)


@inlined_as_written
def no_drift():
    """What the parameters of one machine add."""
    return Box(point(0.0), point(0.0))


@inlined_as_written
def _slopes(machine, departure, s):
    """Velocity on arrival within s, and the slopes of (s, w) there."""
    tau = subtract(s, departure.t)
    reached, left = fall_factors(machine, tau)
    error = error_at(machine, s)
    velocity = add(add(FOUR_PI, error.rate), multiply(departure.lag, left))
    drag = subtract(acceleration(machine, error), multiply(machine.damping, velocity))
    pushed = subtract(departure.felt, multiply(machine.damping, departure.w))
    tt = divide(add(multiply(departure.w, left), multiply(departure.felt, reached)), velocity)
    tv = divide(multiply(point(-1.0), reached), velocity)
    vt = subtract(multiply(drag, tt), multiply(pushed, left))
    return velocity, Matrix(tt, tv, vt, add(multiply(drag, tv), left))


@inlined_as_written
def _add_boxes(a, b):
    return Box(add(a.t, b.t), add(a.w, b.w))


@inlined_as_written
def _by_parameter(arrival, y, rate, change):
    """Change of an arrival by one parameter, which changes y and y' there by these slopes; the two need not add up."""
    later = divide(negative(y), arrival.velocity)
    return Box(multiply(later, change), multiply(add(rate, multiply(arrival.pushed, later)), change))


class _Arrival(NamedTuple):
    """Velocity and acceleration on arrival."""

    velocity: Interval
    pushed: Interval


@inlined_as_written
def _drift(machine, departure, s, velocity, walls):
    """Changes of the arrival (s, y') by the parameters."""
    one = machine.centre
    tau = subtract(s, departure.t)
    reached, left = fall_factors(machine, tau)
    tau = Interval(max(tau.low, 0.0), tau.high)
    felt = acceleration(machine, error_at(machine, s))
    arrival = _Arrival(velocity, subtract(felt, multiply(machine.damping, velocity)))
    # dE/d(delta) = tau^2 phi_1'(delta tau), dD/d(delta) = -tau D.
    lagging = negative(multiply(tau, departure.lag))
    longer = multiply(lagging, multiply(tau, phi_drop(multiply(machine.damping, tau))))
    change = subtract(machine.damping, one.damping)
    drift = _by_parameter(arrival, longer, multiply(lagging, left), change)
    change = subtract(machine.half_backlash, one.half_backlash)
    drift = _add_boxes(drift, _by_parameter(arrival, point(-walls), point(0.0), change))
    for n in range(machine.harmonics.shape[0]):
        order, amplitude = machine.harmonics[n, 0], Interval(machine.harmonics[n, 1], machine.harmonics[n, 2])
        phase = Interval(machine.harmonics[n, 3], machine.harmonics[n, 4])
        rate = scale(TWO_PI, order)
        start, end = wave(add(scale(departure.t, order), phase)), wave(add(scale(s, order), phase))
        # The flight of an error cos(2 pi (order t + phase)) alone, and of its derivative by 2 pi phase.
        cosine = add(subtract(end.cosine, start.cosine), multiply(multiply(rate, start.sine), reached))
        sine = subtract(multiply(multiply(rate, start.cosine), reached), subtract(end.sine, start.sine))
        cosine_rate = multiply(rate, subtract(multiply(start.sine, left), end.sine))
        sine_rate = multiply(rate, subtract(multiply(start.cosine, left), end.cosine))
        larger = subtract(amplitude, point(one.harmonics[n, 1]))
        turned = multiply(multiply(TWO_PI, amplitude), subtract(phase, point(one.harmonics[n, 3])))
        drift = _add_boxes(drift, _by_parameter(arrival, cosine, cosine_rate, larger))
        drift = _add_boxes(drift, _by_parameter(arrival, sine, sine_rate, turned))
    return drift


@inlined_as_written
def spread(slope, dt, dw):
    """Image of the differences dt, dw."""
    return Box(add(multiply(slope.tt, dt), multiply(slope.tv, dw)), add(multiply(slope.vt, dt), multiply(slope.vv, dw)))


@inlined_as_written
def _time_spread(slope, dt, dw):
    return add(multiply(slope.tt, dt), multiply(slope.tv, dw))


@inlined_as_written
def arrive(machine, centre, box, walls, guess):
    """Enclose the arrivals of a box at a wall, given a guess of the centre's.

    Parameters
    ----------
    machine : Machine
        Eq. (8) holds for all of it.
    centre, box : Box
        The centre may be a small box; it lies within the other.
    walls : float
        Where the flights arrive, counted from the wall they leave: 0, or -2 or 2 half backlashes.
    guess : float
        Time of the centre's arrival, about. Nothing rests on it.

    Returns
    -------
    Arrivals
        The velocity has one sign at all of them. They come after the departures.
    """
    one = machine.centre
    start = leave(one, centre.t, centre.w)
    near = around(guess, _NEAR)
    velocity, _ = _slopes(one, start, near)
    missed = subtract(displacement(one, start, point(guess)), scale(one.half_backlash, walls))
    arrival = subtract(point(guess), divide(missed, velocity))
    # Before its departure a flight is not what the formulas say.
    if not (lies_within(arrival, near) and near.low > centre.t.high):
        return no_arrivals()
    speed, slope = _slopes(one, start, arrival)
    dt, dw = subtract(box.t, centre.t), subtract(box.w, centre.w)
    wide = leave(machine, box.t, box.w)
    drift = no_drift()
    within = _time_spread(slope, dt, dw)
    for _ in range(_TRIES):
        grown = around(0.0, up(_WIDER * reach(within)) + 1e-12)
        sought = add(arrival, grown)
        velocity, over = _slopes(machine, wide, sought)
        if not machine.exact:
            drift = _drift(machine, wide, sought, velocity, walls)
        within = add(_time_spread(over, dt, dw), drift.t)
        times = add(arrival, within)
        if lies_within(times, sought):
            change = add(add(multiply(over.vt, dt), multiply(over.vv, dw)), drift.w)
            speeds = add(speed, change)
            both = Interval(max(speeds.low, velocity.low), min(speeds.high, velocity.high))
            return Arrivals(True, Box(arrival, speed), over, drift, Box(times, both))
    return no_arrivals()

"""dP/dp, the derivative of the impact map by a parameter of the oscillator, in closed form.

Flights and contacts are known as y(tau; w, p) and x(tau; u, p). Differentiated at fixed beginning and fixed tau they
give the change of displacement, dy, and of velocity, dy'. The end of a piece moves by

    d tau = (d target - dy)/y',    d target = -+2 for the half backlash where a flight crosses it, else 0,

and the velocity there by dy' + y'' d tau. The piece's own derivative (`jacobian`) carries a change from its beginning
to its end. So the changes of a whole application add up along it.

With x = delta tau, S = sin, C = cos at the phases met, a flight has (Eqs. 18, 24, 30 with their errata)

    dy/d eps   = 2 pi S0 tau phi1 + C - C0,            dy'/d eps   = -delta dy/d eps - 2 pi (S - S0) + delta (C - C0),
    dy/d delta = tau^2 (4 pi - w - 2 pi eps S0) (phi2 + x phi2'),
    dy'/d delta = 4 pi tau - y - delta dy/d delta + eps (C - C0),

and other orders of the forcing the like. All this holds for any flight, also of a loose gear, which meets -beta any
number of times on its way. An impact depends on the restitution alone. A contact depends on delta, kappa
and zeta through its slow part (`model.slow_harmonics`) and through its ringing.
"""

import math
from typing import NamedTuple

from rattle_kernels.impact_map.apply import walk
from rattle_kernels.impact_map.arc_flights import next_loose_contact
from rattle_kernels.impact_map.flights import FORWARDS, LOWER, UPPER
from rattle_kernels.impact_map.jacobian import impact_after
from rattle_kernels.impact_map.loose_map import MOST_CONTACTS, Impact, leave
from rattle_kernels.impact_map.variations import Jacobian, by_speeds, contact_jacobian, flight_jacobian, multiply
from rattle_kernels.model.contact_end import Contact
from rattle_kernels.model.flight import FOUR_PI, TWO_PI, rest_acceleration, second_phi, second_phi_slope
from rattle_kernels.model.harmonics import Harmonic, states_at
from rattle_kernels.model.outcome import OUTCOME_NOT_CONVERGED, OUTCOME_RETURNED
from rattle_kernels.model.slow_harmonics import response, response_change
from rattle_kernels.numerics.jit import chosen_by_field, inlined, summed_over_tuple
from rattle_kernels.numerics.phase import part_turn

# Numbers of `Oscillator.parameters`. From FIRST_HARMONIC on, amplitudes and phases of harmonics alternate.
DAMPING, ECCENTRICITY, HALF_BACKLASH, STIFFNESS, RESTITUTION, CONTACT_DAMPING, FIRST_HARMONIC = 0, 1, 2, 3, 4, 5, 6


@summed_over_tuple
def _add_drive(terms, total, place):
    """Add the rates of the harmonics, less their sign, where a flight begins."""
    for state in terms:
        total += TWO_PI * state.order * state.amplitude * state.sine
    return total


@summed_over_tuple
def _add_displacement(terms, total, place):
    """Add e(t) at the end of a flight less that at its beginning; `place` is its duration."""
    for state in terms:
        half_angle = math.pi * part_turn(state.order * place)
        sine_half, cosine_half = math.sin(half_angle), math.cos(half_angle)
        total -= 2.0 * sine_half * state.amplitude * (state.sine * cosine_half + state.cosine * sine_half)
    return total


@summed_over_tuple
def _add_own_change(terms, total, place):
    """Add the change by amplitude or phase of one harmonic; `place` is (parameter, delta, tau, tau phi1)."""
    parameter, damping, tau, stretch = place
    change, rate_change = total
    number = FIRST_HARMONIC
    for state in terms:
        rate = TWO_PI * state.order
        half_angle = math.pi * part_turn(state.order * tau)
        sine_half, cosine_half = math.sin(half_angle), math.cos(half_angle)
        sine_change = 2.0 * sine_half * (state.cosine * cosine_half - state.sine * sine_half)
        cosine_change = -2.0 * sine_half * (state.sine * cosine_half + state.cosine * sine_half)
        if parameter == number:
            own = rate * state.sine * stretch + cosine_change
            change += own
            rate_change += damping * (cosine_change - own) - rate * sine_change
        elif parameter == number + 1:
            turn = TWO_PI * state.amplitude
            own = turn * (rate * state.cosine * stretch - sine_change)
            change += own
            rate_change -= damping * (own + turn * sine_change) + turn * rate * cosine_change
        number += 2
    return change, rate_change


@inlined
def _flight_change(oscillator, parameter, phase, velocity, end, displacement):
    """Change of displacement and velocity at the fixed end of a flight, by a parameter of freeplay."""
    damping, tau = oscillator.damping, end.duration
    x = damping * tau
    phi2 = second_phi(x)
    here, there = TWO_PI * part_turn(phase), TWO_PI * part_turn(end.phase)
    sine_change, cosine_change = math.sin(there) - math.sin(here), math.cos(there) - math.cos(here)
    if parameter == ECCENTRICITY:
        change = TWO_PI * math.sin(here) * tau * (1.0 - x * phi2) + cosine_change
        return change, damping * (cosine_change - change) - TWO_PI * sine_change
    if parameter == DAMPING:
        states = states_at(oscillator.harmonics, phase)
        drive = _add_drive(states, velocity + TWO_PI * oscillator.eccentricity * math.sin(here), None)
        change = tau * tau * (FOUR_PI - drive) * (phi2 + x * second_phi_slope(x))
        moved = _add_displacement(states, oscillator.eccentricity * cosine_change, tau)
        return change, FOUR_PI * tau - displacement - damping * change + moved
    place = parameter, damping, tau, tau * (1.0 - x * phi2)
    return _add_own_change(states_at(oscillator.harmonics, phase), (0.0, 0.0), place)


@inlined
def flight_sensitivity(oscillator, parameter, wall, phase, velocity, end):
    """Change of (time of its end, velocity as an elastic impact turns it) of a flight from a fixed departure."""
    crossing = 0.5 * (end.wall - wall)  # -1 down, +1 up, 0 back to the same wall
    displacement = 2.0 * crossing * oscillator.half_backlash
    change, rate_change = _flight_change(oscillator, parameter, phase, velocity, end, displacement)
    target_change = 2.0 * crossing if parameter == HALF_BACKLASH else 0.0
    later = (target_change - change) / end.velocity
    arriving = rest_acceleration(oscillator, end.phase) - oscillator.damping * end.velocity
    return later, -(rate_change + arriving * later)


class _ContactNumbers(NamedTuple):
    """delta, omega^2, the damping in contact, and their changes by a parameter."""

    damping: float
    square: float
    drag: float
    d_damping: float
    d_square: float
    d_drag: float


@inlined
def _contact_numbers(oscillator, parameter):
    damping, square, part = oscillator.damping, 2.0 * oscillator.stiffness, oscillator.contact_damping
    omega = math.sqrt(square)
    d_damping, d_square, d_drag = 0.0, 0.0, 0.0
    if parameter == DAMPING:
        d_damping = d_drag = 1.0
    elif parameter == STIFFNESS:
        d_square, d_drag = 2.0, 2.0 * part / omega
    elif parameter == CONTACT_DAMPING:
        d_drag = 2.0 * omega
    return _ContactNumbers(damping, square, damping + 2.0 * part * omega, d_damping, d_square, d_drag)


@inlined
def _slow_of_one(harmonic, number, parameter, numbers, phase):
    """Slow part of one order at a phase, its rate, and the changes of both."""
    order, amplitude, shift = harmonic.order, harmonic.amplitude, harmonic.phase
    rate, angle = TWO_PI * order, TWO_PI * part_turn(order * part_turn(phase) + part_turn(shift))
    sine, cosine = math.sin(angle), math.cos(angle)
    here, quarter = response(amplitude, rate, numbers.damping, numbers.square, numbers.drag)
    depth, slope = here * cosine + quarter * sine, rate * (quarter * cosine - here * sine)
    if parameter == number + 1 and number >= FIRST_HARMONIC:
        return depth, slope, slope / order, -TWO_PI * rate * depth
    if parameter == number:
        d_here, d_quarter = response(1.0, rate, numbers.damping, numbers.square, numbers.drag)
    else:
        d_here, d_quarter = response_change(amplitude, rate, numbers)
    return depth, slope, d_here * cosine + d_quarter * sine, rate * (d_quarter * cosine - d_here * sine)


@summed_over_tuple
def _add_slow(terms, total, place):
    """Add depth, rate, and their changes of the slow parts of all orders."""
    parameter, numbers, phase = place
    depth, slope, d_depth, d_slope = total
    number = FIRST_HARMONIC
    for harmonic in terms:
        own = _slow_of_one(harmonic, number, parameter, numbers, phase)
        depth, slope, d_depth, d_slope = depth + own[0], slope + own[1], d_depth + own[2], d_slope + own[3]
        number += 2
    return depth, slope, d_depth, d_slope


@inlined
def _slow_at(oscillator, parameter, numbers, side, phase):
    """Slow part of a contact at a phase, its rate, and the changes of both."""
    first = _slow_of_one(Harmonic(1.0, oscillator.eccentricity, 0.0), ECCENTRICITY, parameter, numbers, phase)
    depth, slope, d_depth, d_slope = _add_slow(oscillator.harmonics, first, (parameter, numbers, phase))
    mean = FOUR_PI * numbers.damping / numbers.square
    d_mean = (FOUR_PI * numbers.d_damping - mean * numbers.d_square) / numbers.square
    return side * (mean + depth), side * slope, side * (d_mean + d_depth), side * d_slope


@inlined
def _ringing_change(numbers, tau):
    """S, S' of a contact, and their changes."""
    frequency = math.sqrt(numbers.square - 0.25 * numbers.drag * numbers.drag)
    left = math.exp(-0.5 * numbers.drag * tau)
    pulse, swing = left * math.sin(frequency * tau) / frequency, left * math.cos(frequency * tau)
    rate = swing - 0.5 * numbers.drag * pulse
    d_frequency = (0.5 * numbers.d_square - 0.25 * numbers.drag * numbers.d_drag) / frequency
    d_pulse = -0.5 * tau * numbers.d_drag * pulse + d_frequency * (tau * swing - pulse) / frequency
    d_swing = -0.5 * tau * numbers.d_drag * swing - d_frequency * tau * frequency * pulse
    d_rate = d_swing - 0.5 * (numbers.d_drag * pulse + numbers.drag * d_pulse)
    return pulse, rate, d_pulse, d_rate


@inlined
def contact_sensitivity(oscillator, parameter, side, phase, speed, contact):
    """Change of (time of leaving, signed velocity then) of a contact from a fixed entry; x as in `model.contact`."""
    if contact.duration == 0.0:
        return 0.0, -side * speed if parameter == RESTITUTION else 0.0
    numbers = _contact_numbers(oscillator, parameter)
    square, drag = numbers.square, numbers.drag
    pulse, rate, d_pulse, d_rate = _ringing_change(numbers, contact.duration)
    settled = 1.0 - rate - drag * pulse
    d_settled = -d_rate - numbers.d_drag * pulse - drag * d_pulse
    level, slope, d_level, d_slope = _slow_at(oscillator, parameter, numbers, side, phase)
    there = phase + contact.duration
    _, _, d_level_end, d_slope_end = _slow_at(oscillator, parameter, numbers, side, there)
    change = (speed - slope) * d_pulse + level * d_settled + d_level * (settled - 1.0) + d_level_end - d_slope * pulse
    rate_change = (speed - slope) * d_rate + d_level * square * pulse + d_slope_end - d_slope * rate
    rate_change += level * (numbers.d_square * pulse + square * d_pulse)
    later = change / contact.speed
    leaving = side * rest_acceleration(oscillator, there) + drag * contact.speed
    return later, side * (rate_change + leaving * later)


@inlined
def carry(jacobian, sensitivity, own):
    """Sensitivity after a piece: the piece's derivative carries what came before, and its own is added."""
    t, w = sensitivity
    return jacobian.tt * t + jacobian.tv * w + own[0], jacobian.vt * t + jacobian.vv * w + own[1]


@inlined
def _next_loose_impact_with_sensitivity(oscillator, parameter, t, v, over):
    """P of a loose gear with its derivatives, contact by contact; not found where it rests, or is to pass -beta."""
    jacobian, change = Jacobian(1.0, 0.0, 0.0, 1.0), (0.0, 0.0)
    wall, phase, velocity, elapsed = UPPER, t, -v, 0.0
    for lower_impacts in range(MOST_CONTACTS):
        end = next_loose_contact(oscillator, wall, phase, velocity)
        speed = oscillator.restitution * abs(end.velocity)
        leaves = leave(oscillator, end.wall, end.phase, speed, math.inf)
        if over or not end.found or leaves.rests:
            break
        one = flight_jacobian(oscillator, phase, velocity, end)
        own = flight_sensitivity(oscillator, parameter, wall, phase, velocity, end)
        change, jacobian = carry(one, change, own), multiply(one, jacobian)
        contact = Contact(0.0, leaves.speed, OUTCOME_RETURNED)
        one = contact_jacobian(oscillator, end.wall, end.phase, abs(end.velocity), contact)
        own = contact_sensitivity(oscillator, parameter, end.wall, end.phase, abs(end.velocity), contact)
        change, jacobian = carry(one, change, own), multiply(one, jacobian)
        elapsed += end.duration
        if end.wall == UPPER:
            impact = Impact(leaves.phase, leaves.speed, lower_impacts, OUTCOME_RETURNED, elapsed)
            return impact, by_speeds(jacobian), (change[0], -change[1])
        wall, phase, velocity = LOWER, leaves.phase, leaves.speed
    return Impact(math.nan, math.nan, 0, OUTCOME_NOT_CONVERGED, math.nan), jacobian, change


@chosen_by_field("arcs", _next_loose_impact_with_sensitivity)
def next_impact_with_sensitivity(oscillator, parameter, t, v, over):
    """One application of P, its derivative by (t, v), and that by a parameter.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    parameter : int
        Its place in `Oscillator.parameters`.
    t, v : float
        A departure from +beta: finite, v > 0.
    over : bool
        Whether the flight passes -beta as if it were not there (`fly_over`). Loose gears have no such flight.

    Returns
    -------
    (Impact, Jacobian, (float, float))
        The impact, DP, and dP/dp as (dt, dv); of no meaning where contact is permanent. A loose gear that comes to
        rest has none: its outcome is NOT_CONVERGED.
    """
    # In one function: with a part of it in another, the compiler fuses other products, and last bits of dP/dp change.
    passage = walk(oscillator, t, v, FORWARDS, over=over, reduces=False)
    fall, lower, rise = passage.fall, passage.lower, passage.rise
    jacobian = flight_jacobian(oscillator, t, -v, fall)
    change = flight_sensitivity(oscillator, parameter, UPPER, t, -v, fall)
    if passage.lower_impacts > 0:
        speed = -fall.velocity
        one = contact_jacobian(oscillator, LOWER, fall.phase, speed, lower)
        change = carry(one, change, contact_sensitivity(oscillator, parameter, LOWER, fall.phase, speed, lower))
        jacobian = multiply(one, jacobian)
        one = flight_jacobian(oscillator, passage.rises_at, lower.speed, rise)
        own = flight_sensitivity(oscillator, parameter, LOWER, passage.rises_at, lower.speed, rise)
        change, jacobian = carry(one, change, own), multiply(one, jacobian)
    one = contact_jacobian(oscillator, UPPER, rise.phase, rise.velocity, passage.upper)
    own = contact_sensitivity(oscillator, parameter, UPPER, rise.phase, rise.velocity, passage.upper)
    change, jacobian = carry(one, change, own), multiply(one, jacobian)
    return impact_after(passage), by_speeds(jacobian), (change[0], -change[1])

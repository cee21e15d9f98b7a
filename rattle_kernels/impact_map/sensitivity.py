"""dP/dp, the derivative of the impact map by a parameter of the oscillator, in closed form.

Flights and contacts are known as y(tau; w, p) and x(tau; u, p). Differentiated at fixed beginning and fixed tau they
give the change of displacement, dy, and of velocity, dy'. The end of a piece moves by

    d tau = (d target - dy)/y',    d target = -+2 for the half backlash where a flight crosses it, else 0,

and the velocity there by dy' + y'' d tau. The piece's own derivative (`jacobian`) carries a change from its beginning
to its end. So the changes of a whole application add up along it.

With x = delta tau, S = sin, C = cos at the phases met, a flight has (Eqs. 18, 24, 30 with their errata)

    dy/d eps   = 2 pi S0 tau phi1 + C - C0,            dy'/d eps   = -delta dy/d eps - 2 pi (S - S0) + delta (C - C0),
    dy/d delta = tau^2 (4 pi - w - 2 pi eps S0) (phi2 + x phi2'),
    dy'/d delta = 4 pi tau - y - delta dy/d delta + eps (C - C0).
"""

import math

from rattle_kernels.impact_map.apply import FORWARDS, walk
from rattle_kernels.impact_map.flights import LOWER, UPPER
from rattle_kernels.impact_map.jacobian import by_speeds, contact_jacobian, flight_jacobian, impact_after, multiply
from rattle_kernels.model.contact import slow_part
from rattle_kernels.model.flight import FOUR_PI, TWO_PI, rest_acceleration, second_phi, second_phi_slope
from rattle_kernels.numerics.jit import inlined
from rattle_kernels.numerics.phase import part_turn

DAMPING, ECCENTRICITY, HALF_BACKLASH, STIFFNESS = 0, 1, 2, 3


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
        drive = velocity + TWO_PI * oscillator.eccentricity * math.sin(here)
        change = tau * tau * (FOUR_PI - drive) * (phi2 + x * second_phi_slope(x))
        return change, FOUR_PI * tau - displacement - damping * change + oscillator.eccentricity * cosine_change
    return 0.0, 0.0


@inlined
def _flight_sensitivity(oscillator, parameter, wall, phase, velocity, end):
    """Change of (time of its end, velocity as an elastic impact turns it) of a flight from a fixed departure."""
    crossing = 0.5 * (end.wall - wall)  # -1 down, +1 up, 0 back to the same wall
    displacement = 2.0 * crossing * oscillator.half_backlash
    change, rate_change = _flight_change(oscillator, parameter, phase, velocity, end, displacement)
    target_change = 2.0 * crossing if parameter == HALF_BACKLASH else 0.0
    later = (target_change - change) / end.velocity
    arriving = rest_acceleration(oscillator, end.phase) - oscillator.damping * end.velocity
    return later, -(rate_change + arriving * later)


@inlined
def _slow_change(oscillator, parameter):
    """Change of mean, cosine and sine of the slow part of a contact (`model.contact.slow_part`)."""
    damping, eccentricity = oscillator.damping, oscillator.eccentricity
    square = 2.0 * oscillator.stiffness
    detuning, drag = square - TWO_PI * TWO_PI, TWO_PI * damping
    size = detuning * detuning + drag * drag
    cosine, sine = TWO_PI * detuning - damping * drag, damping * detuning + TWO_PI * drag
    strength = -TWO_PI * eccentricity / size
    if parameter == ECCENTRICITY:
        return 0.0, -TWO_PI / size * cosine, -TWO_PI / size * sine
    if parameter == DAMPING:
        shrink = 2.0 * TWO_PI * drag / size
        return (
            FOUR_PI / square,
            -strength * (shrink * cosine + 2.0 * drag),
            strength * (detuning + TWO_PI * TWO_PI - shrink * sine),
        )
    if parameter == STIFFNESS:
        shrink = 4.0 * detuning / size
        mean = -2.0 * FOUR_PI * damping / (square * square)
        return mean, strength * (2.0 * TWO_PI - shrink * cosine), strength * (2.0 * damping - shrink * sine)
    return 0.0, 0.0, 0.0


@inlined
def _ringing_change(oscillator, parameter, tau):
    """S, S' of a contact, their changes, and those of delta and of omega^2 themselves."""
    damping, square = oscillator.damping, 2.0 * oscillator.stiffness
    frequency = math.sqrt(square - 0.25 * damping * damping)
    left = math.exp(-0.5 * damping * tau)
    pulse, swing = left * math.sin(frequency * tau) / frequency, left * math.cos(frequency * tau)
    rate = swing - 0.5 * damping * pulse
    d_damping = 1.0 if parameter == DAMPING else 0.0
    d_square = 2.0 if parameter == STIFFNESS else 0.0
    d_frequency = (0.5 * d_square - 0.25 * damping * d_damping) / frequency
    d_pulse = -0.5 * tau * d_damping * pulse + d_frequency * (tau * swing - pulse) / frequency
    d_swing = -0.5 * tau * d_damping * swing - d_frequency * tau * frequency * pulse
    d_rate = d_swing - 0.5 * (d_damping * pulse + damping * d_pulse)
    return pulse, rate, d_pulse, d_rate, d_damping, d_square


@inlined
def _contact_sensitivity(oscillator, parameter, side, phase, speed, contact):
    """Change of (time of leaving, signed velocity then) of a contact from a fixed entry; x as in `model.contact`."""
    if contact.duration == 0.0:
        return 0.0, 0.0
    damping, square = oscillator.damping, 2.0 * oscillator.stiffness
    pulse, rate, d_pulse, d_rate, d_damping, d_square = _ringing_change(oscillator, parameter, contact.duration)
    settled = 1.0 - rate - damping * pulse
    d_settled = -d_rate - d_damping * pulse - damping * d_pulse
    slow = slow_part(oscillator)
    here, there = TWO_PI * part_turn(phase), TWO_PI * part_turn(phase + contact.duration)
    sine, cosine = math.sin(here), math.cos(here)
    sine_end, cosine_end = math.sin(there), math.cos(there)
    level = side * (slow.mean + slow.cosine * cosine + slow.sine * sine)
    slope = side * TWO_PI * (slow.sine * cosine - slow.cosine * sine)
    d_mean, d_cosine, d_sine = _slow_change(oscillator, parameter)
    d_level = side * (d_mean + d_cosine * cosine + d_sine * sine)
    d_slope = side * TWO_PI * (d_sine * cosine - d_cosine * sine)
    d_level_end = side * (d_mean + d_cosine * cosine_end + d_sine * sine_end)
    d_slope_end = side * TWO_PI * (d_sine * cosine_end - d_cosine * sine_end)
    change = (speed - slope) * d_pulse + level * d_settled + d_level * (settled - 1.0) + d_level_end - d_slope * pulse
    rate_change = (speed - slope) * d_rate + d_level * square * pulse + d_slope_end - d_slope * rate
    rate_change += level * (d_square * pulse + square * d_pulse)
    later = change / contact.speed
    leaving = side * rest_acceleration(oscillator, phase + contact.duration) + damping * contact.speed
    return later, side * (rate_change + leaving * later)


@inlined
def _carry(jacobian, sensitivity, own):
    """Sensitivity after a piece: the piece's derivative carries what came before, and its own is added."""
    t, w = sensitivity
    return jacobian.tt * t + jacobian.tv * w + own[0], jacobian.vt * t + jacobian.vv * w + own[1]


@inlined
def next_impact_with_sensitivity(oscillator, parameter, t, v, over):
    """One application of P, its derivative by (t, v), and that by a parameter.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    parameter : int
        DAMPING, ECCENTRICITY, HALF_BACKLASH or STIFFNESS.
    t, v : float
        A departure from +beta: finite, v > 0.
    over : bool
        Whether the flight passes -beta as if it were not there (`fly_over`).

    Returns
    -------
    (Impact, Jacobian, (float, float))
        The impact, DP, and dP/dp as (dt, dv); of no meaning where contact is permanent.
    """
    # In one function: with a part of it in another, the compiler fuses other products, and last bits of dP/dp change.
    passage = walk(oscillator, t, v, FORWARDS, over, False)
    fall, lower, rise = passage.fall, passage.lower, passage.rise
    jacobian = flight_jacobian(oscillator, t, -v, fall)
    change = _flight_sensitivity(oscillator, parameter, UPPER, t, -v, fall)
    if passage.lower_impacts > 0:
        speed = -fall.velocity
        one = contact_jacobian(oscillator, LOWER, fall.phase, speed, lower)
        change = _carry(one, change, _contact_sensitivity(oscillator, parameter, LOWER, fall.phase, speed, lower))
        jacobian = multiply(one, jacobian)
        one = flight_jacobian(oscillator, passage.rises_at, lower.speed, rise)
        own = _flight_sensitivity(oscillator, parameter, LOWER, passage.rises_at, lower.speed, rise)
        change, jacobian = _carry(one, change, own), multiply(one, jacobian)
    one = contact_jacobian(oscillator, UPPER, rise.phase, rise.velocity, passage.upper)
    own = _contact_sensitivity(oscillator, parameter, UPPER, rise.phase, rise.velocity, passage.upper)
    change, jacobian = _carry(one, change, own), multiply(one, jacobian)
    return impact_after(passage), by_speeds(jacobian), (change[0], -change[1])

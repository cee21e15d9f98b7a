"""Slow part of a contact under several harmonics of the forcing.

It is p = mean + sum of here cos(2 pi n tau) + quarter sin(2 pi n tau): in contact every harmonic drives a motion of its
own order (Eqs. 34-37 with n times the rate). The functions here add them to what the first harmonic gives, as in
`model.harmonics`.
"""

import math
from typing import NamedTuple

from rattle_kernels.model.harmonics import TWO_PI
from rattle_kernels.numerics.jit import inlined, mapped_over_tuple, summed_over_tuple
from rattle_kernels.numerics.phase import part_turn


class SlowHarmonic(NamedTuple):
    """Slow part of one order in contact above: ``cosine cos(2 pi order t) + sine sin(2 pi order t)``."""

    order: float
    cosine: float
    sine: float


class SlowState(NamedTuple):
    """Slow part of one order from a contact's beginning on: ``here cos(2 pi order tau) + quarter sin(...)``."""

    order: float
    here: float
    quarter: float


@inlined
def response(amplitude, rate, damping, square, drag):
    """Parts of cosine and of sine with which contact answers a harmonic of the forcing.

    Parameters
    ----------
    amplitude, rate : float
        Of ``amplitude cos(rate t)``: 2 pi times the order.
    damping, drag : float
        delta in freeplay, and the damping in contact.
    square : float
        omega^2 = 2 kappa.
    """
    detuning, lag = square - rate * rate, rate * drag
    strength = -rate * amplitude / (detuning * detuning + lag * lag)
    return strength * (rate * detuning - damping * lag), strength * (damping * detuning + rate * lag)


@inlined
def response_change(amplitude, rate, numbers):
    """Change of `response`; `numbers` are damping, square, drag and their changes, in this order."""
    damping, square, drag, d_damping, d_square, d_drag = numbers
    detuning, lag = square - rate * rate, rate * drag
    size = detuning * detuning + lag * lag
    strength, shrink = -rate * amplitude / size, 2.0 * (detuning * d_square + lag * rate * d_drag) / size
    cosine, sine = rate * detuning - damping * lag, damping * detuning + rate * lag
    d_cosine = rate * d_square - d_damping * lag - damping * rate * d_drag
    d_sine = d_damping * detuning + damping * d_square + rate * rate * d_drag
    return strength * (d_cosine - shrink * cosine), strength * (d_sine - shrink * sine)


@inlined
def _slow_harmonic(harmonic, contact):
    damping, square, drag = contact
    cosine, sine = response(harmonic.amplitude, TWO_PI * harmonic.order, damping, square, drag)
    angle = TWO_PI * part_turn(harmonic.phase)
    turn_cosine, turn_sine = math.cos(angle), math.sin(angle)
    return SlowHarmonic(
        harmonic.order, cosine * turn_cosine + sine * turn_sine, sine * turn_cosine - cosine * turn_sine
    )


slow_harmonics = mapped_over_tuple(_slow_harmonic, SlowHarmonic)
"""Slow parts of harmonics: ``slow_harmonics(harmonics, (damping, square, drag))``."""


@inlined
def _state_at(slow, place):
    side, phase = place
    angle = TWO_PI * part_turn(slow.order * part_turn(phase))
    cosine, sine = side * math.cos(angle), side * math.sin(angle)
    return SlowState(slow.order, slow.cosine * cosine + slow.sine * sine, slow.sine * cosine - slow.cosine * sine)


slow_states_at = mapped_over_tuple(_state_at, SlowState)
"""Slow parts where a contact begins: ``slow_states_at(slow_harmonics, (side, phase))``."""


@summed_over_tuple
def add_start(terms, total, place):
    """Add depth and rate of the slow part where the contact begins."""
    depth, rate = total
    for state in terms:
        depth += state.here
        rate += TWO_PI * state.order * state.quarter
    return depth, rate


@summed_over_tuple
def add_change(terms, total, place):
    """Add change of depth and of rate, and second and third derivative less sign, after tau, which is `place`."""
    change, rate_change, bend, jerk = total
    for state in terms:
        rate = TWO_PI * state.order
        half_angle = math.pi * part_turn(state.order * place)
        sine_half, cosine_half = math.sin(half_angle), math.cos(half_angle)
        own = 2.0 * sine_half * (state.quarter * cosine_half - state.here * sine_half)
        own_rate = -rate * 2.0 * sine_half * (state.here * cosine_half + state.quarter * sine_half)
        change += own
        rate_change += own_rate
        bend += rate * rate * (state.here + own)
        jerk += rate * rate * (rate * state.quarter + own_rate)
    return change, rate_change, bend, jerk


@summed_over_tuple
def add_swing(terms, total, place):
    """Add the largest derivative of each slow part; `place` is which one, 0 for the slow part itself."""
    for state in terms:
        total += (TWO_PI * state.order) ** place * math.hypot(state.here, state.quarter)
    return total


@summed_over_tuple
def add_bend_here(terms, total, place):
    """Add the second derivatives, less their sign, where the contact begins."""
    for state in terms:
        rate = TWO_PI * state.order
        total += rate * rate * state.here
    return total

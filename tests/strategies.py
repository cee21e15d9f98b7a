"""Hypothesis strategies: oscillators and departures inside the domain of the map."""

import math

from hypothesis import strategies as st

from rattle_kernels import Harmonic, Oscillator, eccentricity_bound_smooth_maxima

phases = st.floats(0.0, 1.0, exclude_max=True)


@st.composite
def oscillators(draw, largest_part_of_bound=0.95):
    """Impacting oscillators, log-uniform in damping and backlash, eccentricity a part of its bound (Eq. 8)."""
    damping = 10.0 ** draw(st.floats(-4.0, 0.0))
    half_backlash = 10.0 ** draw(st.floats(-4.0, 0.2))
    part = draw(st.floats(0.0, largest_part_of_bound))
    bare = Oscillator(damping=damping, half_backlash=half_backlash)
    return bare._replace(eccentricity=part * eccentricity_bound_smooth_maxima(bare))


@st.composite
def stiff_oscillators(draw):
    """Piecewise linear oscillators of either rule, below the bound of Eq. (3) and somewhat beyond it."""
    oscillator = draw(oscillators(largest_part_of_bound=0.97))
    stiffness, permanent_after = 10.0 ** draw(st.floats(1.0, 7.0)), draw(st.sampled_from([math.inf, 1.0]))
    return oscillator._replace(stiffness=stiffness, permanent_after=permanent_after)


def speeds(oscillator, least=1e-3, most=4.0):
    """Speeds between `least` and `most` times the natural scale, that of a fall through the backlash."""
    scale = (8.0 * 3.141592653589793 * oscillator.damping * 2.0 * oscillator.half_backlash) ** 0.5
    return st.floats(least, most).map(lambda part: part * scale)


@st.composite
def wider_oscillators(draw):
    """Impacting oscillators with a second and a third harmonic whose impacts lose energy, inside Eq. (8)."""
    bare = draw(oscillators(largest_part_of_bound=0.0))
    bound = eccentricity_bound_smooth_maxima(bare)
    # Together below 0.9 of the bound; a harmonic of order n shakes n^2 times as hard.
    parts = [draw(st.floats(0.02, 0.3)) for _ in range(3)]
    amplitudes = [part * bound / order**2 for order, part in enumerate(parts, 1)]
    return bare._replace(
        eccentricity=amplitudes[0], restitution=draw(st.floats(0.3, 1.0)),
        harmonics=tuple(Harmonic(float(n), amplitudes[n - 1], draw(phases)) for n in (2, 3)),
    )  # fmt: skip


@st.composite
def wider_stiff_oscillators(draw):
    """Piecewise linear oscillators with a second and a third harmonic whose contacts lose energy."""
    oscillator = draw(wider_oscillators())
    stiffness, contact_damping = 10.0 ** draw(st.floats(1.0, 7.0)), draw(st.floats(0.0, 0.7))
    return oscillator._replace(stiffness=stiffness, restitution=1.0, contact_damping=contact_damping)

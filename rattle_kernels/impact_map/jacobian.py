"""DP, the derivative of the impact map: the product of the variations of its flights and contacts (`variations`)."""

from rattle_kernels.impact_map.apply import walk
from rattle_kernels.impact_map.flights import FORWARDS, LOWER, UPPER
from rattle_kernels.impact_map.loose_map import Impact, next_loose_impact_with_jacobian
from rattle_kernels.impact_map.variations import by_speeds, contact_jacobian, flight_jacobian, multiply
from rattle_kernels.numerics.jit import chosen_by_field, inlined
from rattle_kernels.numerics.phase import wrap


@inlined
def impact_after(passage):
    """The impact that a walk has made; not a number where contact is permanent."""
    upper = passage.upper
    phase = wrap(passage.rise.phase + upper.duration)
    return Impact(phase, upper.speed, passage.lower_impacts, upper.outcome, passage.flown + upper.duration)


@chosen_by_field("arcs", next_loose_impact_with_jacobian)
def next_impact_with_jacobian(oscillator, t, v):
    """One application of P and its derivative.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t, v : float
        A departure from +beta: finite, v > 0.

    Returns
    -------
    (Impact, Jacobian)
        The impact, and DP; of no meaning where contact is permanent.
    """
    passage = walk(oscillator, t, v, FORWARDS, over=False, reduces=False)
    fall, rise = passage.fall, passage.rise
    jacobian = flight_jacobian(oscillator, t, -v, fall)
    if passage.lower_impacts > 0:
        lower = contact_jacobian(oscillator, LOWER, fall.phase, -fall.velocity, passage.lower)
        jacobian = multiply(lower, jacobian)
        jacobian = multiply(flight_jacobian(oscillator, passage.rises_at, passage.lower.speed, rise), jacobian)
    upper = contact_jacobian(oscillator, UPPER, rise.phase, rise.velocity, passage.upper)
    return impact_after(passage), by_speeds(multiply(upper, jacobian))

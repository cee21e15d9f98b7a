"""A machine in permanent contact is hit by a momentary pulse: the first departure from +beta after it.

Permanent contact is one motion. In the impacting model the teeth rest on +beta. In the piecewise linear model they lie
p(t) beyond it, the slow part of a contact (`model.contact`), without any ringing. A pulse that is short against a
contact leaves the place as it is and changes the velocity.

*A pulse that parts the teeth* by v makes a departure at its own phase (t, v) in the impacting model. In the other one
the teeth first come back from p: they leave +beta only if what rings exceeds p there, which takes about v > omega p.

*A pulse that presses them together* is an impact of speed v: r v departs at the same phase. In the piecewise linear
model the contact rings, and leaves as above after half a ringing period more; for omega p << v with r = exp(-pi zeta/
sqrt(1 - zeta^2)) of its speed, so that the one model is the limit of the other. There is no departure from a contact
that goes on for ever.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.flights import UPPER
from rattle_kernels.model.contact import enter_contact
from rattle_kernels.model.contact_end import follow_contact_from
from rattle_kernels.model.departures import check_phases
from rattle_kernels.model.domain import check_domain, check_quiet
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_RETURNED
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.numerics.phase import part_turn, wrap


class PulseDepartures(NamedTuple):
    """First departures from +beta after pulses, arrays of one shape; NaN where the teeth never part.

    ``t`` is the phase in [0, 1), ``v`` the speed, and ``delay`` the time since the pulse, forcing periods.
    """

    t: np.ndarray
    v: np.ndarray
    delay: np.ndarray


@kernel
def _depart(oscillator, t, parting, departures):
    stiff = math.isfinite(oscillator.stiffness)
    for i in range(t.size):
        if stiff:
            quiet = enter_contact(oscillator, UPPER, t[i], 0.0, 0.0)
            depth, rate = quiet.mean + quiet.slow, quiet.slow_rate
            contact = follow_contact_from(oscillator, UPPER, t[i], depth, rate - parting[i])
            if contact.outcome == OUTCOME_RETURNED:
                phase = wrap(part_turn(t[i]) + contact.duration)
                departures[:, i] = phase, contact.speed, contact.duration
        elif parting[i] != 0.0:
            speed = parting[i] if parting[i] > 0.0 else -oscillator.restitution * parting[i]
            departures[:, i] = wrap(t[i]), speed, 0.0


def departures_after_pulses(
    oscillator: Oscillator, t: np.typing.ArrayLike, parting: np.typing.ArrayLike
) -> PulseDepartures:
    """Depart from permanent contact by momentary pulses.

    Parameters
    ----------
    oscillator : Oscillator
        Either model, with a quiet solution.
    t : array_like
        Phases of the pulses, forcing periods, any finite value.
    parting : array_like, of the same shape
        Speed with which each pulse parts the teeth; negative where it presses them together.

    Returns
    -------
    PulseDepartures

    Raises
    ------
    OutsideDomain
        If the oscillator has no quiet solution, or its parameters lie outside the domain of the map.
    ValueError
        If a phase or a speed is not finite.

    Examples
    --------
    >>> after = departures_after_pulses(Oscillator(restitution=0.5), [0.25, 0.25, 0.25], [2.0, -2.0, 0.0])
    >>> after.v
    array([ 2.,  1., nan])

    Contact of finite stiffness holds a weak pulse:

    >>> departures_after_pulses(Oscillator(stiffness=1e4), [0.25, 0.25], [0.01, 2.0]).v.round(3)
    array([  nan, 1.998])
    """
    checked = check_domain(check_quiet(oscillator))
    phases, changes = np.broadcast_arrays(check_phases(t), check_phases(parting, "parting"))
    departures = np.full((3, phases.size), np.nan)
    _depart(checked, np.ascontiguousarray(phases.ravel()), np.ascontiguousarray(changes.ravel()), departures)
    return PulseDepartures(*departures.reshape(3, *phases.shape))

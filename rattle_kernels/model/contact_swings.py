"""Contacts of several swings: around which nodes of the table none of them ends early.

A contact above may last for several swings of its ringing. Its depth x then has minima on the way, and the contact ends
early where one of them falls to the wall. A node of the table stands for all contacts of its box: those whose phase and
speed are nearest to it. Where no minimum of the node's own contact is so low that it could reach the wall within the
box, every contact of the box ends as late as the node's.

Depths are sampled, at most h apart. Let M and J bound the second and third derivative of x in the whole box
(`model.contact`), and a the acceleration at rest from below. At the wall x'' is at least a - delta x'. So x' rises from
the beginning, where it is not negative, for (a - delta u)/J, and it has risen for a/J before the end, where it is not
positive: neither stretch has a minimum. At any other minimum x' = 0, so the nearest sample is at most M h^2/8 deeper.
"""

import math

from rattle_kernels.model.contact import bend_bound, jerk_bound, state_in_contact
from rattle_kernels.model.contact_end import first_zero
from rattle_kernels.model.flight import TWO_PI
from rattle_kernels.model.slow_harmonics import add_bend_here, add_swing
from rattle_kernels.numerics.jit import inlined

# Samples a turn of the ringing: M h^2/8 is then a two-hundredth of the ringing.
_SAMPLES = 32
# Longer contacts are rare.
_MOST_TURNS = 8.0


@inlined
def ends_late_around(contact, duration, least_press, phase_step, speed_step):
    """Whether all contacts near this one end as late.

    Parameters
    ----------
    contact : ContactMotion
    duration : float
        Its end.
    least_press : float
        Least acceleration at rest, of all phases.
    phase_step, speed_step : float
        Half the sides of the box.

    Returns
    -------
    bool
    """
    damping, frequency = contact.damping, contact.frequency
    turns = duration * frequency / TWO_PI
    if not turns < _MOST_TURNS:
        return False
    slow_rate = contact.slow_rate
    bend_here = add_bend_here(contact.harmonics, TWO_PI * TWO_PI * contact.here, None)
    # Within the box the slow part changes by `shift` at most, its rate by `tilt`.
    shift = TWO_PI * contact.swing * phase_step
    tilt = TWO_PI * shift + phase_step * add_swing(contact.harmonics, 0.0, 2)
    shift += phase_step * add_swing(contact.harmonics, 0.0, 1)
    ringing = contact.ringing + shift + (speed_step + tilt + damping * shift) / frequency
    bend, jerk = bend_bound(contact, ringing), jerk_bound(contact, ringing)
    h = TWO_PI / (_SAMPLES * frequency)
    rest = 0.125 * bend * h * h + tilt * phase_step * (1.0 + math.pi / frequency)
    most = shift * (2.0 + damping / frequency) + (tilt + speed_step) / frequency + rest
    tau = (least_press - damping * (contact.speed + speed_step)) / jerk
    tau = max(tau - 0.5 * h, 0.5 * h)
    ends = duration - least_press / jerk + 0.5 * h
    while tau < ends:
        state = state_in_contact(contact, tau)
        # x is linear in the speed. Its second derivative with respect to the phase is in `rest`.
        left = math.exp(-0.5 * damping * tau)
        pulse = left * math.sin(frequency * tau) / frequency
        fall = left * math.cos(frequency * tau) + 0.5 * damping * pulse
        along_phase = state.slow_rate - slow_rate * fall + bend_here * pulse
        if state.depth <= abs(pulse) * speed_step + abs(along_phase) * phase_step + rest:
            return False
        # No sample is needed where x stays deeper than it changes anywhere.
        tau += max(h, first_zero(state.depth - most, state.rate, -bend)) if state.depth > most else h
    return True

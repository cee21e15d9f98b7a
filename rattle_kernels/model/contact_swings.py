"""Contacts of several swings: around which nodes of the table none of them ends early.

A contact above may last for several swings of its ringing. Its depth x then has minima on the way, and the contact ends
early where one of them falls to the wall. A node of the table stands for all contacts of its box: those whose phase and
speed are nearest to it. Where no minimum of the node's own contact is so low that it could reach the wall within the
box, every contact of the box ends as late as the node's.

Depths are sampled, at most h apart. Let M and J bound the second and third derivative of x in the whole box
(`model.contact`), and a the acceleration at rest from below. At the wall x'' is at least a - delta x'. So x' rises from
the beginning, where it is not negative, for (a - delta u)/J, and it has risen for a/J before the end, where it is not
positive: neither stretch has a minimum. At any other minimum x' = 0, so the nearest sample is at most M h^2/8 deeper.

A contact may also last for ever. Then the samples go on until the slow part exceeds what is left of the ringing.
"""

import math
from typing import NamedTuple

from rattle_kernels.model.contact import bend_bound, jerk_bound, state_in_contact
from rattle_kernels.model.contact_end import first_zero, time_above_ringing
from rattle_kernels.model.flight import TWO_PI
from rattle_kernels.model.slow_harmonics import add_bend_here, add_swing
from rattle_kernels.numerics.jit import inlined

# Samples a turn of the ringing: M h^2/8 is then a two-hundredth of the ringing.
_SAMPLES = 32
# Longer contacts are rare.
_MOST_TURNS = 8.0
# Permanent contacts need some 20.
_MOST_SAMPLES = 256


class _Box(NamedTuple):
    """Bounds within a box of contacts, half of whose sides are `phase_step` and `speed_step`.

    The slow part changes by ``shift`` at most. ``ringing`` bounds the ringing at the beginning, ``bend`` and ``jerk``
    the derivatives of x. ``between`` is how much deeper than a minimum the nearest sample may be, with what is of
    second order in the phase. ``most`` adds how much x changes anywhere in the box. Samples are ``h`` apart.
    """

    phase_step: float
    speed_step: float
    shift: float
    ringing: float
    bend: float
    jerk: float
    bend_here: float
    between: float
    most: float
    h: float


@inlined
def _box_around(contact, phase_step, speed_step):
    damping, frequency = contact.damping, contact.frequency
    bend_here = add_bend_here(contact.harmonics, TWO_PI * TWO_PI * contact.here, None)
    # The rate of the slow part changes by `tilt`.
    shift = TWO_PI * contact.swing * phase_step
    tilt = TWO_PI * shift + phase_step * add_swing(contact.harmonics, 0.0, 2)
    shift += phase_step * add_swing(contact.harmonics, 0.0, 1)
    ringing = contact.ringing + shift + (speed_step + tilt + damping * shift) / frequency
    bend, jerk = bend_bound(contact, ringing), jerk_bound(contact, ringing)
    h = TWO_PI / (_SAMPLES * frequency)
    between = 0.125 * bend * h * h + tilt * phase_step * (1.0 + math.pi / frequency)
    most = shift * (2.0 + damping / frequency) + (tilt + speed_step) / frequency + between
    return _Box(phase_step, speed_step, shift, ringing, bend, jerk, bend_here, between, most, h)


@inlined
def _first_sample(contact, box, least_press):
    """Time before which no contact of the box has a minimum."""
    tau = (least_press - contact.damping * (contact.speed + box.speed_step)) / box.jerk
    return max(tau - 0.5 * box.h, 0.5 * box.h)


@inlined
def _may_touch(contact, box, state, tau):
    """Whether a minimum of a contact of the box, nearer to this sample than to any other, may be at the wall."""
    damping, frequency = contact.damping, contact.frequency
    # x is linear in the speed. Its second derivative with respect to the phase is in `between`.
    left = math.exp(-0.5 * damping * tau)
    pulse = left * math.sin(frequency * tau) / frequency
    fall = left * math.cos(frequency * tau) + 0.5 * damping * pulse
    along_phase = state.slow_rate - contact.slow_rate * fall + box.bend_here * pulse
    return state.depth <= abs(pulse) * box.speed_step + abs(along_phase) * box.phase_step + box.between


@inlined
def _next_sample(box, state):
    """Time until the next sample: none is needed where x stays deeper than it changes anywhere."""
    if state.depth <= box.most:
        return box.h
    return max(box.h, first_zero(state.depth - box.most, state.rate, -box.bend))


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
    turns = duration * contact.frequency / TWO_PI
    if not turns < _MOST_TURNS:
        return False
    box = _box_around(contact, phase_step, speed_step)
    tau = _first_sample(contact, box, least_press)
    ends = duration - least_press / box.jerk + 0.5 * box.h
    while tau < ends:
        state = state_in_contact(contact, tau)
        if _may_touch(contact, box, state, tau):
            return False
        tau += _next_sample(box, state)
    return True


@inlined
def lasts_around(contact, least_press, phase_step, speed_step):
    """Whether all contacts near this one last for ever.

    A contact that ends between two samples of positive depth has a minimum between them. So none ends where no minimum
    may be at the wall, and none where the slow part exceeds the ringing that is left.

    Parameters
    ----------
    contact : ContactMotion
        One above that lasts.
    least_press, phase_step, speed_step : float
        As in `ends_late_around`.

    Returns
    -------
    bool
    """
    box = _box_around(contact, phase_step, speed_step)
    least = contact.mean - add_swing(contact.harmonics, contact.swing, 0) - box.shift
    tau = _first_sample(contact, box, least_press)
    for _ in range(_MOST_SAMPLES):
        state = state_in_contact(contact, tau)
        if _may_touch(contact, box, state, tau):
            return False
        ringing = box.ringing * state.ringing / contact.ringing
        if ringing < least:
            return True
        tau += max(time_above_ringing(contact, state, ringing + box.shift), _next_sample(box, state))
    return False

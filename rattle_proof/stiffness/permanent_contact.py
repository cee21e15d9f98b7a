"""Permanent contact: that the slow part keeps off the wall (Eq. 3), and what rings around it stays there for ever.

In contact ``z = x - p`` is an oscillation without forcing, ``z'' + d z' + omega^2 z = 0``. So the ringing
``r = |(z, (z' + d z/2)/q)|`` is multiplied by ``e^(-d tau/2)``: where r is below the least p, contact never ends.
"""

from typing import NamedTuple

from flint import arb

from rattle_proof.stiffness.contact import StiffMachine
from rattle_proof.stiffness.impact_map import NotProven
from rattle_proof.verification.machine import ball

_PHASES, _HALVINGS = 64, 14


class PermanentContact(NamedTuple):
    """Bounds below: of the slow part's depth, of the velocity that rings so far, of the rate of decay."""

    depth: float
    velocity: float
    decay: float


def permanent_contact(machine: StiffMachine) -> PermanentContact:
    """Prove that permanent contact exists and attracts.

    Raises
    ------
    NotProven
        If the slow part leaves the wall, or comes so near to it that this is not told.
    """
    least = arb.pos_inf()
    waiting = [(arb(i) / _PHASES, arb(i + 1) / _PHASES, 0) for i in range(_PHASES)]
    while waiting:
        begin, end, halvings = waiting.pop()
        phases = ball(begin, end)
        middle = phases.mid()
        if not machine.slow_part(middle)[0] > 0:
            raise NotProven("it does not exist (Eq. 3), or nearly so")
        # In the mean value form.
        lowest = (machine.slow_part(middle)[0] + machine.slow_part(phases)[1] * (phases - middle)).lower()
        if lowest > 0:
            least = least.min(lowest)
        elif halvings < _HALVINGS:
            waiting += [(begin, middle, halvings + 1), (middle, end, halvings + 1)]
        else:
            raise NotProven("it comes too near to the wall")
    return PermanentContact(_below(least), _below(least * machine.frequency), _below(machine.drag / 2))


def _below(number: arb) -> float:
    """A double that is not above a ball."""
    return float(number.lower()) * (1 - 2.0**-50)

"""The end of a contact that is nearly known is the one that a search from its beginning finds."""

import math

import numpy as np
import pytest

from rattle_kernels import Oscillator
from rattle_kernels.impact_map.flights import LOWER, UPPER
from rattle_kernels.model.contact import enter_contact
from rattle_kernels.model.contact_end import end_near, follow_contact
from rattle_kernels.model.domain import check_domain
from rattle_kernels.model.outcome import OUTCOME_NOT_CONVERGED, OUTCOME_RETURNED
from rattle_kernels.numerics.jit import kernel

STIFF = [
    Oscillator(stiffness=1e2),
    Oscillator(stiffness=1e3),
    Oscillator(stiffness=1e6),
    Oscillator(damping=0.06, eccentricity=0.01, stiffness=300.0),
    Oscillator(stiffness=1e3, contact_damping=0.1),
]
_UNIT = np.finfo(float).eps


@kernel
def ends(oscillator, side, phase, speed, off):
    """End of a contact by a search, and by a look as far off the end as `off` radians of the ringing."""
    contact = enter_contact(oscillator, side, phase, 0.0, speed)
    searched = follow_contact(oscillator, side, phase, speed)
    return searched, end_near(contact, searched.duration + off / contact.frequency), contact


@pytest.mark.parametrize("side", [UPPER, LOWER])
@pytest.mark.parametrize("oscillator", STIFF, ids=lambda o: f"{o.stiffness:g}-{o.damping:g}-{o.contact_damping:g}")
def test_an_end_that_is_near_is_the_end(oscillator, side):
    rng, found = np.random.default_rng(2), 0
    for phase, part, place in rng.random((2000, 3)):
        speed, off = 7.0 * part**3, 1.8e-5 * (place - 0.5)
        searched, near, contact = ends(check_domain(oscillator), side, phase, speed, off)
        if searched.outcome != OUTCOME_RETURNED or near.outcome == OUTCOME_NOT_CONVERGED:
            continue
        found += 1
        # Both evaluate the depth to some units of its largest term (1.2 were seen); the slope turns that into a time.
        terms = speed / contact.frequency + abs(contact.mean) + contact.swing + contact.ringing
        apart = 5.0 * _UNIT * (terms / near.speed + searched.duration)
        assert abs(near.duration - searched.duration) <= apart
        assert abs(near.speed - searched.speed) <= apart * contact.square * terms + 5.0 * _UNIT * speed
    assert found > 1000


@pytest.mark.parametrize("off", [3e-5, -3e-5, 1.0, math.pi, -1.0])
def test_an_end_that_is_not_near_is_not_found(off):
    for phase in np.linspace(0.0, 1.0, 50, endpoint=False):
        searched, near, _ = ends(check_domain(Oscillator(stiffness=1e3)), UPPER, phase, 3.0, off)
        assert searched.outcome == OUTCOME_RETURNED and near.outcome == OUTCOME_NOT_CONVERGED

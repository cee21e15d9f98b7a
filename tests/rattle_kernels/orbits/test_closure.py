"""The determinant of DP^p of orbits whose contacts lose energy, by integrating the motion apart from the kernels.

Areas (Phi, Phi') shrink at the rate delta in freeplay and delta + 2 zeta sqrt(2 kappa) in contact, an impact of
restitution r shrinks v dv dt by r^2. So the determinant is e^{-delta m} r^(2 (n+ + n-)) e^{-2 zeta sqrt(2 kappa) T}
with the time T that is spent in contact.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rattle_kernels import Oscillator, SpecialKind, continue_orbit, find_orbits
from rattle_kernels.orbits.closure import OrbitShape, area_factor, closure


def time_in_contact(oscillator, t, v, periods):
    """Time beyond either wall in a number of periods, with the motion integrated from wall to wall."""
    wall = oscillator.half_backlash
    ringing = 2.0 * oscillator.contact_damping * math.sqrt(2.0 * oscillator.stiffness)

    def slope(now, state, beyond):
        angle = 2.0 * math.pi * now
        forcing = 4.0 * math.pi * oscillator.damping - 2.0 * math.pi * oscillator.eccentricity * (
            2.0 * math.pi * math.cos(angle) + oscillator.damping * math.sin(angle)
        )
        push = 0.0
        if beyond:
            push = 2.0 * oscillator.stiffness * (state[0] - beyond * wall) + ringing * state[1]
        return [state[1], forcing - oscillator.damping * state[1] - push]

    def crossing(side):
        def event(now, state, beyond):
            return state[0] - side * wall

        event.terminal = True
        return event

    events = [crossing(1.0), crossing(-1.0)]
    now, state, beyond, spent, ends = t, [wall, -v], 0.0, 0.0, t + periods
    # A motion that begins on a wall has left it after this time.
    off = 1e-9
    while now < ends - 1e-6:
        away = solve_ivp(slope, (now, now + off), state, "DOP853", args=(beyond,), rtol=1e-12, atol=1e-14)
        run = solve_ivp(
            slope, (now + off, ends + 1e-3), away.y[:, -1], "DOP853", args=(beyond,), events=events, rtol=1e-12,
            atol=1e-14,
        )  # fmt: skip
        spent += (float(run.t[-1]) - now) * bool(beyond)
        now, state = float(run.t[-1]), run.y[:, -1]
        beyond = 0.0 if beyond else math.copysign(1.0, state[0])
    assert now == pytest.approx(ends, abs=1e-8)
    assert state == pytest.approx([wall, -v], abs=1e-7)
    return spent


def expected_area(oscillator, t, v, shape, lower):
    left = math.exp(-oscillator.damping * shape.forcing_periods)
    if math.isinf(oscillator.stiffness):
        return left * oscillator.restitution ** (2 * (shape.upper_contacts + lower))
    rate = 2.0 * oscillator.contact_damping * math.sqrt(2.0 * oscillator.stiffness)
    return left * math.exp(-rate * time_in_contact(oscillator, t, v, shape.forcing_periods))


LOSSY = [
    Oscillator(0.5, restitution=0.95),
    Oscillator(0.5, stiffness=500.0, contact_damping=0.01),
    Oscillator(0.5, stiffness=2000.0, contact_damping=0.02),
]


@pytest.mark.parametrize("oscillator", LOSSY)
def test_the_determinant_of_lossy_contacts(oscillator):
    found = find_orbits(oscillator, longest=2, cells=16)
    assert any(one.orbit.lower_contacts for one in found)
    for orbit in (one.orbit for one in found):
        shape = OrbitShape(orbit.forcing_periods, orbit.upper_contacts)
        t, v = float(orbit.t[0]), float(orbit.v[0])
        area = expected_area(oscillator, t, v, shape, orbit.lower_contacts)
        here = closure(oscillator, "damping", shape, t, v)
        assert area < 0.99 * math.exp(-oscillator.damping * shape.forcing_periods)
        assert area_factor(oscillator, shape, here.jacobian) == pytest.approx(area, rel=1e-6)


@pytest.mark.parametrize("oscillator", LOSSY)
def test_branches_and_their_special_points_use_that_determinant(oscillator):
    met = False
    for orbit in (one.orbit for one in find_orbits(oscillator, longest=1, cells=16)):
        value = oscillator.damping
        branch = continue_orbit(oscillator, orbit, "damping", (0.6 * value, 1.8 * value))
        shape = OrbitShape(branch.forcing_periods, branch.upper_contacts)
        for i in np.linspace(0, branch.values.size - 1, 3).astype(int):
            here, lower = oscillator.at(damping=float(branch.values[i])), int((branch.grazing_margin[i] > 0).sum())
            area = expected_area(here, float(branch.t[i, 0]), float(branch.v[i, 0]), shape, lower)
            assert branch.area[i] == pytest.approx(area, rel=1e-6)
            assert np.prod(branch.multipliers[i]).real == pytest.approx(area, rel=1e-6)
        for point in branch.special_points:
            if point.kind in (SpecialKind.SADDLE_NODE, SpecialKind.PERIOD_DOUBLING):
                met = True
                area = expected_area(
                    point.oscillator, float(point.t[0]), float(point.v[0]), shape, point.lower_contacts
                )
                one = 1.0 if point.kind == SpecialKind.SADDLE_NODE else -1.0
                assert sorted(point.multipliers.real) == pytest.approx(sorted([one, one * area]), abs=1e-6)
    assert met

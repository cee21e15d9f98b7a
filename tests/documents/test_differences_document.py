"""What docs/paper/differences.md says of the paper, against the model's equation itself, integrated step by step."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rattle_kernels import CellGrid, Oscillator, find_orbits, grazing_preimages, grazing_velocity, map_cells

DOCUMENT = (Path(__file__).parents[2] / "docs" / "paper" / "differences.md").read_text()
DELTA, EPS, BETA, PI = 0.6, 0.1, 0.6, math.pi
# Short steps: a graze lasts a few hundredths of a period.
CLOSE = {"rtol": 1e-11, "atol": 1e-12, "method": "DOP853", "max_step": 2e-3}


def forcing(t):
    return 4 * PI * DELTA - 4 * PI**2 * EPS * np.cos(2 * PI * t) - 2 * PI * DELTA * EPS * np.sin(2 * PI * t)


def freeplay(t, state):
    return [state[1], forcing(t) - DELTA * state[1]]


def wall(height, direction):
    def crosses(t, state):
        return state[0] - height

    crosses.terminal, crosses.direction = True, direction
    return crosses


def arrival(t, phi, speed):
    """Wall, time and Phi' of the next impact."""
    walls = (wall(-BETA, -1), wall(BETA, 1))
    done = solve_ivp(freeplay, (t, t + 20), [phi, speed], events=walls, **CLOSE)
    (hit,) = (side for side in (0, 1) if done.t_events[side].size)
    return (-BETA, BETA)[hit], done.t_events[hit][0], done.y_events[hit][0][1]


def test_equation_29_has_the_other_sign_and_equation_30_with_it():
    before, u = 0.2, 3.0
    side, after, velocity = arrival(before, -BETA, u)
    assert side == BETA and velocity > 0

    def piece(leaving):  # Eqs. (27), (29) and (30) for Phi' = leaving at t_hat
        decay = math.exp(-DELTA * (after - before))
        constant = leaving + 2 * PI * EPS * math.sin(2 * PI * before) - 4 * PI
        speed = constant * decay - 2 * PI * EPS * math.sin(2 * PI * after) + 4 * PI
        cosines = math.cos(2 * PI * after) - math.cos(2 * PI * before)
        place = -constant / DELTA * (decay - 1) + EPS * cosines + 4 * PI * (after - before) - 2 * BETA
        return speed, place

    speed, place = piece(u)
    assert speed == pytest.approx(velocity, abs=1e-9) and place == pytest.approx(0.0, abs=1e-9)
    v_hat = -u  # as Eq. (23) has it; Eq. (30) as printed has 4 pi - v_hat where the piece has 4 pi - u
    printed = place + (u - v_hat) / DELTA * (math.exp(-DELTA * (after - before)) - 1)
    assert abs(printed) == pytest.approx(2 * u / DELTA * (1 - math.exp(-DELTA * (after - before))), rel=1e-9)
    assert abs(printed) > 1


def test_equation_32_has_kappa_over_pi():
    kappa, phi, t = 1000.0, -BETA - 0.01, np.linspace(0, 1, 100001)
    root = math.sqrt(4 * PI**2 + DELTA**2)

    def least(eps):
        force = 4 * PI * DELTA - 4 * PI**2 * eps * np.cos(2 * PI * t) - 2 * PI * DELTA * eps * np.sin(2 * PI * t)
        return np.min(force - 2 * kappa * (phi + BETA))

    assert least((2 * DELTA - kappa / PI * (BETA + phi)) / root) == pytest.approx(0.0, abs=1e-5)
    assert least((2 * DELTA - (BETA + phi)) / root) == pytest.approx(2 * (kappa - PI) * 0.01, abs=1e-5)


@pytest.mark.parametrize("kappa", [100.0, 1000.0])
def test_equations_37_and_38_and_the_parity_below_40(kappa):
    q = math.sqrt(2 * kappa - DELTA**2 / 4)
    p = -PI * EPS * math.sqrt((4 * PI**2 + DELTA**2) / ((kappa - 2 * PI**2) ** 2 + PI**2 * DELTA**2))
    below = PI * DELTA**2 - 2 * PI * (kappa - 2 * PI**2)
    right = math.atan(DELTA * kappa / below)
    printed = math.atan((DELTA * (kappa - 2 * PI**2) - 2 * PI**2 * DELTA) / below)
    amplitude, zeta, t = 0.03, 0.4, np.linspace(0, 1, 1001)

    def residual(phase):  # of the particular solution in Eq. (1), as a part of the forcing
        angle = 2 * PI * t + phase
        left = p * (-4 * PI**2 * np.cos(angle) - 2 * PI * DELTA * np.sin(angle) + 2 * kappa * np.cos(angle))
        return np.max(np.abs(left - (forcing(t) - 4 * PI * DELTA))) / np.max(np.abs(forcing(t) - 4 * PI * DELTA))

    assert residual(right) < 1e-12 and residual(printed) > 1e-3
    if kappa == 100.0:
        assert f"{100 * residual(printed):.0f} % of the forcing" in DOCUMENT

    def phi(t):
        return amplitude * np.exp(-DELTA * t / 2) * np.cos(q * t + zeta) + p * np.cos(2 * PI * t + right)

    decays = amplitude * np.exp(-DELTA * t / 2)
    first_two = -q * decays * np.sin(q * t + zeta) - DELTA / 2 * decays * np.cos(q * t + zeta)
    slope = (phi(t + 1e-6) - phi(t - 1e-6)) / 2e-6
    np.testing.assert_allclose(first_two - 2 * PI * p * np.sin(2 * PI * t + right), slope, atol=1e-8)
    off = np.max(np.abs(first_two - 2 * PI * p * np.cos(2 * PI * t + right) - slope))
    assert off == pytest.approx(2 * PI * abs(p) * math.sqrt(2), rel=1e-4)
    even, odd = ((m * PI - zeta) / q for m in (2, 3))
    for place, sign in ((even, -1), (odd, 1)):
        curvature = phi(place + 1e-4) - 2 * phi(place) + phi(place - 1e-4)
        assert np.sign(curvature) == sign  # a maximum at even m


@pytest.mark.slow
def test_above_the_grazing_curve_the_first_pre_image_strikes_the_lower_wall_first():
    oscillator = Oscillator(DELTA, EPS, BETA)
    _, first = grazing_preimages(oscillator, 1, velocity_limits=(0.0, 7.0))
    t, v = np.concatenate([piece.t for piece in first]), np.concatenate([piece.v for piece in first])
    clear = np.abs(v - grazing_velocity(oscillator, t % 1.0)) > 1e-3
    t, v = t[clear], v[clear]
    above = v > grazing_velocity(oscillator, t % 1.0)
    seen = {True: 0, False: 0}
    for place in np.linspace(0, t.size - 1, 60).astype(int):
        side, after, velocity = arrival(t[place], BETA, -v[place])
        assert side == (-BETA if above[place] else BETA)
        if side == -BETA:
            side, after, velocity = arrival(after, -BETA, -velocity)
        assert side == BETA
        # The departure that follows grazes -beta: it is on the grazing curve, within the curve's chords.
        assert velocity == pytest.approx(float(grazing_velocity(oscillator, after % 1.0)), abs=5e-3)
        seen[bool(above[place])] += 1
    assert min(seen.values()) >= 5


@pytest.mark.slow
def test_a_larger_prime_than_1499_changes_the_basin_at_a_damping_of_0_525():
    oscillator, grid = Oscillator(0.525, EPS, BETA), CellGrid(time_cells=50, velocity_cells=50)
    (orbit,) = (o.orbit for o in find_orbits(oscillator, longest=3) if o.orbit.name == "P(3,3,2)" and o.orbit.attracts)
    wandering = []
    for k in (1499, 15013):
        found = map_cells(oscillator, grid, k, (0, 50), (0, 50))
        rattles = found.landing_velocity > 3.9  # below are quiet, P(1,1,0) and P(1,2,0)
        away = np.full(grid.shape, np.inf)
        for t, v in zip(orbit.t, orbit.v, strict=True):
            phase = np.abs((found.landing_time - t + 0.5) % 1.0 - 0.5)
            away = np.minimum(away, np.hypot(phase, found.landing_velocity - v))
        wandering.append(np.count_nonzero(rattles & (away > 1e-2)))
    # 6.1 % of the cells within four standard errors of 2500; a mean life of 900 leaves e^-17 after ten times as long.
    error = math.sqrt(0.061 * 0.939 / 2500)
    assert abs(wandering[0] / 2500 - 0.061) < 4 * error and wandering[1] == 0

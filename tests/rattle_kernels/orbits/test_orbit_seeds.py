"""Saddles next to a graze, with large multipliers, are found from next to the grazing curve."""

from collections import Counter

import numpy as np
import pytest

from rattle_kernels import Oscillator, find_orbits, grazing_velocity, next_impacts
from rattle_kernels.manifolds.grazing_preimages import speed_of_no_return
from rattle_kernels.numerics.pausing import never_stopped
from rattle_kernels.orbits.orbit_seeds import orbit_seeds


@pytest.mark.parametrize("cells", [12, 40])
def test_a_saddle_of_multiplier_72_next_to_a_graze_is_found_from_any_grid(cells):
    found = find_orbits(Oscillator(0.3, 0.05, 0.3), longest=1, cells=cells)
    saddles = [one for one in found if one.orbit.name == "P(1,1,1)" and abs(one.orbit.multipliers).max() > 50.0]
    (saddle,) = (one.orbit for one in saddles)
    assert saddle.v[0] == pytest.approx(1.953946547915, abs=1e-11)
    assert saddle.t[0] == pytest.approx(0.949416416, abs=2e-9)
    after = next_impacts(Oscillator(0.3, 0.05, 0.3), saddle.t, saddle.v)
    assert (after.t[0], after.v[0]) == pytest.approx((saddle.t[0], saddle.v[0]), abs=1e-9)
    assert saddles[0].grazing_distance < 2e-3


def test_bands_of_a_search_share_the_phases_next_to_the_grazing_curve():
    oscillator, region = Oscillator(), (0.2, 0.8, 0.0, 1e-6)
    parts = [orbit_seeds(oscillator, region, 6, rows, 1, never_stopped) for rows in ((0, 2), (2, 6))]
    whole = orbit_seeds(oscillator, region, 6, (0, 6), 1, never_stopped)
    fast = [np.sort(seeds[0][seeds[1] > 1.0]) for seeds in (*parts, whole)]
    np.testing.assert_array_equal(np.sort(np.concatenate(fast[:2])), fast[2])
    t, v = whole.t[whole.kind == 3], whole.v[whole.kind == 3]
    above = v > grazing_velocity(oscillator, t)
    assert 0 < above.sum() < above.size
    band = 0.3 * grazing_velocity(oscillator, t)
    assert (np.abs(v - grazing_velocity(oscillator, t)) < band).mean() > 0.5


def test_bands_of_a_search_share_the_finer_grid():
    oscillator, region = Oscillator(), (0.0, 1.0, 0.0, 7.0)
    parts = [orbit_seeds(oscillator, region, 6, rows, 2, never_stopped) for rows in ((0, 2), (2, 6))]
    whole = orbit_seeds(oscillator, region, 6, (0, 6), 2, never_stopped)
    points = [sorted(zip(s.t[s.kind == 4], s.v[s.kind == 4], s.period[s.kind == 4], strict=True))
              for s in (*parts, whole)]  # fmt: skip
    assert sorted(points[0] + points[1]) == points[2] and points[2]


INDEX_SETS = [(0.3, 0.05, 0.3), (0.28, 0.0286, 0.252), (0.6, 0.1, 0.6), (0.45, 0.08, 0.9), (0.15, 0.02, 0.4)]


@pytest.mark.parametrize("parameters", INDEX_SETS)
def test_the_indices_of_the_orbits_of_each_forcing_period_add_up_to_nothing(parameters):
    """No orbit of impact period 1 is missed, or an even number of them.

    P(m, 1, .) are the zeros of (T - m, v' - v) on the cylinder of departures. At v near 0 the first component is
    negative, and faster than the speed of no return the second one is. So the field does not turn along either circle,
    and the indices of its zeros, the signs of det(DP - 1), add up to 0 for each m.
    """
    oscillator = Oscillator(*parameters)
    found = find_orbits(oscillator, 1, velocity=(0.0, speed_of_no_return(oscillator)), cells=24)
    total = Counter()
    for one in found:
        total[one.orbit.forcing_periods] += int(np.sign(np.linalg.det(one.orbit.jacobians[0] - np.eye(2))))
    assert len(found) >= 2 and set(total.values()) == {0}, total

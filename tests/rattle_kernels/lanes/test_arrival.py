"""Lanes that look after every impact see what the map does impact by impact; their tables' guesses are good enough."""

import numpy as np
import pytest

from rattle_kernels import Oscillator, find_attractors, name_solutions, next_impacts
from rattle_kernels.lanes.arrival import BOXES, boxes_passed
from rattle_kernels.lanes.batch import Rules
from rattle_kernels.lanes.run import run_lanes
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.lanes.traps import NO_TRAPS

RATTLING = Oscillator(damping=0.6, eccentricity=0.1, half_backlash=0.6)
SEEDS = [0.89829, 0.553], [3.76991, 4.703]  # end on P(1,1,0) and in chaos


def test_the_boxes_passed_are_those_of_the_map_impact_by_impact():
    rng = np.random.default_rng(5)
    t, v = next_impacts(RATTLING, *SEEDS, applications=300)[:2]
    t, v = np.concatenate([t, t + 1e-3 * rng.random(2)]) % 1.0, np.concatenate([v, v])
    tables, legs, images = lane_tables(RATTLING), 3, 40
    visits, box = np.empty((legs, 2, t.size)), np.empty(legs * t.size * images + 1, np.int64)
    # A leg goes one application further than it notes boxes: the next one begins there.
    rules, returned = Rules(float(images), 0.0, -1.0), np.zeros(t.size, np.bool_)
    ends = t.copy(), v.copy()
    boxes_passed(RATTLING, tables, rules, NO_TRAPS, *ends, returned, np.arange(t.size), visits, box)
    assert returned.all()
    for leg, noted in enumerate(box[:-1].reshape(legs, t.size, images)):
        np.testing.assert_array_equal(visits[leg], [t, v])
        for at in range(images):
            expected = (v / tables.largest_grazing_speed * BOXES).astype(np.int64) * BOXES + (t * BOXES).astype(
                np.int64
            )
            np.testing.assert_array_equal(noted[:, at], expected)
            t, v = next_impacts(RATTLING, t, v)[:2]
    np.testing.assert_array_equal(ends, [t, v])


def test_a_point_ends_where_it_ends_whoever_is_followed_beside_it():
    attractors = find_attractors(RATTLING, *SEEDS)
    rng = np.random.default_rng(6)
    t, v = rng.random(300), 1e-3 + 7.0 * rng.random(300)
    together = name_solutions(RATTLING, attractors, t, v)
    assert set(together.tolist()) == {0, 1, 2}
    alone = [int(name_solutions(RATTLING, attractors, t[i : i + 1], v[i : i + 1])[0]) for i in range(0, 300, 7)]
    assert together[::7].tolist() == alone


@pytest.mark.parametrize(("damping", "careful"), [(0.6, 2e-4), (0.5, 2e-3), (0.7, 2e-4)])
def test_few_guesses_of_interpolated_tables_lead_to_the_careful_path(damping, careful):
    rng = np.random.default_rng(7)
    t, v = rng.random(5000), 7.0 * rng.random(5000)
    _, run = run_lanes(RATTLING._replace(damping=damping), t, v, 50, shortcuts=False)
    # One in 5,000 by docs/decisions/0004-lanes.md, ten times that at 0.5: another processor's chaos, another count of
    # some hundred at the most, which chance changes by five times ten.
    assert run.applications > 200_000 and run.careful_flights < careful * run.applications

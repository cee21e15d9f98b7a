"""What a lattice says of a strip is true of every departure in it."""

import numpy as np

from rattle_proof.enclosures.interval import Interval
from rattle_proof.enclosures.lattice import UNPROVEN, Lattice, Strip, common_ends, end_of, find_end, refined

_STRIPS, _POINTS = 300, 40


def _lattice(random):
    """Bands of ends, with holes: rows from 5 on, 1/64 high, and 32 columns."""
    ends = np.repeat(np.array([1, 1, 1, 2, 2, 1], np.uint16), 8)[:, None].repeat(32, 1)
    ends[random.random(ends.shape) < 0.01] = UNPROVEN
    return Lattice(1.0 / 64.0, 5, ends)


def _strips(random):
    for _ in range(_STRIPS):
        t, v = sorted(random.uniform(-1.0, 2.0) + random.uniform(0.0, 0.4, 2)), sorted(random.uniform(0.0, 0.9, 2))
        slope = float(np.float32(random.choice([0.0, random.normal()])))
        offset = random.uniform(*v) - slope * random.uniform(*t)
        yield Strip(Interval(*t), Interval(*v), slope, Interval(offset, offset + 10.0 ** random.uniform(-4.0, -1.0)))


def _departures(strip, random):
    t = np.append(random.uniform(*strip.t, _POINTS), strip.t)
    v = (
        strip.slope * t
        + random.choice([0.0, 0.5, 1.0], t.size) * (strip.offset.high - strip.offset.low)
        + strip.offset.low
    )
    inside = (v >= strip.v.low) & (v <= strip.v.high)
    return t[inside], v[inside]


def test_all_departures_of_a_strip_have_its_end():
    random, known = np.random.default_rng(8), 0
    lattice = _lattice(random)
    for strip in _strips(random):
        end = end_of(lattice, strip)
        t, v = _departures(strip, random)
        if end == UNPROVEN or not t.size:
            continue
        known += 1
        rows = np.floor(v / lattice.height).astype(int) - lattice.first
        assert (lattice.ends[rows, np.floor(t * 32).astype(int) % 32] == end).all()
    assert known > _STRIPS / 10


def test_a_missing_box_is_one_without_a_proof():
    random, missing = np.random.default_rng(9), 0
    lattice = _lattice(random)
    for strip in _strips(random):
        found = find_end(lattice, strip)
        if found.end == UNPROVEN and found.row >= 0:
            missing += 1
            assert lattice.ends[found.row, found.column] == UNPROVEN
    assert missing > 0


def test_a_strip_that_leaves_the_lattice_has_no_end():
    lattice = Lattice(1.0 / 64.0, 5, np.ones((8, 32), np.uint16))
    for low, high in ((0.0, 0.1), (0.1, 0.3), (np.nan, np.nan)):
        strip = Strip(Interval(0.2, 0.3), Interval(low, high), 0.0, Interval(low, high))
        assert end_of(lattice, strip) == UNPROVEN


def test_a_refined_lattice_says_the_same():
    random = np.random.default_rng(10)
    lattice = _lattice(random)
    finer = refined(lattice)
    for strip in _strips(random):
        if end_of(lattice, strip) != UNPROVEN:
            assert end_of(finer, strip) == end_of(lattice, strip)


def test_common_ends_are_those_of_all_parts():
    random = np.random.default_rng(10)
    parts = [random.integers(0, 3, (4, 5)).astype(np.uint16) for _ in range(3)]
    common = common_ends(np.concatenate(parts), 3)
    for place, end in np.ndenumerate(common):
        seen = {int(part[place]) for part in parts}
        assert end == (seen.pop() if len(seen) == 1 else UNPROVEN)
    np.testing.assert_array_equal(common_ends(parts[0], 1), parts[0])

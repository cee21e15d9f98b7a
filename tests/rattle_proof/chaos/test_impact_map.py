"""What is proven of the chaos of Fig. 7 (bottom): held against flights by Arb and against motions by numbers."""

import contextlib
import itertools

import numpy as np
import pytest
from flint import arb

from rattle_kernels import find_attractors, find_orbits, next_impacts
from rattle_kernels.numerics.pausing import never_stopped
from rattle_proof.chaos.crossings import crossings, following
from rattle_proof.chaos.cycles import repelling_cycles
from rattle_proof.chaos.entropy import growth_of
from rattle_proof.chaos.leaf_search import leaves_across, numbers_of
from rattle_proof.chaos.leaves import NotSeparated, places_of
from rattle_proof.chaos.proof import chaos_of
from rattle_proof.enclosures.lattice import empty_lattice
from rattle_proof.enclosures.machine import machine_of
from rattle_proof.enclosures.rattling_set import Search, closed_set
from tests.rattle_proof.enclosures.exact_flights import ExactMap
from tests.rattle_proof.enclosures.machines import OSCILLATORS

FIG_7 = OSCILLATORS[0]
# Growth of the length of a curve of 8,000,001 departures, over twelve impacts.
OF_LENGTH = 0.61


@pytest.fixture(scope="module")
def attractor():
    found = find_attractors(FIG_7, [0.553], [4.703])
    return next(each for each in found if each.is_chaotic)


@pytest.fixture(scope="module")
def lattice(attractor):
    return closed_set(Search(machine_of(FIG_7), FIG_7, 0.0, 8192, fewest=2048), attractor.time, attractor.velocity, 1)


@pytest.fixture(scope="module")
def shown(lattice):
    """Leaves in some windows, with what their strips cross and how words grow, by growth."""
    follow = following(machine_of(FIG_7), FIG_7)
    found = []
    for leaves in itertools.islice(leaves_across(lattice, numbers_of(FIG_7, 2.3), 60), 6):
        with contextlib.suppress(NotSeparated):
            crossed = crossings(leaves, lattice, places_of(leaves, lattice), follow, 7)
            growth = growth_of(crossed)
            found.append((0.0 if growth is None else growth.entropy, leaves, crossed))
    return sorted(found, key=lambda each: each[0])


def _exact(exact, t, v):
    landed = exact.image(t, v)
    return landed.t, landed.v


def test_images_of_leaves_are_held(shown):
    """Of departures anywhere in a leaf, its edges and ends too."""
    _, leaves, _ = shown[-1]
    exact, random = ExactMap(FIG_7), np.random.default_rng(0)
    follow = following(machine_of(FIG_7), FIG_7)
    i, j = random.integers(0, len(leaves.times), 60), random.integers(0, leaves.times.shape[1] - 1, 60)
    low = (leaves.first + j) * leaves.height
    pieces = np.stack([leaves.times[i, j], leaves.times[i, j + 1], low, low + leaves.height], axis=1)
    # Much wider leaves, too: there slopes and hulls matter.
    for half_width in (leaves.half_width, 1e-4):
        hulls = follow(pieces, half_width, 3)
        known = np.isfinite(hulls).all(axis=(1, 2))
        assert known.mean() > 0.8
        for k in np.flatnonzero(known):
            along, across = (
                random.choice([0.0, 1.0, random.random()]),
                random.choice([-1.0, 1.0, random.uniform(-1, 1)]),
            )
            below, above, bottom, top = map(arb, pieces[k])
            t, v = below + (above - below) * along + arb(half_width) * across, bottom + (top - bottom) * along
            for n in range(3):
                t, v = _exact(exact, t, v)
                early, late, slow, fast = map(arb, hulls[k, n])
                turns = (t - early).floor()
                assert early <= t - turns <= late and slow <= v <= fast, (k, n)


def test_images_of_a_strip_cross_what_they_are_said_to(lattice, shown):
    """A path by numbers, from leaf to leaf: its images have points in each strip crossed."""
    _, leaves, found = shown[-1]
    nodes = (leaves.first + np.arange(leaves.times.shape[1])) * leaves.height
    strips = np.argwhere(found.last > found.first)
    assert len(strips) > 5
    for i, n in strips[:: max(len(strips) // 40, 1)].tolist():
        # From a departure of the set on one leaf to one on the other.
        ends = [_held_on(leaves, lattice, leaf) for leaf in (i, i + 1)]
        part = np.linspace(0.0, 1.0, 20001)
        t, v = (ends[0][k] + part * (ends[1][k] - ends[0][k]) for k in (0, 1))
        for _ in range(n + 1):
            landed = next_impacts(FIG_7, t, v)
            t, v = landed.t, landed.v
        within = (v > nodes[0]) & (v < nodes[-1])
        behind = np.array([np.interp(v, nodes, times) < t for times in leaves.times]).sum(axis=0)
        # From one point to the next it passes all leaves between.
        steps = np.stack([behind[:-1], behind[1:]])[:, within[:-1] & within[1:]]
        crossed = {leaf for low, high in np.sort(steps, axis=0).T.tolist() for leaf in range(low, high + 1)}
        assert set(range(found.first[i, n] + 1, found.last[i, n] + 1)) <= crossed, (i, n)


def _held_on(leaves, lattice, leaf):
    """A departure of the set on a leaf."""
    for j in range(leaves.times.shape[1]):
        t, v = leaves.times[leaf, j], (leaves.first + j) * leaves.height
        if lattice.ends[int(v / lattice.height) - lattice.first, int(t * lattice.ends.shape[1])]:
            return t, v
    raise AssertionError("a leaf crosses the set")


def test_the_entropy_is_positive_and_not_more_than_curves_grow(shown):
    assert 0.3 < shown[-1][0] < OF_LENGTH


def test_within_tolerances_it_is_smaller(attractor):
    """0.01 % of damping."""
    machine = machine_of(FIG_7, {"damping": (0.59997, 0.60003)})
    one = chaos_of(machine_of(FIG_7), attractor, 1024, 60, 0, never_stopped)
    all_ = chaos_of(machine, attractor, 1024, 60, 0, never_stopped)
    assert np.count_nonzero(all_.lattice.ends) >= np.count_nonzero(one.lattice.ends)
    assert all_.growth is not None and 0.0 < all_.growth.entropy <= one.growth.entropy


def _around(t, v, boxes):
    """Boxes of a fine lattice about a departure."""
    columns, height = 4096, 2.0**-9
    lattice = empty_lattice(0.5, 8.0, columns, height)
    row, column = int(v / height) - lattice.first, int(t % 1.0 * columns)
    lattice.ends[row - boxes : row + boxes + 1, np.arange(column - boxes, column + boxes + 1) % columns] = 1
    return lattice


@pytest.mark.parametrize("longest", [1, 2, 3])
def test_cycles_that_attract_are_not_said_to_repel(longest):
    machine = machine_of(FIG_7)
    # P(1,1,0) of Fig. 7 attracts. Depths are small: where it attracts no depth decides.
    cycles = repelling_cycles(machine, FIG_7, _around(0.89829, 3.76991, 2), longest, depth=12)
    assert cycles.repel == 0 and (cycles.open_parts > 0).all(), "it comes back after two and three impacts as well"


def test_saddles_repel_and_nothing_else_comes_back():
    orbits = find_orbits(FIG_7, 3, velocity=(3.5, 5.5), cells=24)
    saddles = [
        each.orbit for each in orbits if abs(each.orbit.multipliers).max() > 1.2 and each.grazing_distance > 0.02
    ]
    assert len(saddles) > 3
    for orbit in saddles:
        place = float(orbit.t[0]), float(orbit.v[0])
        cycles = repelling_cycles(machine_of(FIG_7), FIG_7, _around(*place, 1), orbit.upper_contacts)
        assert cycles.repel == orbit.upper_contacts, orbit.name


def test_short_cycles_of_the_chaotic_set_repel(lattice):
    cycles = repelling_cycles(machine_of(FIG_7), FIG_7, lattice, 2)
    assert cycles.repel == 2 and not cycles.open_parts.any()

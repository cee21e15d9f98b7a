"""The code that bounds the entropy of P from below bounds that of Henon's map, which others have."""

import itertools

import numpy as np
import pytest

from rattle_proof.chaos.crossings import crossings
from rattle_proof.chaos.entropy import growth_of
from rattle_proof.chaos.leaf_search import leaves_across
from rattle_proof.chaos.leaves import places_of
from tests.rattle_proof.chaos import henon


@pytest.fixture(scope="module")
def lattice():
    return henon.closed_boxes(512)


@pytest.fixture(scope="module")
def leaves(lattice):
    return next(leaves_across(lattice, henon.NUMBERS, 400))


def test_the_entropy_lies_between_bounds_that_others_have_proven_and_what_is_known_of_it(lattice, leaves):
    """At least 0.4320 (Day, Frongillo, Trevino 2008). It is 0.46508 by numbers (D'Alessandro and others 1990)."""
    places = places_of(leaves, lattice)
    growth = growth_of(crossings(leaves, lattice, places, henon.follow, 9))
    assert 0.4320 < growth.entropy < 0.46508


def test_images_of_leaves_lie_where_they_are_said_to(leaves):
    random = np.random.default_rng(0)
    i, j = random.integers(0, len(leaves.times), 500), random.integers(0, leaves.times.shape[1] - 1, 500)
    low = (leaves.first + j) * leaves.height
    pieces = np.stack([leaves.times[i, j], leaves.times[i, j + 1], low, low + leaves.height], axis=1)
    hulls = henon.follow(pieces, leaves.half_width, 6)
    for part in np.linspace(0.0, 1.0, 5):
        t, v = (1.0 - part) * pieces[:, 0] + part * pieces[:, 1], low + part * leaves.height
        for n in range(6):
            t, v = henon.image(t, v)
            kept = np.abs(t) < 10.0
            # A number of this size is off by some 1e-16 of it after each step, times what a step may stretch it by.
            slack = 1e-12
            assert (hulls[kept, n, 0] - slack <= t[kept]).all() and (t[kept] <= hulls[kept, n, 1] + slack).all()
            assert (hulls[kept, n, 2] - slack <= v[kept]).all() and (v[kept] <= hulls[kept, n, 3] + slack).all()


def test_more_leaves_show_no_more_than_there_is(lattice):
    for found in itertools.islice(leaves_across(lattice, henon.NUMBERS, 100), 3):
        growth = growth_of(crossings(found, lattice, places_of(found, lattice), henon.follow, 9))
        assert growth is not None and growth.entropy < 0.46508

"""A certificate that is about another store, other machines or other counts is found, without proving anything."""

from types import SimpleNamespace

import numpy as np
import pytest

from rattle_kernels import Oscillator
from rattle_kernels.attractors.attractor import Attractor, AttractorKind
from rattle_proof.verification.claims import claims_of
from rattle_proof.verification.same_store import same_store
from rattle_proof.verification.targets.discs import try_disc

QUIET = Attractor(AttractorKind.PERMANENT_CONTACT, 0, 0, 0, np.nan, np.nan, np.empty(0), np.empty(0))
PERIODIC = Attractor(AttractorKind.PERIODIC, 1, 1, 0, -0.3, 0.0, np.array([0.9]), np.array([3.77]))
CHAOS = Attractor(AttractorKind.CHAOTIC, 0, 0, 0, 0.3, 0.0, np.array([0.3]), np.array([4.4]))
SOLUTION = np.array([[0, 1], [2, 0]], np.int16)
PROVEN = np.array([[64, 32], [64, 0]], np.uint8)
NEVER_QUIET = np.array([[0, 48], [64, 16]], np.uint8)
TOLERANCES = {"damping": (0.59, 0.61), "eccentricity": (0.09, 0.1)}


def certificate():
    return {
        "machine": {
            "damping": [0.59, 0.61],
            "half_backlash": [0.6, 0.6],
            "restitution": [1.0, 1.0],
            "harmonics": [[1.0, 0.09, 0.1, 0.0, 0.0]],
        },
        "parts": [],
        "motions": ["permanent contact", "P(1,1,0)", "chaotic"],
        "quiet": {"motion": 0, "level": 0.09},
        "discs": [{"motion": 1, "impacts": 1, "t": 0.9, "v": 3.77, "frame": [[1.0, 0.0], [0.0, 0.2]], "radius": 0.01}],
        "rattling": {"motion": 2, "height": 1.0, "first": 4, "columns": 4},
        "lattice": {"height": 1.0, "first": 0, "columns": 2, "rows": 2},
        "counts": {"cells": 4, "whole": 2, "boxes": 4, "proven_boxes": 3, "rounds": 5},
        "shares": [0.25, 0.125, 0.25],
        "never_quiet": 0.5,
    }


def subject(certificate, tolerances=TOLERANCES, attractors=(QUIET, PERIODIC, CHAOS), never_quiet=NEVER_QUIET):
    arrays = {
        "ends": np.array([[1, 1], [2, 0]], np.uint16),
        "rounds": np.array([[0, 1], [5, 0]], np.uint16),
        "rattling": np.array([[0, 1, 0, 0]], np.uint8),
    }
    job = SimpleNamespace(oscillator=Oscillator(0.6, 0.1, 0.6), prove=SimpleNamespace(tolerances=tolerances))
    proof = SimpleNamespace(
        job=job,
        attractors=attractors,
        certificate=certificate,
        arrays=arrays,
        solution=SOLUTION,
        proven=PROVEN,
        never_quiet=never_quiet,
    )
    return SimpleNamespace(proof=proof, claims=claims_of(certificate, arrays))


def places(subject):
    return [failure.place for failure in same_store(subject).failures]


def test_a_certificate_of_the_store_is_right():
    part = same_store(subject(certificate()))
    assert part.holds and part.tried == part.of == 5


@pytest.mark.parametrize(
    "tolerances",
    [
        {"damping": (0.589, 0.61)},
        {"damping": (0.59, 0.61), "eccentricity": (0.09, 0.11)},
        {"half_backlash": (0.5, 0.6)},
    ],
)
def test_a_store_that_was_asked_for_more_machines_is_found(tolerances):
    assert places(subject(certificate(), tolerances)) == ["machine"]


@pytest.mark.parametrize("count", ["cells", "whole", "boxes", "proven_boxes", "rounds"])
def test_a_count_that_is_not_that_of_the_store_is_found(count):
    told = certificate()
    told["counts"][count] += 1
    assert places(subject(told)) == ["counts"]


def test_shares_that_are_not_those_of_the_cells_are_found():
    assert places(subject(certificate() | {"shares": [0.25, 0.125, 0.26]})) == ["shares"]
    assert places(subject(certificate() | {"shares": [0.25, 0.125]})) == ["shares"]


def test_a_rattling_set_that_holds_another_motion_is_found():
    inside = PERIODIC._replace(time=np.array([0.9, 1.3]), velocity=np.array([3.77, 4.5]))
    assert places(subject(certificate(), attractors=(QUIET, inside, CHAOS))) == ["motions"]


def test_a_disc_around_no_departure_of_its_motion_is_found():
    moved = PERIODIC._replace(time=np.array([0.8]))
    (place,) = places(subject(certificate(), attractors=(QUIET, moved, CHAOS)))
    assert place.startswith("disc around t = 0.9")


def test_a_disc_as_wide_as_a_period_is_refused():
    """It would meet itself, so that its image need not lie in one of its copies."""
    told = certificate()
    told["discs"][0]["radius"] = 0.5
    failure = try_disc(subject(told).claims, 0)
    assert failure.contradicted and "as wide as a period" in failure.why


@pytest.mark.parametrize(("within", "found"), [(16, []), (15, ["counts"])])
def test_motions_that_are_said_to_be_quiet_too_soon_are_found(within, found):
    """A box that falls quiet has round 1: four impacts after the twelve of a cell."""
    told = certificate() | {"impacts": {"cell": 12, "trail": 4}}
    told["quiet"]["within"] = within
    assert places(subject(told)) == found


def test_a_share_that_never_falls_quiet_and_is_not_that_of_the_cells_is_found():
    told = certificate()
    told["never_quiet"] = 0.6
    assert places(subject(told)) == ["counts"]


@pytest.mark.parametrize(
    ("cell", "claimed", "instead"),
    [((0, 0), 1, (0, 1)), ((0, 1), 31, (1, 1)), ((1, 0), 63, (1, 1))],
    ids=["a part of a cell that falls quiet", "less than ends in an orbit", "less than is chaotic"],
)
def test_a_cell_that_is_said_to_rattle_and_to_fall_quiet_is_found(cell, claimed, instead):
    """The sum of all cells is as before."""
    claims = NEVER_QUIET.copy()
    claims[instead] += claims[cell]
    claims[cell] = claimed
    claims[instead] -= claimed
    found = subject(certificate(), never_quiet=claims)
    assert claims.sum() == NEVER_QUIET.sum()
    assert places(found) == [f"cell {cell}"]


def test_a_store_of_the_first_edition_claims_of_nothing_that_it_never_falls_quiet():
    told = certificate()
    del told["never_quiet"]
    assert places(subject(told, never_quiet=np.zeros_like(NEVER_QUIET))) == []
    assert places(subject(told)) == ["counts"]

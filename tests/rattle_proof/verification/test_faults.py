"""A store's proof is proven again; each deliberate fault in what it claims is found."""

import shutil

import numpy as np
import pytest

import rattle
from rattle_proof.verification.ends import Ends
from rattle_proof.verification.samples import (
    try_box,
    try_box_of_window,
    try_box_that_rattles,
    try_cell,
    try_cell_that_rattles,
)
from rattle_proof.verification.targets.discs import try_disc
from rattle_proof.verification.targets.quiet import COLUMNS, try_column
from rattle_proof.verification.work import subject_at
from worker.stores.new_store import consolidate
from worker.stores.opening import open_group

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]
_TRAIL = 4


@pytest.fixture(scope="module")
def location(tmp_path_factory):
    path = tmp_path_factory.mktemp("verified") / "basin.zarr"
    # Losing energy, there is no set that rattles for ever: the store is small.
    rattle.basin(restitution=0.9, cells=(20, 20), prove=True, levels=0, store=path, progress=False)
    return str(path)


@pytest.fixture(scope="module")
def subject(location):
    return subject_at(location)


def test_a_good_store_is_proven_again(location):
    found = rattle.verify(location, cells=100, boxes=200)
    assert found.holds, [part.failures for part in found.parts]
    tried = {part.name: part.tried for part in found.parts}
    assert (tried["boxes of the lattice"], tried["cells"]) == (200, 100)


def test_a_level_that_is_raised_is_found(subject):
    core, machine = subject.claims.core, subject.claims.machine
    raised = core._replace(level=1.5 * core.level)
    assert any(try_column(machine, raised, column) is not None for column in range(COLUMNS))


def test_a_disc_that_is_inflated_is_found(subject):
    (disc,) = subject.claims.discs
    assert try_disc(subject.claims, 0) is None
    inflated = subject.claims._replace(discs=(disc._replace(radius=8.0 * disc.radius),))
    assert try_disc(inflated, 0) is not None


def test_a_box_with_another_end_is_found(subject):
    lattice = subject.claims.lattice
    places = np.argwhere(lattice.ends == 1)[:: max(1, int((lattice.ends == 1).sum()) // 20)]
    flipped = np.where(lattice.ends == 1, 2, lattice.ends)
    # Each alone is wrong, among others that are right.
    for row, column in places.tolist():
        ends = lattice.ends.copy()
        ends[row, column] = flipped[row, column]
        faulty = Ends(subject.claims._replace(lattice=lattice._replace(ends=ends)))
        assert try_box(subject.ends, _TRAIL, row, column) is None
        failure = try_box(faulty, _TRAIL, row, column)
        assert failure is not None and failure.contradicted, (row, column)


def test_a_cell_with_another_solution_is_found(subject):
    plane = subject.plane
    flipped = plane._replace(solution=1 - plane.solution)
    for row, column in np.argwhere(plane.proven == 64)[::20].tolist():
        assert try_cell(subject.ends, plane, row, column) is None
        failure = try_cell(subject.ends, flipped, row, column)
        assert failure is not None and failure.contradicted, (row, column)


@pytest.fixture(scope="module")
def in_parts(tmp_path_factory):
    path = tmp_path_factory.mktemp("verified") / "parts.zarr"
    asked = {"cells": (20, 20), "levels": 0, "tolerances": {"damping": (0.598, 0.602)}}
    rattle.basin(restitution=0.9, prove=True, store=path, progress=False, **asked)
    return path


def test_a_store_with_tolerances_in_parts_is_proven_again(in_parts):
    found = rattle.verify(in_parts, cells=100, boxes=200)
    assert found.holds, [part.failures for part in found.parts]
    tried = {part.name: part.tried for part in found.parts}
    assert (tried["boxes of the lattice"], tried["cells"]) == (200, 100)


def test_machines_of_no_part_are_found(in_parts, tmp_path):
    """The rest holds for what is left: the second half, of which there are lattices twice."""
    shutil.copytree(in_parts, tmp_path / "short.zarr")
    group = open_group(str(tmp_path / "short.zarr"), "r+")["proof"]
    certificate = dict(group.attrs["certificate"])
    first, second, *others = certificate["parts"]
    group.attrs["certificate"] = certificate | {"parts": [second, second, *others]}
    consolidate(str(tmp_path / "short.zarr"))
    found = rattle.verify(tmp_path / "short.zarr", cells=0, boxes=0)
    failed = [part for part in found.parts if not part.holds]
    assert [failure.place for part in failed for failure in part.failures] == ["parts"]


def test_a_box_of_one_part_with_another_end_is_found(in_parts):
    subject = subject_at(str(in_parts))
    for ends in subject.ends_of_parts:
        lattice = ends.claims.lattice
        row, column = np.argwhere(lattice.ends == 1)[(lattice.ends == 1).sum() // 2].tolist()
        other = lattice.ends.copy()
        other[row, column] = 2
        faulty = Ends(ends.claims._replace(lattice=lattice._replace(ends=other)))
        assert try_box(ends, _TRAIL, row, column) is None
        failure = try_box(faulty, _TRAIL, row, column)
        assert failure is not None and failure.contradicted, (row, column)


@pytest.fixture(scope="module")
def wandering(tmp_path_factory):
    """A store whose motions pass long transients before they come to an orbit, and are known not to fall quiet."""
    path = tmp_path_factory.mktemp("verified") / "wandering.zarr"
    rattle.basin(eccentricity=0.089, cells=(128, 128), prove=True, levels=0, store=path, progress=False)
    return str(path)


def test_what_never_falls_quiet_is_proven_again(wandering):
    found = rattle.verify(wandering, cells=100, boxes=200)
    assert found.holds, [part.failures for part in found.parts]
    windows, boxes, rattling_boxes, rattling_cells, cells = found.parts[-5:]
    assert (windows.name, windows.tried, boxes.tried, cells.tried) == ("boxes of windows", 200, 200, 100)
    assert (rattling_boxes.name, rattling_boxes.tried) == ("boxes that never fall quiet", 200)
    assert rattling_cells.name == "cells that never fall quiet" and rattling_cells.tried == min(100, rattling_cells.of)


def test_a_box_of_a_window_with_another_end_is_found(wandering):
    """Each alone is wrong, among others that are right."""
    subject = subject_at(wandering)
    windows, impacts = subject.claims.windows, int(subject.proof.certificate["impacts"]["window"])
    for n in range(0, len(windows), max(1, len(windows) // 10)):
        proven = np.argwhere(windows[n].ends)
        row, column = proven[len(proven) // 2].tolist()
        assert try_box_of_window(subject.ends, impacts, n, row, column) is None
        ends = windows[n].ends.copy()
        ends[row, column] += 1
        faulty = (*windows[:n], windows[n]._replace(ends=ends), *windows[n + 1 :])
        failure = try_box_of_window(Ends(subject.claims._replace(windows=faulty)), impacts, n, row, column)
        assert failure is not None and failure.contradicted, (n, row, column)


def test_a_box_of_a_window_that_rests_on_later_ones_is_found(wandering):
    """Were it the first of all, there would be the discs alone; the last proven are furthest from these."""
    subject = subject_at(wandering)
    windows, impacts = subject.claims.windows, int(subject.proof.certificate["impacts"]["window"])
    n = len(windows) - 1
    for row, column in np.argwhere(windows[n].rounds == windows[n].rounds.max()).tolist():
        assert try_box_of_window(subject.ends, impacts, n, row, column) is None
        order = windows[n].rounds.copy()
        order[row, column] = 1
        faulty = subject.claims._replace(windows=(*windows[:n], windows[n]._replace(rounds=order)))
        assert try_box_of_window(Ends(faulty), impacts, n, row, column) is not None


def test_a_box_that_falls_quiet_among_those_that_never_do_is_found(wandering):
    """Each alone is wrong, among others that are right; and what lies at rest is no matter of where it comes."""
    subject = subject_at(wandering)
    claims, lattice = subject.claims, subject.claims.never_quiet
    right = np.argwhere((lattice.ends == 1) & (claims.lattice.ends == 0))
    wrong = np.argwhere((claims.lattice.ends == 1) & (claims.lattice.rounds > 0))
    for row, column in right[:: len(right) // 10].tolist():
        assert try_box_that_rattles(subject.ends, _TRAIL, row, column) is None
    for row, column in wrong[:: len(wrong) // 10].tolist():
        ends, others = lattice.ends.copy(), claims.lattice.ends.copy()
        ends[row, column], others[row, column] = 1, 0
        faulty = claims._replace(never_quiet=lattice._replace(ends=ends), lattice=claims.lattice._replace(ends=others))
        failure = try_box_that_rattles(Ends(faulty), _TRAIL, row, column)
        assert failure is not None and failure.contradicted, (row, column)
    failure = try_box_that_rattles(subject.ends, _TRAIL, 0, 5)
    assert failure is not None and failure.contradicted


def test_a_box_that_comes_back_nowhere_is_found(wandering):
    """One of the set, if no other belongs to it: to be in the set itself is not to come back to it."""
    subject = subject_at(wandering)
    lattice = subject.claims.never_quiet
    rattling = np.argwhere((lattice.ends == 1) & (subject.claims.lattice.ends == 0))
    for row, column in rattling[:: len(rattling) // 5].tolist():
        alone = np.zeros_like(lattice.ends)
        alone[row, column] = 1
        nowhere = subject.claims.lattice._replace(ends=np.zeros_like(lattice.ends))
        claims = subject.claims._replace(never_quiet=lattice._replace(ends=alone), lattice=nowhere)
        faulty = Ends(claims._replace(discs=(), windows=(), rattling=None))
        assert try_box_that_rattles(faulty, _TRAIL, row, column) is not None, (row, column)


def test_a_cell_that_is_said_never_to_fall_quiet_is_found(wandering):
    subject = subject_at(wandering)
    plane = subject.plane
    quiet = np.argwhere((plane.solution == subject.claims.core.motion) & (plane.proven == 64))
    for claimed in (64, 1):
        faulty = plane._replace(never_quiet=np.full_like(plane.never_quiet, claimed))
        for row, column in quiet[:: len(quiet) // 5].tolist():
            failure = try_cell_that_rattles(subject.ends, faulty, row, column)
            assert failure is not None and failure.contradicted, (row, column)


def test_a_set_with_boxes_at_rest_is_found_whatever_the_sample_is(wandering, tmp_path):
    shutil.copytree(wandering, tmp_path / "rest.zarr")
    group = open_group(str(tmp_path / "rest.zarr"), "r+")["proof"]
    ends, rattling = group["ends"][...], group["never_quiet"][...]
    ends[0, 7], rattling[0, 7] = 0, 1
    group["ends"][...], group["never_quiet"][...] = ends, rattling
    found = rattle.verify(tmp_path / "rest.zarr", cells=0, boxes=0)
    (failure,) = (each for part in found.parts if part.name == "boxes that never fall quiet" for each in part.failures)
    assert failure.contradicted and failure.place.startswith("box (0, 7)")

"""A store's proof is proven again; each deliberate fault in what it claims is found."""

import shutil

import numpy as np
import pytest

import rattle
from rattle_proof.verification.ends import Ends
from rattle_proof.verification.samples import try_box, try_cell
from rattle_proof.verification.targets.discs import discs
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
    assert [part.tried for part in found.parts][-2:] == [200, 100]


def test_a_level_that_is_raised_is_found(subject):
    core, machine = subject.claims.core, subject.claims.machine
    raised = core._replace(level=1.5 * core.level)
    assert any(try_column(machine, raised, column) is not None for column in range(COLUMNS))


def test_a_disc_that_is_inflated_is_found(subject):
    (disc,) = subject.claims.discs
    assert discs(subject.claims).holds
    assert not discs(subject.claims._replace(discs=(disc._replace(radius=8.0 * disc.radius),))).holds


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
    assert [part.tried for part in found.parts][-2:] == [200, 100]


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

"""A small basin proven from end to end: lattice, growth and cells; and no departure of a proven cell ends elsewhere."""

import functools

import numpy as np
import pytest

from rattle_kernels import (
    PERMANENT_CONTACT,
    CellGrid,
    Oscillator,
    find_attractors,
    map_cells,
    map_points,
    name_solutions,
    next_impacts,
)
from rattle_proof.enclosures.cells import ENDS_ELSEWHERE, RATTLES, WHOLE, prove_cells
from rattle_proof.enclosures.growth import empty_trails, follow_boxes, grow_all
from rattle_proof.enclosures.lattice import UNPROVEN, common_ends, refined
from rattle_proof.enclosures.machine import centre_of, machine_of, parts_of
from rattle_proof.enclosures.targets import prove_targets

FIG_7 = Oscillator(0.6, 0.1, 0.6)
LOSSY = Oscillator(0.6, 0.1, 0.6, restitution=0.9)
GRID = CellGrid(time_cells=60, velocity_cells=60)
_DEPARTURES = 40_000


def _attractors(oscillator):
    random = np.random.default_rng(0)
    settled = next_impacts(oscillator, random.random(300), 7.0 * random.random(300), 1000)
    rattling = np.isfinite(settled.t)
    return find_attractors(oscillator, settled.t[rattling], settled.v[rattling])


@functools.cache
def _proven(oscillator, levels, refinements=1, columns=256):
    attractors = _attractors(oscillator)
    machine = machine_of(oscillator)
    targets = prove_targets(machine, oscillator, attractors, fastest=7.0, columns=columns).targets
    rounds = np.zeros_like(targets.lattice.ends)
    for level in range(1 + refinements):
        if level:
            targets = targets._replace(lattice=refined(targets.lattice))
            rounds = rounds.repeat(2, 0).repeat(2, 1)
        boxes = np.argwhere(targets.lattice.ends == 0).astype(np.int32)
        ends, trails = np.zeros(len(boxes), np.uint16), empty_trails(len(boxes))
        follow_boxes(machine, oscillator, targets, boxes, ends, trails)
        targets.lattice.ends[boxes[:, 0], boxes[:, 1]] = ends
        grow_all(targets.lattice.ends, rounds, boxes, trails)
    images = map_cells(oscillator, GRID, 1499, (0, 60), (0, 60))
    colours = _names(oscillator, attractors, images)
    cells = prove_cells(machine, oscillator, targets, GRID, (0, 60), (0, 60), colours, levels)
    return attractors, targets, rounds, colours, cells


def _names(oscillator, attractors, images):
    names = np.zeros(images.image_cell.shape, np.int16)
    rattling = images.image_cell != PERMANENT_CONTACT
    names[rattling] = name_solutions(
        oscillator, attractors, images.landing_time[rattling], images.landing_velocity[rattling]
    )
    return names


@pytest.mark.parametrize("oscillator", [FIG_7, LOSSY])
def test_no_departure_of_a_proven_cell_ends_elsewhere(oscillator):
    random = np.random.default_rng(1)
    attractors, _, _, colours, cells = _proven(oscillator, 1)
    whole = np.argwhere(cells.proven == WHOLE)
    i, j = whole[random.integers(0, len(whole), _DEPARTURES)].T
    t, v = (j + random.random(i.size)) / 60, 7.0 * (i + random.random(i.size)) / 60
    ended = _names(oscillator, attractors, map_points(oscillator, GRID, 1499, t, v))
    np.testing.assert_array_equal(ended, colours[i, j])


@pytest.mark.parametrize("oscillator", [FIG_7, LOSSY])
def test_no_departure_of_a_proven_box_ends_elsewhere(oscillator):
    random = np.random.default_rng(2)
    attractors, targets, rounds, _, _ = _proven(oscillator, 1)
    lattice = targets.lattice
    assert rounds.max() > 1
    for proven_in in range(int(rounds.max()) + 1):
        i, j = np.nonzero((lattice.ends != 0) & (rounds == proven_in))
        some = random.integers(0, i.size, _DEPARTURES // 10)
        t = (j[some] + random.random(some.size)) / lattice.ends.shape[1]
        v = (lattice.first + i[some] + random.random(some.size)) * lattice.height
        ended = _names(oscillator, attractors, map_points(oscillator, GRID, 1499, t, v))
        np.testing.assert_array_equal(1 + ended, lattice.ends[i[some], j[some]])


def _followed(machines, targets):
    """Lattices of several machines above each other, with what is found of their boxes."""
    ends, found = np.tile(targets.lattice.ends, (len(machines), 1)), []
    for n, machine in enumerate(machines):
        boxes = np.argwhere(targets.lattice.ends == UNPROVEN).astype(np.int32)
        own, trails = np.zeros(len(boxes), np.uint16), empty_trails(len(boxes))
        follow_boxes(machine, centre_of(machine), targets, boxes, own, trails)
        boxes[:, 0] += n * targets.lattice.ends.shape[0]
        ends[boxes[:, 0], boxes[:, 1]] = own
        found.append((boxes, trails))
    return ends, *(np.concatenate(each) for each in zip(*found, strict=True))


def test_lattices_of_parts_grow_each_by_its_own_and_hold_for_every_machine():
    random, tolerances = np.random.default_rng(3), {"damping": (0.598, 0.602)}
    attractors, whole = _attractors(LOSSY), machine_of(LOSSY, tolerances)
    targets = prove_targets(whole, LOSSY, attractors, fastest=7.0, columns=256).targets
    machines = parts_of(whole)
    assert len(machines) == 4
    ends, boxes, trails = _followed(machines, targets)
    grow_all(ends, np.zeros_like(ends), boxes, trails, parts=4)
    for n, machine in enumerate(machines):
        alone, own, its = _followed([machine], targets)
        grow_all(alone, np.zeros_like(alone), own, its)
        np.testing.assert_array_equal(np.split(ends, 4)[n], alone)
    lattice = targets.lattice._replace(ends=common_ends(ends, 4))
    i, j = np.nonzero(lattice.ends)
    assert np.count_nonzero(targets.lattice.ends) < i.size < np.count_nonzero(ends) / 4
    for damping in (0.598, 0.599, *random.uniform(*tolerances["damping"], 6), 0.602):
        some = random.integers(0, i.size, 2000)
        t = (j[some] + random.random(some.size)) / lattice.ends.shape[1]
        v = (lattice.first + i[some] + random.random(some.size)) * lattice.height
        quiet = map_points(LOSSY.at(damping=float(damping)), GRID, 1499, t, v).image_cell == PERMANENT_CONTACT
        np.testing.assert_array_equal(quiet, lattice.ends[i[some], j[some]] == 1)


def test_refinement_proves_more_and_takes_nothing_back():
    plain, refined_once = _proven(FIG_7, 0)[-1], _proven(FIG_7, 1)[-1]
    assert (refined_once.proven >= plain.proven).all()
    assert refined_once.proven.sum() > plain.proven.sum()


def test_sixty_fourths_and_reasons_agree():
    cells = _proven(FIG_7, 1)[-1]
    np.testing.assert_array_equal(cells.proven == WHOLE, cells.reason == 0)
    # Cut once, a cell is proven by quarters.
    assert not (cells.proven % (WHOLE // 4)).any()


def test_what_is_coloured_wrong_is_not_proven():
    """Colours are compared with the proof: it does not follow from them."""
    _, targets, _, colours, cells = _proven(FIG_7, 0)
    wrong = np.where(colours == 0, 1, 0).astype(np.int16)
    here = prove_cells(machine_of(FIG_7), FIG_7, targets, GRID, (0, 60), (0, 60), wrong, 0)
    assert not here.proven[cells.proven == WHOLE].any()
    assert (here.reason[cells.proven == WHOLE] == ENDS_ELSEWHERE).all()


def test_what_is_proven_to_end_in_an_orbit_or_in_chaos_never_falls_quiet():
    """And nothing else does, where no set is known beside them: parts that end so count in a cell of any colour."""
    for levels in (0, 1):
        _, targets, _, colours, cells = _proven(FIG_7, levels)
        rattles = colours + 1 != targets.quiet
        elsewhere = cells.reason == ENDS_ELSEWHERE
        np.testing.assert_array_equal(cells.never_quiet[rattles & ~elsewhere], cells.proven[rattles & ~elsewhere])
        assert not cells.never_quiet[~rattles & ~elsewhere].any()
        assert (cells.never_quiet[rattles] >= cells.proven[rattles]).all()
        assert ((cells.never_quiet + cells.proven)[~rattles] <= WHOLE).all()
        assert not (cells.never_quiet % (WHOLE // 4**levels)).any()
        assert (cells.reason != RATTLES).all()


def test_a_part_that_comes_to_a_set_that_never_falls_quiet_does_not_whatever_its_colour():
    """As if all boxes were one: what is not proven is in it, and what is proven to fall quiet falls quiet."""
    _, targets, _, colours, plain = _proven(FIG_7, 0)
    everywhere = targets._replace(never_quiet=targets.lattice._replace(ends=np.ones_like(targets.lattice.ends)))
    here = machine_of(FIG_7), FIG_7, everywhere, GRID, (0, 60), (0, 60)
    rattles, whole = colours + 1 != targets.quiet, plain.proven == WHOLE
    otherwise = plain.reason == ENDS_ELSEWHERE
    assert (~whole & ~otherwise & rattles).any() and (~whole & ~otherwise & ~rattles).any()
    for levels in (0, 1):
        cells = prove_cells(*here, colours, levels)
        np.testing.assert_array_equal(cells.proven, _proven(FIG_7, levels)[-1].proven)
        assert (cells.never_quiet[whole] == np.where(rattles[whole], WHOLE, 0)).all()
        # Where a cell is known not to fall quiet, all of its parts are.
        assert (cells.never_quiet[~whole & ~otherwise] == WHOLE).all()
    cells = prove_cells(*here, colours, 0)
    expected = np.where(rattles, RATTLES, ENDS_ELSEWHERE)
    np.testing.assert_array_equal(cells.reason[~whole & ~otherwise], expected[~whole & ~otherwise])
    np.testing.assert_array_equal(cells.reason[whole | otherwise], plain.reason[whole | otherwise])


def test_levels_beyond_three_are_refused():
    _, targets, _, colours, _ = _proven(FIG_7, 0)
    with pytest.raises(ValueError, match="0 to 3"):
        prove_cells(machine_of(FIG_7), FIG_7, targets, GRID, (0, 60), (0, 60), colours, 4)

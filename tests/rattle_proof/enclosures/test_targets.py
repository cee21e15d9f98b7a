"""Targets: what is proven of them holds for exact flights, and they are as large as they can be, nearly."""

import functools
import math

import numpy as np
import pytest

from rattle_kernels import (
    PERMANENT_CONTACT,
    AttractorKind,
    CellGrid,
    Oscillator,
    find_attractors,
    grazing_velocity,
    map_points,
    next_impacts,
)
from rattle_kernels.numerics.jit import kernel_as_written
from rattle_proof.enclosures.flight import Box, Matrix
from rattle_proof.enclosures.impact import PROVEN, enclose_images
from rattle_proof.enclosures.interval import Interval, point
from rattle_proof.enclosures.machine import MOST_PARTS, centre_of, halves_of, machine_of, parts_of
from rattle_proof.enclosures.orbit_disc import _comes_nearer, disc_rows, maps_into_itself, orbit_disc, spectral_norm
from rattle_proof.enclosures.quiet_core import quiet_level
from rattle_proof.enclosures.rattling_set import Search, closed_set
from rattle_proof.enclosures.targets import _holds_no_other, prove_targets
from tests.rattle_proof.enclosures.exact_flights import ExactMap
from tests.rattle_proof.enclosures.machines import OSCILLATORS, machine_and_some, tolerances_of

FIG_7 = OSCILLATORS[0]
_DEPARTURES = 300
_FASTEST = 8.0


@functools.cache
def _certificate():
    random = np.random.default_rng(0)
    settled = next_impacts(FIG_7, random.random(300), 7.0 * random.random(300), 1000)
    rattling = np.isfinite(settled.t)
    attractors = find_attractors(FIG_7, settled.t[rattling], settled.v[rattling])
    return attractors, prove_targets(machine_of(FIG_7), FIG_7, attractors, columns=128)


def _felt(oscillator, t):
    """Acceleration at rest, of one harmonic."""
    turn = 2.0 * np.pi * t
    forcing = 2.0 * np.pi * np.cos(turn) + oscillator.damping * np.sin(turn)
    return 4.0 * np.pi * oscillator.damping - 2.0 * np.pi * oscillator.eccentricity * forcing


@pytest.mark.parametrize("part", [0.0, 0.5])
@pytest.mark.parametrize("oscillator", OSCILLATORS)
def test_the_action_falls_in_the_quiet_core(oscillator, part):
    random = np.random.default_rng(1)
    machine, some = machine_and_some(oscillator, part, random)
    level = quiet_level(machine, _FASTEST, parts=2)
    assert level > 0.0
    exact = ExactMap(some)
    for t, size in zip(random.random(_DEPARTURES), 10.0 ** random.uniform(-9.0, 0.0, _DEPARTURES), strict=True):
        v = float((level * size * exact.acceleration(t)).root(3)) * (1.0 - 1e-12)
        landed = exact.image(t, v)
        assert landed.v**3 / exact.acceleration(landed.t) < v**3 / exact.acceleration(t)


def test_the_quiet_core_is_nearly_as_large_as_it_can_be():
    """Just above the least action that grows somewhere, by a search among departures, nothing is proven."""
    _, certificate = _certificate()
    t, v = np.meshgrid(np.linspace(0.0, 1.0, 800, endpoint=False), np.linspace(0.02, 3.0, 800))
    landed = next_impacts(FIG_7, t, v)
    action = v**3 / _felt(FIG_7, t)
    grows = landed.v**3 / _felt(FIG_7, landed.t) > action
    assert 0.9 * action[grows].min() < certificate.level < action[grows].min()


def test_the_quiet_core_of_a_machine_that_always_falls_quiet_ends_above_what_was_asked():
    oscillator = Oscillator(damping=1.5, eccentricity=0.1, half_backlash=0.6)
    phases = np.linspace(0.0, 1.0, 1000, endpoint=False)
    level = quiet_level(machine_of(oscillator), _FASTEST)
    # The last strip of speeds is at most a 25th of them high; the least of a(t) is enclosed within a per cent.
    assert 1.0 < level * _felt(oscillator, phases).min() / _FASTEST**3 < 1.04**3 * 1.01


def _leaves(disc, oscillator, random):
    """Whether one of many departures near the rim of a disc comes back outside."""
    exact, angle = ExactMap(oscillator), 2.0 * np.pi * random.random(_DEPARTURES)
    x = np.linalg.solve(disc.frame, 0.999999 * disc.radius * np.stack([np.cos(angle), np.sin(angle)]))
    for place in zip(disc.t + x[0], disc.v + x[1], strict=True):
        for _ in range(disc.impacts):
            place = exact.image(*(float(each) for each in place))
        off = (float(place[0]) - disc.t + 0.5) % 1.0 - 0.5, float(place[1]) - disc.v
        if not np.linalg.norm(disc.frame @ off) < disc.radius:
            return True
    return False


def test_discs_are_mapped_into_themselves():
    attractors, certificate = _certificate()
    assert certificate.discs
    for number, disc in certificate.discs.items():
        assert attractors[number].upper_contacts == disc.impacts
        assert not _leaves(disc, FIG_7, np.random.default_rng(2))


def test_departures_of_a_disc_come_nearer_to_each_other():
    random = np.random.default_rng(7)
    _, certificate = _certificate()
    for disc in certificate.discs.values():
        angle, size = 2.0 * np.pi * random.random((2, 5000)), np.sqrt(random.random(5000))
        x = disc.radius * size * np.stack([np.cos(angle[0]), np.sin(angle[0])])
        pairs = np.linalg.solve(disc.frame, np.hstack([x, x + 1e-7 * np.stack([np.cos(angle[1]), np.sin(angle[1])])]))
        landed = next_impacts(FIG_7, disc.t + pairs[0], disc.v + pairs[1], disc.impacts)
        (t, other_t), (v, other_v) = np.split(landed.t, 2), np.split(landed.v, 2)
        apart = (t - other_t + 0.5) % 1.0 - 0.5, v - other_v
        assert np.linalg.norm(disc.frame @ np.stack(apart), axis=0).max() < 1e-7


def test_the_norm_of_a_matrix_is_bounded_closely():
    for matrix in np.random.default_rng(9).normal(size=(100, 2, 2)):
        bound = spectral_norm(Matrix(*(point(float(each)) for each in matrix.ravel())))
        assert 1.0 - 1e-12 < np.linalg.norm(matrix, 2) / bound < 1.0 + 1e-15


@kernel_as_written
def _come_nearer(machine, oscillator, boxes, discs, nearer):
    one, none = point(1.0), point(0.0)
    plain = Matrix(one, none, none, one)
    for k in range(boxes.shape[0]):
        box = Box(Interval(boxes[k, 0], boxes[k, 1]), Interval(boxes[k, 2], boxes[k, 3]))
        nearer[k] = _comes_nearer(machine, oscillator, 1, discs[k], box, plain, plain)


def test_departures_that_come_into_a_disc_but_no_nearer_prove_nothing():
    """Tiny boxes that land in the middle of a large disc: only the norm of DP decides."""
    random, machine = np.random.default_rng(11), machine_of(FIG_7)
    t, v = random.random(300), random.uniform(0.1, 7.0, 300)
    boxes = np.stack([t, t + 1e-9, v, v + 1e-9], axis=1)
    images = enclose_images(machine, FIG_7, boxes)
    known = images.states == PROVEN
    norms = np.linalg.norm(images.slopes.mean(axis=3)[known], 2, axis=(1, 2))
    discs = np.array([[1.0, h[0] % 1.0, h[2], 1.0, 0.0, 0.0, 1.0, 0.01] for h in images.hulls[known]])
    nearer = np.empty(norms.size, np.bool_)
    _come_nearer(machine, FIG_7, boxes[known], discs, nearer)
    decided = np.abs(norms - 1.0) > 1e-3
    np.testing.assert_array_equal(nearer[decided], norms[decided] < 1.0)
    assert nearer.any() and not nearer.all()


def test_orbits_of_several_impacts_have_discs_that_boxes_fit_into():
    """The disc is covered by small parts where its edge is near; by few large ones it was five times smaller."""
    oscillator = Oscillator(damping=0.55, eccentricity=0.1, half_backlash=0.6)
    settled = next_impacts(oscillator, np.linspace(0.0, 1.0, 100), np.full(100, 4.5), 1000)
    rattling = np.isfinite(settled.t)
    attractors = find_attractors(oscillator, settled.t[rattling], settled.v[rattling])
    (several,) = (each for each in attractors if each.name == "P(2,2,1)")
    disc = orbit_disc(machine_of(oscillator), oscillator, several)
    assert min(disc.half_sides) > 1.0 / 128.0
    assert not _leaves(disc, oscillator, np.random.default_rng(8))


def test_a_disc_that_a_departure_leaves_is_not_proven():
    """Discs beside the orbit, so that departures leave on any side."""
    random, machine, angle = np.random.default_rng(6), machine_of(FIG_7), 2.0 * np.pi * np.linspace(0.0, 1.0, 200)
    _, certificate = _certificate()
    (disc,) = certificate.discs.values()
    rim = np.stack([np.cos(angle), np.sin(angle)])
    left = 0
    for _ in range(300):
        radius = disc.radius * 10.0 ** random.uniform(-2.0, 0.5)
        t, v = (disc.t, disc.v) + np.linalg.solve(disc.frame, random.uniform(-1.0, 1.0, 2) * radius)
        one = disc._replace(t=float(t), v=float(v), radius=radius)
        x = np.linalg.solve(disc.frame, radius * rim)
        landed = next_impacts(FIG_7, t + x[0], v + x[1], disc.impacts)
        off = np.stack([(landed.t - t + 0.5) % 1.0 - 0.5, landed.v - v])
        if np.linalg.norm(disc.frame @ off, axis=0).max() > 1.000001 * radius:
            left += 1
            assert not maps_into_itself(machine, FIG_7, disc.impacts, disc_rows({0: one})[0])
    assert left > 30


@pytest.mark.parametrize(("part", "known"), [(1e-4, True), (0.002, False)])
def test_within_tolerances_a_disc_holds_the_orbits_of_all_machines(part, known):
    attractors, _ = _certificate()
    (periodic,) = (each for each in attractors if each.kind == AttractorKind.PERIODIC)
    damping = 0.6 * (1.0 - part), 0.6 * (1.0 + part)
    disc = orbit_disc(machine_of(FIG_7, {"damping": damping}), FIG_7, periodic)
    assert disc is not None or not known
    for each in damping if disc else ():
        assert not _leaves(disc, FIG_7.at(damping=each), np.random.default_rng(5))


def test_a_set_that_rattles_for_ever_is_mapped_into_itself():
    random = np.random.default_rng(3)
    attractors, certificate = _certificate()
    lattice = certificate.targets.rattling
    assert attractors[certificate.rattling].is_chaotic
    exact, columns = ExactMap(FIG_7), lattice.ends.shape[1]
    rows, places = np.nonzero(lattice.ends)
    for k in random.integers(0, rows.size, _DEPARTURES):
        t, v = (places[k] + random.random()) / columns, (lattice.first + rows[k] + random.random()) * lattice.height
        landed = exact.image(t, v)
        row = int(np.floor(float(landed.v) / lattice.height)) - lattice.first
        assert lattice.ends[row, int(np.floor(float(landed.t) * columns)) % columns] == 1 + certificate.rattling


@pytest.mark.parametrize("columns", [1024, 2048])
def test_the_fewest_boxes_hold_their_images(columns):
    """Of departures near the edges and corners of boxes as well."""
    random = np.random.default_rng(4)
    attractors, certificate = _certificate()
    chaos = attractors[certificate.rattling]
    search = Search(machine_of(FIG_7), FIG_7, 0.0, 8192, fewest=columns)
    lattice = closed_set(search, chaos.time, chaos.velocity, 7)
    assert lattice.ends.shape[1] == columns
    exact = ExactMap(FIG_7)
    rows, places = np.nonzero(lattice.ends)
    for k in random.integers(0, rows.size, _DEPARTURES):
        across, up = random.choice([0.001, 0.999, random.random()], 2)
        t, v = (places[k] + across) / columns, (lattice.first + rows[k] + up) * lattice.height
        landed = exact.image(t, v)
        row = int(np.floor(float(landed.v) / lattice.height)) - lattice.first
        assert lattice.ends[row, int(np.floor(float(landed.t) * columns)) % columns] == 7


def test_a_set_that_holds_another_known_motion_is_not_said_to_rattle():
    attractors, certificate = _certificate()
    lattice, machine = certificate.targets.rattling, machine_of(FIG_7)
    chaos = attractors[certificate.rattling]
    others = [each for each in attractors if each is not chaos]
    for known, expected in ((others, True), ([*others, chaos._replace(time=chaos.time + 1.0)], False)):
        assert _holds_no_other(machine, lattice, certificate.level, certificate.discs.values(), known) == expected


def test_departures_of_proven_boxes_end_there():
    """The lattice before it grows: the quiet core."""
    _, certificate = _certificate()
    lattice, random = certificate.targets.lattice, np.random.default_rng(4)
    rows, columns = np.nonzero(lattice.ends)
    assert rows.size > 0
    t = (columns + random.random(rows.size)) / lattice.ends.shape[1]
    v = (lattice.first + rows + random.random(rows.size)) * lattice.height
    assert (v < grazing_velocity(FIG_7, t)).all()
    # All of a box lies in the core: its upper edge, at the phase where a is least.
    top = (lattice.first + rows + 1) * lattice.height
    for part in (0.0, 0.5, 1.0):
        assert (top**3 < certificate.level * _felt(FIG_7, (columns + part) / lattice.ends.shape[1])).all()
    assert (map_points(FIG_7, CellGrid(), 1499, t, v).image_cell == PERMANENT_CONTACT).all()


@pytest.mark.parametrize("oscillator", OSCILLATORS)
def test_halves_hold_all_machines_and_their_own_centres(oscillator):
    machine = machine_of(oscillator, tolerances_of(oscillator))
    for _ in range(8):
        halves = halves_of(machine)
        for whole, *parts in zip(_ranges(machine), *map(_ranges, halves), strict=True):
            assert (min(low for low, _ in parts), max(high for _, high in parts)) == whole
            assert parts[0] == parts[1] or parts[0][1] == parts[1][0]
        machine = halves[0]
        for half in halves:
            centre = machine_of(centre_of(half))
            for (low, high), (value, same) in zip(_ranges(half), _ranges(centre), strict=True):
                assert low <= value == same <= high


def _ranges(machine):
    rows = [row[each : each + 2] for row in machine.harmonics.tolist() for each in (1, 3)]
    return tuple(tuple(each) for each in (machine.damping, machine.half_backlash, machine.restitution, *rows))


@pytest.mark.parametrize("oscillator", OSCILLATORS)
def test_parts_hold_all_machines_once(oscillator):
    machine = machine_of(oscillator, tolerances_of(oscillator))
    parts = parts_of(machine)
    assert len(parts) == MOST_PARTS
    sides = [{low for low, _ in each} for each in zip(*map(_ranges, parts), strict=True)]
    # Parts are alike, and as many as there are places for them: so they fill the whole.
    assert math.prod(map(len, sides)) == len({_ranges(part) for part in parts}) == MOST_PARTS
    for place, (low, high) in enumerate(_ranges(machine)):
        ends = sorted({_ranges(part)[place] for part in parts})
        assert (ends[0][0], ends[-1][1]) == (low, high)
        assert [first for first, _ in ends[1:]] == [last for _, last in ends[:-1]]


def test_narrow_tolerances_are_not_cut():
    assert len(parts_of(machine_of(FIG_7))) == 1
    assert len(parts_of(machine_of(FIG_7, {"damping": (0.5997, 0.6003)}))) == 1
    assert len(parts_of(machine_of(FIG_7, {"half_backlash": (0.598, 0.602)}))) == 4


def test_a_machine_without_tolerances_has_no_halves():
    assert halves_of(machine_of(FIG_7)) == []
    assert halves_of(machine_of(FIG_7, {"half_backlash": (0.5, 0.7)})) == []


def test_a_machine_that_may_break_eq_8_is_refused():
    with pytest.raises(ValueError, match="Eq. 8"):
        machine_of(Oscillator(0.6, 0.1, 0.6), {"eccentricity": (0.1, 0.3)})

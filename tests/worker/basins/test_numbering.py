"""Numbers of solutions from panel to panel, on catalogues made by hand and by Newton."""

import numpy as np
import pytest

from rattle_kernels import (
    Attractor,
    AttractorKind,
    Oscillator,
    attractor_distance,
    continue_attractor,
    find_attractors,
)
from worker.basins.numbering import Numbered, Numbering
from worker.jobs.basin_job import SweepJob
from worker.jobs.swept_parameter import SweptParameter
from worker.stores.changes import list_changes
from worker.stores.solution_table import SolutionTable

QUIET = find_attractors(Oscillator(), [], [])[0]
JOB = SweepJob(vary=(SweptParameter("damping", (0.58, 0.6, 0.62, 0.64)),))


def rattle(damping):
    """P(1,1,0), which strikes with v = 2 pi delta."""
    return find_attractors(Oscillator(damping=damping), [0.89829], [2.0 * np.pi * damping])[1]


def chaos(speed, points=300):
    rng = np.random.default_rng(0)
    return Attractor(AttractorKind.CHAOTIC, 0, 0, 0, 0.3, 0.01, rng.random(points), speed + 0.1 * rng.random(points))


def numbered(catalogues, job=JOB):
    table = SolutionTable.empty(job)
    numbering = Numbering(job, table, lambda basin: pytest.fail(f"basin {basin} was numbered in this run"))
    return table, [numbering.assign(basin, tuple(catalogue)) for basin, catalogue in enumerate(catalogues)]


def test_the_first_panels_catalogue_is_its_own_numbering():
    _, (first,) = numbered([[QUIET, rattle(0.58), chaos(1.0)]])
    assert first.numbers == [0, 1, 2]


def test_an_orbit_is_continued_by_newton_also_where_no_cell_ends_in_it():
    _, basins = numbered([[QUIET, rattle(0.58)], [QUIET], [QUIET, rattle(0.62)]])
    assert [basin.numbers for basin in basins] == [[0, 1], [0, 1], [0, 1]]
    assert basins[1].attractors[1].velocity.tolist() == pytest.approx([1.2 * np.pi])


def test_the_closest_of_one_kind_are_the_same():
    _, basins = numbered([[QUIET, chaos(1.0), chaos(4.0)], [QUIET, chaos(4.1), chaos(1.1)]])
    assert basins[1].numbers == [0, 2, 1]


def test_what_comes_back_has_its_old_number():
    _, basins = numbered([[QUIET, chaos(1.0)], [QUIET], [QUIET, chaos(3.0)], [QUIET, chaos(3.0), chaos(1.0)]])
    assert [basin.numbers for basin in basins] == [[0, 1], [0], [0, 1], [0, 1, 2]]


def test_what_dies_and_is_born_is_listed_with_its_interval():
    table, basins = numbered([[QUIET, chaos(1.0)], [QUIET], [QUIET, chaos(3.0)]])
    for basin, each in enumerate(basins):
        table.enter(basin, each.numbers, each.attractors, np.zeros(len(each.numbers)))
    columns = [column.tolist() for column in list_changes(JOB, table)]
    assert [row[:5] for row in zip(*columns, strict=True)] == [
        (2, 1, "damping", 0.58, 0.6), (1, 1, "damping", 0.6, 0.62),
    ]  # fmt: skip


def test_numbering_goes_on_from_what_was_read():
    catalogues = [[QUIET, rattle(0.58), chaos(1.0)], [QUIET, chaos(1.1)], [QUIET, chaos(1.2), chaos(4.0)]]
    table, whole = numbered(catalogues)
    for basin, each in enumerate(whole):
        table.enter(basin, each.numbers, each.attractors, np.zeros(len(each.numbers)))
    table.forget_after(2)
    assert len(table.motions) == 3
    resumed = Numbering(JOB, table, lambda basin: Numbered(whole[basin].attractors, whole[basin].numbers))
    assert resumed.assign(2, tuple(catalogues[2])).numbers == whole[2].numbers


def test_over_two_parameters_what_the_last_does_not_have_the_first_has():
    vary = SweptParameter("half_backlash", (0.6, 0.61)), SweptParameter("damping", (0.58, 0.6))
    job = SweepJob(vary=vary)
    _, basins = numbered([[QUIET], [QUIET, chaos(1.0)], [QUIET], [QUIET, chaos(1.2), chaos(4.0)]], job)
    assert [basin.numbers for basin in basins] == [[0], [0, 1], [0], [0, 1, 2]]


def test_only_an_attracting_orbit_of_the_same_itinerary_is_a_continuation():
    orbit = rattle(0.6)
    assert continue_attractor(Oscillator(damping=0.7), orbit) is None
    assert continue_attractor(Oscillator(damping=0.61), chaos(1.0)) is None
    near = continue_attractor(Oscillator(damping=0.601), orbit)
    assert near is not None and near.name == "P(1,1,0)"
    assert attractor_distance(Oscillator(), near, rattle(0.601)) < 1e-9
    assert 1e-4 < attractor_distance(Oscillator(), near, orbit) < 1e-2


def test_the_distance_of_orbits_does_not_depend_on_where_a_turn_begins():
    turn = Attractor(AttractorKind.PERIODIC, 2, 2, 0, -1.0, 0.0, np.array([0.1, 0.6]), np.array([1.0, 2.0]))
    shifted = turn._replace(time=turn.time[::-1], velocity=turn.velocity[::-1])
    assert attractor_distance(Oscillator(), turn, shifted) == 0.0


# Two harmonics beside the first, as in other tests: kernels are compiled for that number of them.
TURN = Oscillator(harmonics=((2.0, 0.01, 0.5), (3.0, 0.0005, 0.3)))


def sweep_of_phases(*phases, beside=()):
    return SweepJob(oscillator=TURN, vary=(*beside, SweptParameter("phase_2", phases)))


def test_a_phase_that_has_come_around_has_the_numbers_of_its_machine():
    pairs = (1.0, 4.0), (2.0, 5.0), (3.0, 6.0), (1.0, 4.0)  # from value to value, the closest of the last swap numbers
    catalogues = [[QUIET, chaos(slow), chaos(fast)] for slow, fast in pairs]
    _, basins = numbered(catalogues, sweep_of_phases(-0.5, 0.1, 0.2, 0.5))
    assert [basin.numbers for basin in basins] == [[0, 1, 2]] * 4
    _, basins = numbered(catalogues, sweep_of_phases(-0.5, 0.1, 0.2, 0.4))
    assert basins[3].numbers == [0, 2, 1]


@pytest.mark.slow
def test_a_phase_that_has_come_around_has_no_motion_more_than_its_machine():
    once = find_attractors(TURN, [0.89829], [1.2 * np.pi])[1]
    catalogues = [QUIET], [QUIET, once], [QUIET]
    _, basins = numbered(catalogues, sweep_of_phases(0.5, 1.0, 1.5))
    assert [basin.numbers for basin in basins] == [[0], [0, 1], [0]]
    _, basins = numbered(catalogues, sweep_of_phases(0.5, 1.0, 1.49))
    assert basins[2].numbers == [0, 1]


def test_phases_come_around_at_each_value_of_another_parameter():
    restitution = SweptParameter("restitution", (0.9, 0.8))
    catalogues = [[QUIET, chaos(speed)] for speed in (1.0, 2.0, 1.0, 7.0, 8.0, 7.0)]
    catalogues[1] = [QUIET]
    _, basins = numbered(catalogues, sweep_of_phases(0.0, 0.3, 1.0, beside=(restitution,)))
    assert [basin.numbers for basin in basins] == [[0, 1], [0], [0, 1], [0, 1], [0, 1], [0, 1]]


def test_numbers_of_a_phase_that_has_come_around_are_read_where_a_run_is_resumed():
    catalogues = [[QUIET, chaos(slow), chaos(fast)] for slow, fast in ((1.0, 4.0), (2.0, 5.0), (3.0, 6.0), (1.0, 4.0))]
    job = sweep_of_phases(0.0, 0.1, 0.2, 1.0)
    table, whole = numbered(catalogues, job)
    for basin, each in enumerate(whole[:3]):
        table.enter(basin, each.numbers, each.attractors, np.zeros(len(each.numbers)))
    resumed = Numbering(job, table, lambda basin: whole[basin])
    assert resumed.assign(3, tuple(catalogues[3])).numbers == [0, 1, 2]


def test_neighbours_of_a_sweep_that_is_not_square():
    """Two values of the first parameter, three of the last, which varies fastest."""
    vary = (SweptParameter("damping", (0.58, 0.6)), SweptParameter("eccentricity", (0.09, 0.1, 0.11)))
    job, asked = SweepJob(vary=vary), {}

    def read(basin):
        asked[current].append(basin)
        return Numbered((QUIET,), [0])

    table = SolutionTable.empty(job)
    for current in range(6):
        asked[current] = []
        Numbering(job, table, read).assign(current, (QUIET,))
    assert asked == {0: [], 1: [0], 2: [1], 3: [0], 4: [3, 1], 5: [4, 2]}

"""How long a job takes, and how large its store is, is said before it begins."""

import math

import pytest

from rattle_kernels import CellGrid, Oscillator
from worker import estimate as estimates
from worker.estimate import Estimate, estimate, measured_speed
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.bifurcation_job import BifurcationJob
from worker.jobs.orbits_job import OrbitsJob
from worker.jobs.swept_parameter import SweptParameter
from worker.kinds import KINDS

SPEED = 1e6


@pytest.fixture(autouse=True)
def known_speed(monkeypatch):
    monkeypatch.setattr(estimates, "measured_speed", lambda stiff, together: SPEED / (2 if stiff else 1))


def basin(cells, **fields):
    return BasinJob(grid=CellGrid(time_cells=cells, velocity_cells=cells), **fields)


def beyond_small(job, **cores):
    """Seconds of a job beyond those of one of the same kind that maps next to nothing."""
    small = {"grid": CellGrid(time_cells=1, velocity_cells=1), "iterations": 1}
    fields = {"vary": job.vary} if job.vary else {}
    return estimate(job, **cores).seconds - estimate(type(job)(**small, **fields), **cores).seconds


def test_a_basin_takes_its_cells_times_k_at_the_measured_speed_on_all_cores():
    applications = 100**2 * 1499
    assert beyond_small(basin(100, iterations=1499)) == pytest.approx(applications / SPEED, rel=1e-5)
    assert beyond_small(basin(100, iterations=1499), cores=4) == pytest.approx(applications / SPEED / 4, rel=1e-5)
    stiff = basin(100, iterations=1499, oscillator=Oscillator(stiffness=1e4))
    assert beyond_small(stiff) == pytest.approx(2 * applications / SPEED, rel=1e-5)


def test_a_sweep_takes_that_of_all_its_basins():
    swept = sweep(3, 10)
    assert beyond_small(swept) == pytest.approx(3 * beyond_small(basin(10, iterations=1499)), rel=1e-4)
    assert estimate(swept).bytes == 3 * estimate(basin(10)).bytes


def sweep(values, cells):
    return SweepJob(
        vary=[SweptParameter("damping", tuple(0.6 + 0.001 * i for i in range(values)))],
        grid=CellGrid(time_cells=cells, velocity_cells=cells), iterations=1499,
    )  # fmt: skip


def test_what_a_job_takes_besides_its_impacts_is_counted(monkeypatch):
    """A basin of one tile takes some 0.1 to 0.5 s, however fast its few impacts are; so do those of a sweep, each."""
    monkeypatch.setattr(estimates, "measured_speed", lambda stiff, together: 1e12)
    assert all(0.1 <= estimate(basin(20, iterations=101), cores).seconds <= 0.6 for cores in (1, 2, 64))
    # One basin is not solved twice as fast on two cores, many are.
    one, many = estimate(basin(20), 1).seconds, [estimate(sweep(101, 20), cores).seconds for cores in (1, 2)]
    assert one == pytest.approx(estimate(basin(20), 2).seconds)
    assert many[0] > 10.0 and many[1] < 0.6 * many[0]


@pytest.mark.parametrize(("seconds", "told"), [(0.3, "1 s"), (1.3, "2 s"), (59.0, "59 s"), (90.0, "1.5 minutes")])
def test_up_to_is_never_less(seconds, told):
    assert f"some {told}," in str(Estimate(seconds, 1000))


def test_a_store_holds_as_many_bytes_for_each_cell_as_its_arrays():
    from worker.stores.layout import LABELLED, MAPPED

    solution = 2
    arrays = sum(math.ceil(variable.dtype(0).nbytes) for variable in (*MAPPED, *LABELLED))
    assert estimate(basin(7)).bytes in (49 * arrays, 49 * (arrays + solution))


def test_the_work_that_no_one_can_guess_is_counted():
    """Longer orbits take more impacts each, and there are more of them; so does a long transient."""
    assert estimate(OrbitsJob(longest=2500, cells=20)).seconds > 1e5 * estimate(OrbitsJob(longest=4, cells=20)).seconds
    diagram = {"vary": SweptParameter("damping", (0.55, 0.6)), "seeds": [(0.76, 4.0)]}
    assert estimate(BifurcationJob(**diagram_of(diagram, 4_000_000_000))).seconds > 1800


def diagram_of(diagram, transient):
    from worker.jobs.region import Departure

    return diagram | {"seeds": [Departure(0.76, 4.0)], "transient": transient}


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_has_an_estimate(kind):
    fields = {
        "sweep": {"vary": [{"parameter": "damping", "values": [0.6]}]},
        "bifurcation": {"vary": {"parameter": "damping", "values": [0.6]}},
        "manifold": {"saddles": [{"itinerary": "P(1,1,0)"}]},
    }.get(kind, {})
    found = estimate(KINDS[kind].job_class.from_request(fields))
    assert found.seconds > 0 and found.bytes > 0 and "before compression" in str(found)


def test_nothing_is_measured_where_a_client_waits(monkeypatch):
    monkeypatch.setattr(estimates, "_measured", {})
    monkeypatch.setattr(estimates, "next_impacts", None)  # would compile
    assert beyond_small(basin(100, iterations=1499), measuring=False) == pytest.approx(100**2 * 1499 / 1e7, rel=1e-5)


@pytest.mark.parametrize("together", [True, False])
def test_what_is_timed_needs_no_kernel_that_is_not_loaded_yet(monkeypatch, together):
    calls = []
    monkeypatch.setattr(estimates, "_measured", {})
    monkeypatch.setattr(estimates, "next_impacts", lambda oscillator, t, v, applications: calls.append(applications))
    measured_speed(stiff=False, together=together)
    loaded, timed = calls
    # Short runs and long ones have kernels of their own.
    assert loaded == timed

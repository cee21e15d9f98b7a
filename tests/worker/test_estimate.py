"""How long a job takes, and how large its store is, is said before it begins."""

import math

import pytest

from rattle_kernels import CellGrid, Oscillator
from worker import estimate as estimates
from worker.estimate import estimate, measured_speed
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


def test_a_basin_takes_its_cells_times_k_at_the_measured_speed_on_all_cores():
    assert estimate(basin(100, iterations=1499)).seconds == pytest.approx(100**2 * 1499 / SPEED)
    assert estimate(basin(100, iterations=1499), cores=4).seconds == pytest.approx(100**2 * 1499 / SPEED / 4)
    stiff = basin(100, iterations=1499, oscillator=Oscillator(stiffness=1e4))
    assert estimate(stiff).seconds == pytest.approx(2 * 100**2 * 1499 / SPEED)


def test_a_sweep_takes_that_of_all_its_basins():
    swept = SweepJob(
        vary=[SweptParameter("damping", (0.6, 0.7, 0.8))], grid=CellGrid(time_cells=10, velocity_cells=10),
        iterations=1499,
    )  # fmt: skip
    assert estimate(swept).seconds == pytest.approx(3 * estimate(basin(10, iterations=1499)).seconds)
    assert estimate(swept).bytes == 3 * estimate(basin(10)).bytes


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
    assert estimate(basin(100, iterations=1499), measuring=False).seconds == pytest.approx(100**2 * 1499 / 1e7)


@pytest.mark.parametrize("together", [True, False])
def test_what_is_timed_needs_no_kernel_that_is_not_loaded_yet(monkeypatch, together):
    calls = []
    monkeypatch.setattr(estimates, "_measured", {})
    monkeypatch.setattr(estimates, "next_impacts", lambda oscillator, t, v, applications: calls.append(applications))
    measured_speed(stiff=False, together=together)
    loaded, timed = calls
    # Short runs and long ones have kernels of their own.
    assert loaded == timed

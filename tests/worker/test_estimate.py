"""How long a job takes, and how large its store is, is said before it begins."""

import math
import os
import subprocess
import sys

import pytest
import xarray as xr

from rattle_kernels import CellGrid, Oscillator
from tests.watched_run import Watch, run_watched
from worker import estimate as estimates
from worker.estimate import Estimate, estimate, measured_speed
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.bifurcation_job import BifurcationJob
from worker.jobs.manifold_job import ManifoldJob
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


@pytest.mark.parametrize(("direction", "ways"), [("up", 1), ("down", 1), ("both", 2)])
def test_a_diagram_takes_the_impacts_of_every_seed_at_every_value_each_way(direction, ways):
    fields = {
        "vary": {"parameter": "damping", "values": [0.55, 0.56, 0.58]}, "direction": direction,
        "seeds": [{"time": 0.76, "velocity": 4.0}, {"time": 0.6, "velocity": 3.77}], "transient": 300, "kept": 20,
    }  # fmt: skip
    job = KINDS["bifurcation"].job_class.from_request(fields)
    counted = ways * 3 * 2 * (300 + 20)
    assert job.impacts == counted
    assert estimate(job).seconds - estimates._OF_A_JOB == pytest.approx(counted / SPEED)


# Kernels that are not compiled are functions whose calls can be counted, wherever they are called.
COUNT_A_SEARCH = """
import sys
from rattle_kernels.orbits import orbit_search, orbit_seeds, periodic_orbit
from rattle_kernels import Oscillator
calls = 0
def counted(function):
    def count(*arguments):
        global calls
        calls += 1
        return function(*arguments)
    return count
for module in (orbit_seeds, periodic_orbit):
    for name in ("next_impact", "next_impact_with_jacobian"):
        setattr(module, name, counted(getattr(module, name)))
orbit_search.find_orbits(Oscillator(), longest=int(sys.argv[2]), cells=int(sys.argv[1]))
print(calls)
"""


@pytest.mark.parametrize(("cells", "longest"), [(4, 1), (6, 1), (4, 2), pytest.param(4, 4, marks=pytest.mark.slow)])
def test_a_search_for_orbits_takes_as_many_impacts_as_its_kernels_are_called_for_within_a_factor(cells, longest):
    command = [sys.executable, "-W", "ignore", "-c", COUNT_A_SEARCH, str(cells), str(longest)]
    counting = subprocess.run(
        command, env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, capture_output=True, text=True, check=True
    )
    job = OrbitsJob(cells=cells, longest=longest)
    assert int(counting.stdout) <= job.impacts <= 4 * int(counting.stdout)
    # Saddles of an itinerary are found by the same search.
    named, given = (
        KINDS["manifold"].job_class.from_request(
            {"saddles": [saddle], "cells": cells} if named else {"saddles": [saddle]}
        )
        for named, saddle in ((True, {"itinerary": f"P(1,{longest},0)"}), (False, {"time": 0.6, "velocity": 3.77}))
    )
    assert named.impacts - given.impacts == job.impacts


COUNTED = {
    "manifold": {"saddles": [{"time": 0.6017, "velocity": 3.7699}], "arclength": 4.0},
    "grazing_curve": {"order": 2, "most_points": 1000},
}


@pytest.mark.parametrize("kind", COUNTED)
def test_curves_take_as_many_impacts_as_their_points_within_a_factor(kind, tmp_path):
    """Each point is an image, or the pre-image, of one before, and is mapped some twenty times at the most.

    How many points a curve takes is guessed within a factor of two.
    """
    job = KINDS[kind].job_class.from_request(COUNTED[kind])
    assert run_watched(job, tmp_path / "curves.zarr", Watch())
    with xr.open_zarr(tmp_path / "curves.zarr") as store:
        points = store.sizes["vertex"]
    assert points <= job.impacts <= 2 * 20 * points
    assert 16 * points <= 2 * estimate(job).bytes


def test_the_shortest_chord_gives_a_branch_its_most_points():
    saddle = {"time": 0.6017, "velocity": 3.77}
    tiny, most = (
        ManifoldJob.from_request(
            {"saddles": [saddle], "most_points": 100, "resolution": {"chord": chord, "finest": chord}}
        )
        for chord in (5e-324, 1e-9)
    )
    assert estimate(tiny).bytes == estimate(most).bytes == 2 * 100 * 16  # two branches of a side

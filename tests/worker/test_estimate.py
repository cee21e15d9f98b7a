"""How long a job takes, and how large its store is, is said before it begins."""

import math
import os
import subprocess
import sys

import pytest
import xarray as xr

from rattle_kernels import CellGrid, Oscillator
from rattle_kernels.lanes import run as lanes_run
from rattle_kernels.orbits import bifurcation_diagram
from tests.analysis_requests import CHART, REPORT
from tests.watched_run import Watch, run_watched
from worker import estimate as estimates
from worker.analyses.bifurcation import plan
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
    slower = {"impacting": 1, "stiff": 2, "loose": 10, "loose and stiff": 50}
    monkeypatch.setattr(estimates, "measured_speed", lambda model, together: SPEED / slower[model])


def basin(cells, **fields):
    return BasinJob(grid=CellGrid(time_cells=cells, velocity_cells=cells), **fields)


def beyond_small(job, **cores):
    """Seconds of a job beyond those of one of the same kind that maps next to nothing."""
    small = {"grid": CellGrid(time_cells=1, velocity_cells=1), "iterations": 1}
    fields = {"vary": job.vary} if job.vary else {}
    return estimate(job, **cores).seconds - estimate(type(job)(**small, **fields), **cores).seconds


def test_a_basin_takes_its_cells_times_k_and_their_naming_at_the_measured_speed_on_all_cores():
    # Of a hundred cells three land alone, and are named.
    applications, stiffly = 100**2 * (1499 + 0.03 * 300), 100**2 * (1499 + 0.03 * 2500)
    assert beyond_small(basin(100, iterations=1499)) == pytest.approx(applications / SPEED, rel=2e-4)
    assert beyond_small(basin(100, iterations=1499), cores=4) == pytest.approx(applications / SPEED / 4, rel=2e-4)
    stiff = basin(100, iterations=1499, oscillator=Oscillator(stiffness=1e4))
    assert beyond_small(stiff) == pytest.approx(2 * stiffly / SPEED, rel=2e-4)


@pytest.mark.parametrize("stiffness", [None, 1e4])
def test_a_basin_whose_cells_are_mapped_once_takes_at_most_what_is_told_within_a_factor(stiffness, tmp_path):
    """With k = 1 each cell lands elsewhere, so that naming is nearly all of the work."""
    script = (
        "import sys, time, rattle\n"
        "from types import SimpleNamespace\n"
        "import worker.estimate\n"
        "worker.estimate.time = SimpleNamespace(perf_counter=time.process_time)\n"
        "stiffness, folder = eval(sys.argv[1]), sys.argv[2]\n"
        "rattle.basin(cells=20, iterations=1, stiffness=stiffness, store=f'{folder}/small', progress=False)\n"
        "begun = time.process_time()\n"
        "rattle.basin(cells=500, iterations=1, stiffness=stiffness, store=f'{folder}/basin', progress=False)\n"
        "took = time.process_time() - begun\n"
        "grid = {'time': {'cells': 500}, 'velocity': {'cells': 500}}\n"
        "model = {'model': 'piecewise_linear', 'stiffness': stiffness} if stiffness else {}\n"
        "print(took, rattle.estimate(rattle.BasinJob(oscillator=model, grid=grid, iterations=1)).seconds)\n"
    )
    told = subprocess.run(
        [sys.executable, "-c", script, repr(stiffness), tmp_path],
        capture_output=True, text=True, check=True, timeout=110,
    )  # fmt: skip
    took, estimated = map(float, told.stdout.split())
    # Both in processor time: wall time is anything on a busy machine. Stiffer machines need five times as much.
    assert took < estimated < 20.0 * took


def sweep(values, cells):
    return SweepJob(
        vary=[SweptParameter("damping", tuple(0.6 + 0.001 * i for i in range(values)))],
        grid=CellGrid(time_cells=cells, velocity_cells=cells), iterations=1499,
    )  # fmt: skip


def test_what_a_job_takes_besides_its_impacts_is_counted(monkeypatch):
    """A basin of one tile takes some 0.1 to 0.5 s, however fast its few impacts are; so do those of a sweep, each."""
    monkeypatch.setattr(estimates, "measured_speed", lambda model, together: 1e12)
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
        "report": REPORT,
        "chart": CHART,
    }.get(kind, {})
    found = estimate(KINDS[kind].job_class.from_request(fields))
    assert found.seconds > 0 and found.bytes > 0 and "before compression" in str(found)


def test_nothing_is_measured_where_a_client_waits(monkeypatch):
    monkeypatch.setattr(estimates, "_measured", {})
    monkeypatch.setattr(estimates, "next_impacts", None)  # would compile
    assert beyond_small(basin(100, iterations=1499), measuring=False) == pytest.approx(100**2 * 1508 / 1e7, rel=2e-4)


@pytest.mark.parametrize("together", [True, False])
def test_what_is_timed_needs_no_kernel_that_is_not_loaded_yet(monkeypatch, together):
    calls = []
    monkeypatch.setattr(estimates, "_measured", {})
    monkeypatch.setattr(estimates, "next_impacts", lambda oscillator, t, v, applications: calls.append(applications))
    measured_speed("impacting", together=together)
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


@pytest.fixture
def counted(monkeypatch):
    """What is counted by kind of kernel: impacts of lanes in the search for seeds, and of motions one by one."""
    counts = {"together": 0, "alone": 0}

    def counting(module, name, kind, impacts):
        function = getattr(module, name)

        def count(*arguments):
            result = function(*arguments)
            counts[kind] += int(impacts(result, *arguments))
            return result

        monkeypatch.setattr(module, name, count)

    for name in ("run_short", "run_long"):
        counting(lanes_run, name, "together", lambda run, *_: run.applications)
    settle, leg = bifurcation_diagram._settle_leg, bifurcation_diagram._IMPACTS_A_LEG

    def settled(oscillator, search, transient):
        before = search.counts[0]
        outcome = settle(oscillator, search, transient)
        counts["alone"] += int(min(search.counts[0] - before, leg))  # beyond a leg, turns were skipped
        return outcome

    monkeypatch.setattr(bifurcation_diagram, "_settle_leg", settled)
    counting(bifurcation_diagram, "_keep_leg", "alone", lambda _, _o, _t, _v, times, speeds: times.size)
    return counts


# How many motions there are is guessed: these have four, three (one of them chaotic), and one.
@pytest.mark.parametrize(
    ("fields", "values"),
    [({"damping": 0.502, "eccentricity": 0.0958, "half_backlash": 0.597}, [0.502, 0.503]), ({}, [0.55, 0.56, 0.57]),
     ({"damping": 0.661, "eccentricity": 0.0759, "half_backlash": 0.773}, [0.661, 0.663])],
)  # fmt: skip
@pytest.mark.parametrize("direction", ["up", "both"])
def test_a_diagram_without_seeds_takes_the_impacts_of_a_search_and_of_its_motions_within_a_factor(
    counted, monkeypatch, fields, values, direction
):
    oscillator = Oscillator(**fields)
    job = BifurcationJob(
        oscillator=oscillator, vary=SweptParameter("damping", tuple(values)), direction=direction, transient=150, kept=8
    )  # fmt: skip
    parts = {}
    while (planned := plan(job, parts)).ready:
        for name, compute, arguments in planned.ready:
            parts[name] = compute(*arguments, pause=lambda: None)
    assert counted["together"] <= job.impacts_together * 1.1 <= 2 * counted["together"]
    assert counted["alone"] <= job.impacts - job.impacts_together <= 4 * counted["alone"]
    kept = sum(columns["time"].size for name, columns in parts.items() if name != "seeds")
    assert 17 * kept <= job.bytes <= 4 * 17 * kept
    # The search flies many at once; motions are followed one by one.
    monkeypatch.setattr(estimates, "measured_speed", lambda model, together: 30 * SPEED if together else SPEED)
    impacts = job.impacts_together / 30 + job.impacts - job.impacts_together
    assert estimate(job).seconds - estimates._OF_A_JOB == pytest.approx(impacts / SPEED)


@pytest.mark.parametrize(
    ("kind", "fields", "tasks"),
    [
        ("bifurcation", {"seeds": [{"time": 0.76, "velocity": 4.0}] * 3}, 3),
        ("bifurcation", {}, 4),
        ("orbits", {"seeds": [{"time": 0.6, "velocity": 3.77}]}, 1),
        ("manifold", {"saddles": [{"time": 0.6, "velocity": 3.77}], "side": "both"}, 4),
        ("grazing_curve", {}, 8),
    ],
)
def test_no_more_cores_are_counted_than_there_are_tasks_at_once(kind, fields, tasks):
    vary = {"vary": {"parameter": "damping", "start": 0.5, "stop": 0.6, "count": 1000}} if kind == "bifurcation" else {}
    job = KINDS[kind].job_class.from_request(fields | vary)
    seconds = {cores: estimate(job, cores).seconds - estimates._OF_A_JOB for cores in (1, tasks, 64)}
    assert seconds[64] == seconds[tasks] == pytest.approx(seconds[1] / tasks)


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


@pytest.mark.slow
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


def test_a_loose_gear_is_told_to_take_as_much_longer_as_its_flights_do():
    small = {"grid": {"time": {"cells": 20}, "velocity": {"cells": 20}}}
    below, beyond = (BasinJob.from_request(small | {"oscillator": {"eccentricity": eps}}) for eps in (0.1, 0.2))
    swept = SweepJob.from_request(small | {"vary": [{"parameter": "eccentricity", "values": [0.1, 0.2]}]})
    more = below.impacts * (9.0 / SPEED)
    # What naming takes beside is less than a hundredth.
    assert estimate(beyond).seconds - estimate(below).seconds == pytest.approx(more, rel=0.01)
    soft = {"model": "piecewise_linear", "stiffness": 1e4, "eccentricity": 0.2, "allow_no_quiet_solution": True}
    held = BasinJob.from_request(small | {"oscillator": soft})
    assert estimate(held).seconds - estimate(below).seconds == pytest.approx(below.impacts * (49.0 / SPEED), rel=0.01)
    # Of a sweep through the bound nobody counts which basins are loose: at most all are.
    assert estimate(swept).seconds > estimate(beyond).seconds

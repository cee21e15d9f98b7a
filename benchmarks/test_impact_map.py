"""Applications of P per second on the same departures: lanes, careful path, and plain yardsticks of both models."""

import numpy as np
import pytest

from benchmarks.accuracy import record
from benchmarks.paper_recipe import apply_recipe
from benchmarks.plain_newton import apply_plainly, plain_grazing_table
from benchmarks.suite.methods import plain_images
from benchmarks.suite.workloads import APPLICATIONS, Departures
from rattle_kernels import Oscillator, grazing_velocity, next_impacts, previous_impacts
from rattle_kernels.impact_map.apply import next_impact
from rattle_kernels.lanes.run import run_lanes
from rattle_kernels.numerics.jit import kernel

DAMPINGS = [Oscillator(), Oscillator(0.5, 0.1, 0.6), Oscillator(0.06, 0.01, 0.06), Oscillator(6e-4, 1e-4, 6e-4)]
STIFFNESSES = [1e2, 1e3, 1e4, 1e5, 1e6]


@kernel
def _scalar(oscillator, t, v, applications):
    done = 0
    for i in range(t.size):
        for _ in range(applications):
            impact = next_impact(oscillator, t[i], v[i])
            t[i], v[i] = impact.t, impact.v
            done += 1
            if not v[i] > 0.0:
                break
    return done


def _lane_impact(oscillator, t, v):
    return next_impacts(oscillator, t, v)[:2]


def _careful_impact(oscillator, t, v):
    t, v = np.array([t]), np.array([v])
    _scalar(oscillator, t, v, 1)
    return t[0], v[0]


def _plain_impact(oscillator, t, v):
    t, v = np.array([t]), np.array([v])
    table = plain_grazing_table(grazing_velocity, oscillator)
    apply_plainly(oscillator.damping, oscillator.eccentricity, oscillator.half_backlash, table, t, v, 1)
    return t[0], v[0]


@pytest.mark.parametrize("oscillator", DAMPINGS, ids=lambda o: f"damping-{o.damping:g}")
def test_lanes(benchmark, departures, oscillator):
    t, v = departures
    scale = float(np.max(grazing_velocity(oscillator, np.linspace(0.0, 1.0, 64)))) / 5.5
    benchmark(next_impacts, oscillator, t, v * scale, APPLICATIONS)
    record(benchmark, t.size * APPLICATIONS, _lane_impact)


@pytest.mark.parametrize("applications", [1, 10, 1000])
def test_lanes_by_applications(benchmark, departures, applications):
    t, v = (np.resize(array, 1_000_000 // applications) for array in departures)
    benchmark(next_impacts, Oscillator(), t, v, applications)
    record(benchmark, t.size * applications, _lane_impact)


@pytest.mark.parametrize("stiffness", STIFFNESSES, ids=lambda stiffness: f"stiffness-{stiffness:g}")
def test_stiff_lanes(benchmark, departures, stiffness):
    t, v = departures
    oscillator = Oscillator(stiffness=stiffness)
    _, run = run_lanes(oscillator, t, v, APPLICATIONS, shortcuts=False)
    benchmark(run_lanes, oscillator, t, v, APPLICATIONS, shortcuts=False)
    record(benchmark, run.applications, _lane_impact, table="map_pwl.json", category="uniform")
    benchmark.extra_info["careful_part"] = run.careful_flights / run.applications


def test_plain_newton(benchmark, departures):
    first = Departures(*(array[:2000] for array in departures))
    plain_images(first)
    benchmark(plain_images, first)
    record(benchmark, first.t.size * APPLICATIONS, _plain_impact)


@pytest.mark.parametrize("stiffness", STIFFNESSES, ids=lambda stiffness: f"stiffness-{stiffness:g}")
def test_the_papers_recipe(benchmark, departures, stiffness):
    t, v = (array[:1000] for array in departures)
    table = plain_grazing_table(grazing_velocity, Oscillator())
    done = apply_recipe(0.6, 0.1, 0.6, stiffness, table, t.copy(), v.copy(), APPLICATIONS)
    benchmark(lambda: apply_recipe(0.6, 0.1, 0.6, stiffness, table, t.copy(), v.copy(), APPLICATIONS))
    record(benchmark, done)


@pytest.mark.parametrize("oscillator", [Oscillator(), Oscillator(stiffness=1e4)], ids=["impacting", "stiffness-10000"])
def test_careful_scalar_path(benchmark, departures, oscillator):
    t, v = (array[:500] for array in departures)
    done = _scalar(oscillator, t.copy(), v.copy(), APPLICATIONS)
    benchmark(lambda: _scalar(oscillator, t.copy(), v.copy(), APPLICATIONS))
    record(benchmark, done, _careful_impact)


def test_backwards(benchmark, departures):
    t, v = (array[:5000] for array in departures)
    benchmark(previous_impacts, Oscillator(), t, v)
    record(benchmark, t.size)

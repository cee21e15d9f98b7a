"""Applications of P per second on the same departures: lanes, careful path, plain yardstick, a public integrator."""

import numpy as np
import pytest

from benchmarks.plain_newton import apply_plainly, plain_grazing_table
from rattle_kernels import Oscillator, grazing_velocity, next_impacts, previous_impacts
from rattle_kernels.impact_map import next_impact
from rattle_kernels.jit import kernel

OSCILLATORS = [Oscillator(), Oscillator(0.5, 0.1, 0.6), Oscillator(0.06, 0.01, 0.06), Oscillator(6e-4, 1e-4, 6e-4)]
LANE_APPLICATIONS = 100


@kernel
def _scalar(oscillator, t, v, applications):
    for i in range(t.size):
        for _ in range(applications):
            impact = next_impact(oscillator, t[i], v[i])
            t[i], v[i] = impact.t, impact.v


def record(benchmark, applications):
    """Put the rate beside the time."""
    benchmark.extra_info["applications"] = applications
    benchmark.extra_info["million_per_second"] = applications / benchmark.stats.stats.min / 1e6


@pytest.mark.parametrize("oscillator", OSCILLATORS, ids=lambda o: f"damping-{o.damping:g}")
def test_lanes(benchmark, departures, oscillator):
    t, v = departures
    scale = float(np.max(grazing_velocity(oscillator, np.linspace(0.0, 1.0, 64)))) / 5.5
    benchmark(next_impacts, oscillator, t, v * scale, LANE_APPLICATIONS)
    record(benchmark, t.size * LANE_APPLICATIONS)


def test_plain_newton(benchmark, departures):
    t, v = (array[:2000] for array in departures)
    table = plain_grazing_table(grazing_velocity, Oscillator())
    apply_plainly(0.6, 0.1, 0.6, table, t[:1].copy(), v[:1].copy(), 1)
    benchmark(lambda: apply_plainly(0.6, 0.1, 0.6, table, t.copy(), v.copy(), LANE_APPLICATIONS))
    record(benchmark, t.size * LANE_APPLICATIONS)


def test_careful_scalar_path(benchmark, departures):
    t, v = (array[:500] for array in departures)
    benchmark(lambda: _scalar(Oscillator(), t.copy(), v.copy(), LANE_APPLICATIONS))
    record(benchmark, t.size * LANE_APPLICATIONS)


def test_backwards(benchmark, departures):
    t, v = (array[:5000] for array in departures)
    benchmark(previous_impacts, Oscillator(), t, v)
    record(benchmark, t.size)


def test_scipys_integrator_with_events(benchmark, departures):
    integrated_impact = pytest.importorskip("tests.rattle_kernels.test_impact_map")._integrated_impact
    t, v = (array[:20] for array in departures)
    points = list(zip(t.tolist(), (v + 0.5).tolist(), strict=True))
    benchmark.pedantic(lambda: [integrated_impact(Oscillator(), *point) for point in points], rounds=3)
    record(benchmark, t.size)

"""Public integrators with events on the same departures, where they are installed: rate and accuracy of each.

heyoka is none of the project's dependencies: ``pip install heyoka`` into the environment adds it.
"""

import math

import pytest

from benchmarks.accuracy import record
from rattle_kernels import Oscillator
from tests.rattle_kernels.impact_map.test_apply import _integrated_impact


def test_scipys_dop853(benchmark, departures):
    t, v = (array[:20] for array in departures)
    points = list(zip(t.tolist(), (v + 0.5).tolist(), strict=True))
    benchmark.pedantic(lambda: [_integrated_impact(Oscillator(), *point) for point in points], rounds=3)
    record(benchmark, t.size, lambda *point: _integrated_impact(*point)[:2])


def _heyoka_impacts(heyoka):
    """Taylor integrator of Eqs. (4, 5); what follows a departure for so many returns to +beta."""
    damping, eccentricity, beta = heyoka.par[0], heyoka.par[1], heyoka.par[2]
    phi, rate = heyoka.make_vars("phi", "rate")
    angle = 2.0 * math.pi * heyoka.time
    forcing = 4.0 * math.pi**2 * heyoka.cos(angle) + 2.0 * math.pi * damping * heyoka.sin(angle)
    motion = [(phi, rate), (rate, 4.0 * math.pi * damping - eccentricity * forcing - damping * rate)]
    left = [0]

    def lower(integrator, *_):
        integrator.state[1] = -integrator.state[1]
        return True

    def upper(integrator, *_):
        integrator.state[1] = -integrator.state[1]
        left[0] -= 1
        return left[0] > 0

    events = [
        heyoka.t_event(phi - beta, callback=upper, direction=heyoka.event_direction.positive),
        heyoka.t_event(phi + beta, callback=lower, direction=heyoka.event_direction.negative),
    ]
    integrator = heyoka.taylor_adaptive(motion, [0.0, 0.0], pars=[0.6, 0.1, 0.6], t_events=events)

    def run(oscillator, t, v, returns=1):
        left[0] = returns
        integrator.reset_cooldowns()
        integrator.pars[:] = oscillator[:3]
        # A hair below the wall: of a root at the very start it takes the next one, if it is near, for the same.
        integrator.time, integrator.state[:] = t, [oscillator.half_backlash * (1.0 - 4e-16), -v]
        integrator.propagate_until(t + 1e4)
        return integrator.time, abs(integrator.state[1])

    return run


def test_heyokas_taylor_integrator(benchmark, departures):
    heyoka = pytest.importorskip("heyoka")
    t, v = (array[:200] for array in departures)
    points, returns = list(zip(t.tolist(), v.tolist(), strict=True)), 100
    run = _heyoka_impacts(heyoka)
    benchmark.pedantic(lambda: [run(Oscillator(), *point, returns) for point in points], rounds=3)
    record(benchmark, t.size * returns, run)

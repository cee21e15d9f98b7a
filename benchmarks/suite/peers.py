"""Other projects on the same work, where they are installed: scipy, heyoka and pynamicalsys.

heyoka and pynamicalsys are none of this project's dependencies: ``pip install heyoka pynamicalsys`` adds them.
"""

import math
from collections.abc import Callable
from functools import cache

import numba
import numpy as np

from benchmarks.plain_newton import apply_plainly, plain_grazing_table
from benchmarks.suite.methods import method
from benchmarks.suite.workloads import APPLICATIONS, OSCILLATOR, Departures, Panel, ends_of
from rattle.local import usable_cores
from rattle_kernels import grazing_velocity
from tests.rattle_kernels.impact_map.test_apply import _integrated_impact


@method("scipy DOP853", "applications", every=15625, needs=["scipy"])
def images_by_scipy(departures: Departures) -> np.ndarray:
    """Images by an integrator with events, called from Python."""
    images = np.stack(departures, axis=1)
    for image in images:
        for _ in range(APPLICATIONS):
            image[:] = _integrated_impact(OSCILLATOR, *image)[:2]
    return images


@cache
def _heyoka_impacts() -> Callable[[float, float, int], tuple[float, float]]:
    """Taylor integrator of Eqs. (4, 5): what follows a departure after so many returns to +beta."""
    import heyoka

    damping, eccentricity, beta = (heyoka.par[n] for n in range(3))
    angle = 2.0 * math.pi * heyoka.time
    phi, rate = heyoka.make_vars("phi", "rate")
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
    integrator = heyoka.taylor_adaptive(motion, [0.0, 0.0], pars=list(OSCILLATOR[:3]), t_events=events)

    def run(t: float, v: float, returns: int) -> tuple[float, float]:
        left[0] = returns
        integrator.reset_cooldowns()
        # A hair below the wall: of a root at the very start it takes the next one, if it is near, for the same.
        integrator.time, integrator.state[:] = t, [OSCILLATOR.half_backlash * (1.0 - 4e-16), -v]
        integrator.propagate_until(t + 1e4)
        return integrator.time % 1.0, abs(integrator.state[1])

    return run


def _by_heyoka(t: np.ndarray, v: np.ndarray, applications: int) -> Departures:
    run = _heyoka_impacts()
    return Departures(*np.array([run(*point, applications) for point in zip(t.tolist(), v.tolist(), strict=True)]).T)


@method("heyoka", "applications", every=125, needs=["heyoka"])
def images_by_heyoka(departures: Departures) -> np.ndarray:
    """Images by a Taylor integrator with events."""
    return np.stack(_by_heyoka(*departures, APPLICATIONS), axis=1)


@method("heyoka", "basin", every=125, needs=["heyoka"])
def ends_by_heyoka(panel: Panel) -> np.ndarray:
    """Ends by a Taylor integrator with events, all applications of every cell."""
    return ends_of(_by_heyoka, panel.centres).reshape(panel.speeds.size, -1)


@numba.njit(nogil=True)
def _plain_map(state, parameters):
    """P by the plain method, as pynamicalsys takes a map; the grazing curve is among the parameters."""
    t, v = state[:1].copy(), state[1:].copy()
    apply_plainly(parameters[0], parameters[1], parameters[2], parameters[3:], t, v, 1)
    return np.array([t[0], v[0]])


@cache
def _plain_system():
    from pynamicalsys import DiscreteDynamicalSystem

    parameters = [*OSCILLATOR[:3], *plain_grazing_table(grazing_velocity, OSCILLATOR)]
    return DiscreteDynamicalSystem(mapping=_plain_map, system_dimension=2, parameters=parameters)


def _by_pynamicalsys(t: np.ndarray, v: np.ndarray, applications: int) -> Departures:
    states = np.stack([t, v], axis=1)
    return Departures(*_plain_system().trajectory(states, applications, transient_time=applications - 1).T)


@method("pynamicalsys, all cores", "applications", every=25, cores=usable_cores(), needs=["pynamicalsys"])
def images_by_pynamicalsys(departures: Departures) -> np.ndarray:
    """Images by its ensembles of trajectories, of which only the last point is kept."""
    return np.stack(_by_pynamicalsys(*departures, APPLICATIONS), axis=1)


@method("pynamicalsys, all cores", "basin", every=25, cores=usable_cores(), needs=["pynamicalsys"])
def ends_by_pynamicalsys(panel: Panel) -> np.ndarray:
    """Ends by its ensembles of trajectories, all applications of every cell."""
    return ends_of(_by_pynamicalsys, panel.centres).reshape(panel.speeds.size, -1)

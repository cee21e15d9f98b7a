"""Bifurcation diagrams by pseudo-continuation: where a motion settles as one parameter is varied (Sec. 5.3, Fig. 11).

At each value of the parameter, P is applied many times until transients have died away. The last departures are kept,
and the very last one seeds the next value. So an attractor is followed until it disappears. What is reached then
depends on the direction: coexisting attractors show as two stretches of the diagram, one for each direction.

Permanent contact is a state like any other and is marked as such. It stays permanent while the quiet solution exists
(Eqs. 3, 8). Where that does not exist, the motion resumes from rest on the wall.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.adiabatic_invariant import capture_bound
from rattle_kernels.impact_map.apply import next_impact
from rattle_kernels.impact_map.chatter import is_captured
from rattle_kernels.model.bounds import eccentricity_bound_quiet
from rattle_kernels.model.departures import check_departures
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.flight import fall_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_PERMANENT_CONTACT, OUTCOME_RETURNED
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_kernels.numerics.phase import part_turn

# The paper keeps the last twenty impacts.
_KEPT = 20
_TRANSIENT = 1000
# Impacts between two pauses: milliseconds, but in the softest contacts most of a second.
_IMPACTS_A_LEG = 512
# Only low bounces are tested for capture: the bound costs milliseconds, at weak damping half a second.
_LOW_BOUNCE = 0.1
# Speed given to a motion at rest on the wall, relative to the fall through the backlash. Anything slower is rest.
_AT_REST = 1e-9
# A turn that closes to within this counts as periodic; speeds are relative to the fall through the backlash.
_CLOSED = 1e-7


class BifurcationDiagram(NamedTuple):
    """Last departures at each value of a parameter, in the order visited.

    Parameters
    ----------
    parameter : str
        Field of `Oscillator` that was varied.
    values : ndarray, shape (n,)
        Its values, in the order visited.
    t, v : ndarray, shape (n, seeds, kept)
        Phases and speeds of the last departures; NaN where contact is permanent.
    outcome : ndarray of int8, shape (n, seeds)
        `Outcome` codes: RETURNED, PERMANENT_CONTACT or NOT_CONVERGED.
    period : ndarray of int16, shape (n, seeds)
        Impact period of the departures kept; 0 if none is seen (longer, chaotic, or not yet settled).
    """

    parameter: str
    values: np.ndarray
    t: np.ndarray
    v: np.ndarray
    outcome: np.ndarray
    period: np.ndarray


class _Search(NamedTuple):
    """Brent's search for the turns of one motion: phase and speed now and at the mark; impacts now and at the mark."""

    points: np.ndarray
    counts: np.ndarray


@kernel
def _settle_leg(oscillator, search, transient):
    """Apply P for a leg, but not beyond `transient` impacts. Returns the outcome.

    A motion that returns to exactly the same numbers repeats itself, so whole turns of it are skipped: attracting
    orbits get there after some hundred impacts. The search is Brent's: the reference state moves on at powers of two.
    """
    t, v, marked_t, marked_v = search.points
    n, marked_at = search.counts
    outcome, left = OUTCOME_RETURNED, _IMPACTS_A_LEG
    while n < transient and left > 0:
        impact = next_impact(oscillator, t, v)
        if impact.outcome != OUTCOME_RETURNED:
            outcome = impact.outcome
            break
        t, v = impact.t, impact.v
        n += 1
        left -= 1
        if t == marked_t and v == marked_v:
            n = transient - (transient - n) % (n - marked_at)
        elif n >= 2 * marked_at:
            marked_t, marked_v, marked_at = t, v, n
    search.points[:] = t, v, marked_t, marked_v
    search.counts[:] = n, marked_at
    return outcome


@kernel
def _keep_leg(oscillator, t, v, times, speeds):
    """Keep every departure that follows one. Returns the outcome."""
    for n in range(times.size):
        impact = next_impact(oscillator, t, v)
        if impact.outcome != OUTCOME_RETURNED:
            return impact.outcome
        t, v = impact.t, impact.v
        times[n], speeds[n] = t, v
    return OUTCOME_RETURNED


def _follow(
    oscillator: Oscillator, t: float, v: float, transient: int, times: np.ndarray, speeds: np.ndarray, pause: Pause
) -> int:
    """Apply P `transient` times, then keep every departure. Returns the outcome."""
    search = _Search(np.array([t, v, t, v]), np.zeros(2, np.int64))
    while search.counts[0] < transient:
        pause()
        outcome = _settle_leg(oscillator, search, transient)
        if outcome != OUTCOME_RETURNED:
            return int(outcome)
    t, v = search.points[:2]
    for first in range(0, times.size, _IMPACTS_A_LEG):
        pause()
        leg = slice(first, first + _IMPACTS_A_LEG)
        outcome = _keep_leg(oscillator, t, v, times[leg], speeds[leg])
        if outcome != OUTCOME_RETURNED:
            return int(outcome)
        t, v = times[leg][-1], speeds[leg][-1]
    return OUTCOME_RETURNED


@kernel
def _impact_period(times, speeds, scale):
    """Shortest period after which the last departure repeats an earlier one; 0 if there is none."""
    last = times.size - 1
    for period in range(1, times.size // 2 + 1):
        apart = part_turn(times[last] - times[last - period])
        if math.hypot(apart, (speeds[last] - speeds[last - period]) / scale) < _CLOSED:
            return period
    return 0


def _find_captured(
    oscillator: Oscillator, t: np.ndarray, v: np.ndarray, outcome: np.ndarray, period: np.ndarray
) -> None:
    """Mark the motions of one value that are captured by ever lower bounces."""
    low = v[:, -1] <= _LOW_BOUNCE * fall_speed(oscillator)
    for j in np.flatnonzero(low & (outcome == OUTCOME_RETURNED) & (period == 0)):
        if is_captured(oscillator, capture_bound(oscillator), t[j, -1], v[j, -1]):
            outcome[j] = OUTCOME_PERMANENT_CONTACT


class Motions(NamedTuple):
    """Present state of several motions: departures, and whether contact is permanent; shape (seeds,)."""

    t: np.ndarray
    v: np.ndarray
    captured: np.ndarray

    @classmethod
    def from_seeds(cls, t: np.typing.ArrayLike, v: np.typing.ArrayLike) -> "Motions":
        """Motions that start from departures."""
        phase, speed = (np.array(a, dtype=np.float64).ravel() for a in np.broadcast_arrays(t, v))
        return cls(phase, speed, np.zeros(phase.size, np.bool_))


def _settle_at(
    oscillator: Oscillator, motions: Motions, transient: int, run: BifurcationDiagram, i: int, pause: Pause
) -> None:
    """Fill the rows of value number i. The motions move on to where they end."""
    scale = fall_speed(oscillator)
    quiet = oscillator.eccentricity < eccentricity_bound_quiet(oscillator)
    t, v, outcome, period = run.t[i], run.v[i], run.outcome[i], run.period[i]
    for j in range(motions.t.size):
        if motions.captured[j] and quiet:
            outcome[j] = OUTCOME_PERMANENT_CONTACT
            continue
        if motions.captured[j]:
            motions.t[j], motions.v[j] = 0.0, _AT_REST * scale
        outcome[j] = _follow(oscillator, motions.t[j], motions.v[j], transient, t[j], v[j], pause)
        if outcome[j] == OUTCOME_RETURNED:
            motions.t[j], motions.v[j] = t[j, -1], v[j, -1]
            period[j] = _impact_period(t[j], v[j], scale)
    _find_captured(oscillator, t, v, outcome, period)
    lost = outcome != OUTCOME_RETURNED
    t[lost], v[lost], period[lost] = np.nan, np.nan, 0
    motions.captured[:] = outcome == OUTCOME_PERMANENT_CONTACT


def follow_values(
    oscillator: Oscillator,
    parameter: str,
    values: np.ndarray,
    motions: Motions,
    transient: int,
    kept: int,
    *,
    pause: Pause = never_stopped,
) -> tuple[BifurcationDiagram, Motions]:
    """Follow motions from value to value, in the order given. The result is a stretch of a diagram.

    Parameters
    ----------
    oscillator, parameter, transient, kept
        As for `bifurcation_diagram`.
    values : ndarray, shape (n,)
        Values in the order of the visit.
    motions : Motions
        States to start from.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    (BifurcationDiagram, Motions)
        The stretch, and the states from which the next stretch may continue.

    Raises
    ------
    OutsideDomain
        If a value lies outside the domain of the map.
    """
    after = Motions(*(field.copy() for field in motions))
    shape = len(values), after.t.size
    run = BifurcationDiagram(
        parameter, np.array(values, np.float64), np.full((*shape, kept), np.nan), np.full((*shape, kept), np.nan),
        np.zeros(shape, np.int8), np.zeros(shape, np.int16),
    )  # fmt: skip
    for i, value in enumerate(run.values.tolist()):
        pause()
        _settle_at(check_oscillator(oscillator.at(**{parameter: value})), after, transient, run, i, pause)
    return run, after


def _check_numbers(values: np.ndarray, direction: str, transient: int, kept: int) -> None:
    if values.ndim != 1 or not values.size:
        raise ValueError("values must be a sequence of at least one number")
    if direction not in ("up", "down", "both"):
        raise ValueError(f"direction must be up, down or both, not {direction!r}")
    if transient < 0 or kept < 1:
        raise ValueError(f"transient must not be negative and kept be positive, not {transient} and {kept}")


def bifurcation_diagram(
    oscillator: Oscillator,
    parameter: str,
    values: np.typing.ArrayLike,
    t: np.typing.ArrayLike,
    v: np.typing.ArrayLike,
    *,
    direction: str = "up",
    transient: int = _TRANSIENT,
    kept: int = _KEPT,
) -> BifurcationDiagram:
    """Follow motions while one parameter varies. The last departure at each value seeds the next.

    Parameters
    ----------
    oscillator : Oscillator
        Either model. Its own value of the varied parameter does not matter.
    parameter : str
        One of `Oscillator.parameters`.
    values : array_like, shape (n,)
        Values to visit. They are sorted first.
    t, v : array_like, shape (seeds,)
        Departures to start from, such as one of each attractor known at the first value visited.
    direction : {"up", "down", "both"}
        ``both`` goes up and then down again from where that ends: 2 n rows.
    transient : int
        Applications of P at each value before any departure is kept.
    kept : int
        Departures kept at each value.

    Returns
    -------
    BifurcationDiagram

    Raises
    ------
    OutsideDomain
        If a value lies outside the domain of the map.
    ValueError
        If another argument is not valid.

    References
    ----------
    Sec. 5.3, Figs. 10 and 11.
    """
    visited = np.sort(np.asarray(values, dtype=np.float64))
    oscillator.value_of(parameter)  # raises where there is none
    _check_numbers(visited, direction, transient, kept)
    motions = Motions.from_seeds(*check_departures(t, v))
    runs = []
    for way in {"up": (1,), "down": (-1,), "both": (1, -1)}[direction]:
        run, motions = follow_values(oscillator, parameter, visited[::way], motions, transient, kept)
        runs.append(run)
    return BifurcationDiagram(
        parameter, *(np.concatenate(parts) for parts in zip(*(run[1:] for run in runs), strict=True))
    )

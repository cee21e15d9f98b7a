"""Tangencies: where a tip of an unstable manifold touches a stable one, and chaos begins to leak (impacting model).

An unstable manifold that crosses the grazing curve turns back: the image of the crossing is a corner, a tip. Chaos
reaches as far as its tips do. Where a parameter moves a tip across the stable manifold of a saddle that bounds a basin,
motions of the chaos begin to fall into that basin. The chaotic attractor is gone, and a transient is left: a boundary
crisis (Grebogi, Ott and Yorke), with a corner in the place of a parabola.

A departure close to a stable manifold follows it to the saddle. Let it be ``x`` from the saddle after n applications,
and l the left eigenvector of the saddle's multiplier outside the unit circle. Then ``l x`` tells on which side of the
manifold it passes, and ``l x/|l DP^n|`` is its distance from the manifold at the beginning, to first order in x.
Moved by that, it passes closer, and a few corrections lead onto the manifold. The sign is chosen so that a tip which
has not reached the manifold has a positive distance: the tip's arms, which lie on the chaos's side of it, say which
side that is. Where the two arms lie on different sides the manifolds cross in a corner and do not touch.
"""

import contextlib
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.jacobian import next_impact_with_jacobian
from rattle_kernels.impact_map.variations import Jacobian, multiply
from rattle_kernels.manifolds.polyline import goes_on
from rattle_kernels.manifolds.saddle import check_saddle, directions, is_saddle
from rattle_kernels.manifolds.stable_manifold import ManifoldEnd, ManifoldLimits, unstable_manifold
from rattle_kernels.model.domain import check_impacting
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_kernels.orbits.continuation import continue_orbit
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit, find_periodic_orbit

# So near to a saddle, in the plane (t, v/velocity_scale), its directions stand for its manifolds.
_NEAR = 0.05
# A tip that takes more turns of the saddle to come so near lies on far parts of its stable manifold.
_TURNS = 8
# Each correction of a distance leaves about 20 times `nearest` of its error.
_CORRECTIONS = 4
# Lengths of a branch, at first and at most, within which its tips are looked for.
_SHORTEST, _LONGEST = 0.125, 8.0
# At a zero of the distance nothing but rounding is left of it. Where the distance jumps, much is.
_ZERO = 1e-9
# A tangency is looked for so far from the one before, in units of where its slope says that it is.
_REACHES = 1.25, 2.0, 4.0
# The slope is taken over this part of the bounds.
_SLOPE = 1e-3


class NoTangency(ValueError):
    """There is no tangency between the bounds. The message says what was seen at them."""


class ManifoldTip(NamedTuple):
    """A corner of an unstable manifold: the image of a departure that grazes -beta, or an image of that.

    Parameters
    ----------
    point, side : int
        Of the branch, as in `ManifoldBranch`.
    corner : int
        Its number along the branch, from 0.
    t, v : float
        Phase and speed of the departure.
    arms : ndarray, shape (2, 2)
        Unit vectors (dt, dv/velocity_scale) from it along the manifold: back to the saddle, and onward.
    """

    point: int
    side: int
    corner: int
    t: float
    v: float
    arms: np.ndarray


class ManifoldGap(NamedTuple):
    """Between a tip and a stable manifold.

    Parameters
    ----------
    distance : float
        In the plane (t, v/velocity_scale); negative where the tip reaches beyond the manifold.
    impacts : int
        Applications of P that bring the tip closest to the saddle.
    nearest : float
        How close, in the same plane.
    """

    distance: float
    impacts: int
    nearest: float


class Tangency(NamedTuple):
    """A tip of one saddle's unstable manifold on another one's stable manifold.

    Parameters
    ----------
    parameter : str
    value : float
    oscillator : Oscillator
        With that value.
    unstable, stable : PeriodicOrbit
        The saddle whose unstable manifold has the tip, and the one whose stable manifold it touches.
    tip : ManifoldTip
    gap : ManifoldGap
        What is left of the distance.
    slope : float
        Change of the distance by the parameter. Beyond the tangency the tip reaches across where the parameter goes
        the other way.
    """

    parameter: str
    value: float
    oscillator: Oscillator
    unstable: PeriodicOrbit
    stable: PeriodicOrbit
    tip: ManifoldTip
    gap: ManifoldGap
    slope: float

    @property
    def exponent(self) -> float:
        """Power of the distance from the tangency with which the rate of leaving begins (docs/theory/crises.md).

        ``1 + ln|mu_u|/|ln|mu_s||`` with the multipliers of the saddle whose unstable manifold has the tip. Where that
        is the saddle whose stable manifold is touched, ``ln|mu_s|/ln|mu_s mu_u|``.
        """
        inner, outer = np.log(np.sort(np.abs(self.unstable.multipliers)))
        same = self.unstable.name == self.stable.name and np.allclose(self.unstable.v, self.stable.v)
        return float(inner / (inner + outer) if same else 1.0 - outer / inner)


@kernel
def _fly(oscillator, t, v, times, speeds, jacobians):
    """Departures after 0, 1, ... applications with their derivative by the first; not numbers once it is captured."""
    before = Jacobian(1.0, 0.0, 0.0, 1.0)
    for i in range(times.size):
        times[i], speeds[i] = t, v
        jacobians[i, 0, 0], jacobians[i, 0, 1] = before.tt, before.tv
        jacobians[i, 1, 0], jacobians[i, 1, 1] = before.vt, before.vv
        if math.isfinite(v):
            impact, one = next_impact_with_jacobian(oscillator, t, v)
            before = multiply(one, before)
            t, v = impact.t, impact.v


def manifold_tips(
    oscillator: Oscillator,
    saddle: PeriodicOrbit,
    corners: int = 1,
    only: tuple[int, int] | None = None,
    pause: Pause = never_stopped,
) -> tuple[ManifoldTip, ...]:
    """First tips of each branch of a saddle's unstable manifold.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model, below the bound of Eq. (8).
    saddle : PeriodicOrbit
        From `find_saddle`.
    corners : int
        How many of each branch.
    only : (int, int), optional
        Point and side of a single branch. All branches by default.
    pause : callable
        Called before every image of a branch. To stop the work, raise an exception there.

    Returns
    -------
    tuple of ManifoldTip
        Fewer where a branch ends before, or has none within its first 8 periods of length.

    Raises
    ------
    OutsideDomain, NotASaddle
        As for `unstable_manifold`.
    ValueError
        If the saddle has no such branch.
    """
    checked = check_impacting(oscillator)
    scale = largest_grazing_speed(checked)
    branches = [(point, side) for point in range(saddle.upper_contacts) for side in (1, -1)]
    if only is not None and only not in branches:
        raise ValueError(f"only must be a point of {saddle.name}, 0 to {saddle.upper_contacts - 1}, and +1 or -1")
    found = []
    for place in branches if only is None else [only]:
        length = _SHORTEST
        while True:
            (branch,) = unstable_manifold(checked, saddle, ManifoldLimits(arclength=length), only=place, pause=pause)
            if len(branch.pieces) > corners or branch.end != ManifoldEnd.ARCLENGTH or length >= _LONGEST:
                break
            length *= 2.0
        for number, (before, after) in enumerate(zip(branch.pieces[:corners], branch.pieces[1:], strict=False)):
            if not goes_on(before, after):
                break
            t, v = float(before.t[-1]), float(before.v[-1])
            away = np.array([
                [before.t[-2] - t, (before.v[-2] - v) / scale],
                [after.t[1] - after.t[0], (after.v[1] - v) / scale],
            ])  # fmt: skip
            found.append(ManifoldTip(*place, number, t, v, away / np.linalg.norm(away, axis=1)[:, None]))
    return tuple(found)


def manifold_gap(oscillator: Oscillator, tip: ManifoldTip, saddle: PeriodicOrbit) -> ManifoldGap | None:
    """Distance of a tip from the stable manifold of a saddle.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model, below the bound of Eq. (8).
    tip : ManifoldTip
        From `manifold_tips`.
    saddle : PeriodicOrbit
        From `find_saddle`.

    Returns
    -------
    ManifoldGap or None
        None if the tip does not come near the saddle within 8 of its turns, or if its arms lie on different sides of
        the stable manifold, so that the manifolds cross there.

    Raises
    ------
    OutsideDomain, NotASaddle
        As for `stable_manifold`.
    """
    checked, saddle = check_impacting(oscillator), check_saddle(saddle)
    scale = np.array([1.0, largest_grazing_speed(checked)])
    first = _passage(checked, np.array([tip.t, tip.v]), saddle, scale)
    if first is None:
        return None
    arms = first.gradient @ tip.arms.T
    if not arms[0] * arms[1] > 0.0:
        return None
    moved = first.step
    for _ in range(_CORRECTIONS):
        there = _passage(checked, np.array([tip.t, tip.v]) + moved * scale, saddle, scale)
        if there is None:
            return None
        moved = moved + there.step
    distance = math.copysign(float(np.linalg.norm(moved)), first.across * arms[0])
    return ManifoldGap(distance, first.impacts, first.nearest)


class _Passage(NamedTuple):
    """How a departure passes a saddle: on which side and how near, after how many applications, and what would hit."""

    across: float
    gradient: np.ndarray
    impacts: int
    nearest: float

    @property
    def step(self) -> np.ndarray:
        """To the stable manifold, to first order, in the plane (t, v/velocity_scale)."""
        return -self.across / float(self.gradient @ self.gradient) * self.gradient


def _passage(
    oscillator: Oscillator, departure: np.ndarray, saddle: PeriodicOrbit, scale: np.ndarray
) -> _Passage | None:
    period = saddle.upper_contacts
    size = (_TURNS + 1) * period
    t, v, jacobians = np.empty(size), np.empty(size), np.empty((size, 2, 2))
    _fly(oscillator, *departure.tolist(), t, v, jacobians)
    turns = t[:, None] - saddle.t
    apart = np.stack([turns - np.rint(turns), (v[:, None] - saddle.v) / scale[1]], axis=2)
    away = np.linalg.norm(apart, axis=2)
    arrived = np.flatnonzero((away < _NEAR).any(axis=1))
    if not arrived.size:
        return None
    at = int(arrived[0])
    point = int(np.nanargmin(away[at]))
    while at + period < size and away[at + period, point] < away[at, point]:
        at += period
    near = directions(saddle, point, float(scale[1]))
    left = np.linalg.inv(np.column_stack([near.unstable, near.stable]) / scale[:, None])[0]
    gradient = left @ (jacobians[at] * scale / scale[:, None])
    return _Passage(float(left @ apart[at, point]), gradient, at, float(away[at, point]))


def _saddles(
    oscillator: Oscillator, orbit: PeriodicOrbit, parameter: str, bounds: tuple[float, float], pause: Pause
) -> Callable[[float], PeriodicOrbit]:
    """The saddle at other values of a parameter, as far as its branch goes without turning back."""
    branch = continue_orbit(oscillator, orbit, parameter, (min(bounds), max(bounds)), pause=pause)
    turning = np.flatnonzero(np.diff(np.sign(np.diff(branch.values)))) + 1
    apart = branch.t[:, 0, None] - orbit.t
    near = np.abs(branch.values - oscillator.value_of(parameter)) + (
        np.abs(apart - np.rint(apart)) + np.abs(branch.v[:, 0, None] - orbit.v)
    ).min(axis=1)
    part = min(np.split(np.arange(branch.values.size), turning), key=lambda part: near[part].min())
    part = part[np.argsort(branch.values[part])]
    values, v = branch.values[part], branch.v[part, 0]
    t = np.unwrap(branch.t[part, 0], period=1.0)

    def at(value: float) -> PeriodicOrbit:
        here = oscillator.at(**{parameter: value})
        found = None
        if values[0] <= value <= values[-1]:
            seed = float(np.interp(value, values, t)), float(np.interp(value, values, v))
            found = find_periodic_orbit(here, *seed, orbit.upper_contacts, largest_grazing_speed(here), pause=pause)
        if found is None or found.name != orbit.name or not is_saddle(found):
            raise NoTangency(f"no saddle {orbit.name} was found at {parameter} = {value:.9g}: narrow the bounds")
        return found

    return at


def _tip(oscillator: Oscillator, saddle: PeriodicOrbit, like: ManifoldTip, pause: Pause) -> ManifoldTip:
    found = manifold_tips(oscillator, saddle, like.corner + 1, (like.point, like.side), pause)
    if len(found) <= like.corner:
        raise NoTangency(f"{saddle.name} has no such tip: its branch has {len(found)} near it")
    return found[like.corner]


def _gap(oscillator: Oscillator, tip: ManifoldTip, saddle: PeriodicOrbit) -> ManifoldGap:
    found = manifold_gap(oscillator, tip, saddle)
    if found is None:
        raise NoTangency(
            f"the tip at t = {tip.t % 1.0:.6f}, v = {tip.v:.6f} does not follow the stable manifold of {saddle.name} "
            "to it: take another tip or saddle"
        )
    return found


def find_tangency(
    oscillator: Oscillator,
    unstable: PeriodicOrbit,
    tip: ManifoldTip,
    stable: PeriodicOrbit,
    parameter: str,
    bounds: tuple[float, float],
    pause: Pause = never_stopped,
) -> Tangency:
    """Value of a parameter at which a tip of one saddle's unstable manifold touches another one's stable manifold.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model, below the bound of Eq. (8).
    unstable : PeriodicOrbit
        Saddle whose unstable manifold has the tip.
    tip : ManifoldTip
        From `manifold_tips`; that of the same branch and number is followed.
    stable : PeriodicOrbit
        Saddle whose stable manifold is touched; it may be the same one.
    parameter : str
        Name, one of ``oscillator.parameters``.
    bounds : (float, float)
        Values on both sides of the tangency, which hold that of the oscillator.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    Tangency
        Located between values at which the tip lies on different sides, to rounding.

    Raises
    ------
    OutsideDomain, NotASaddle
        As for `unstable_manifold`.
    NoTangency
        If the tip lies on the same side at both bounds, or one of the saddles or the tip is lost on the way.
    ValueError
        If the oscillator's value does not lie within the bounds.
    """
    from scipy.optimize import brentq  # a third of a second of imports, for those alone who look for a tangency

    checked = check_impacting(oscillator)
    rising = _saddles(checked, check_saddle(unstable), parameter, bounds, pause)
    meeting = _saddles(checked, check_saddle(stable), parameter, bounds, pause)

    def seen(value: float) -> tuple[PeriodicOrbit, PeriodicOrbit, ManifoldTip, ManifoldGap]:
        here = checked.at(**{parameter: value})
        one, other = rising(value), meeting(value)
        there = _tip(here, one, tip, pause)
        return one, other, there, _gap(here, there, other)

    def distance(value: float) -> float:
        return seen(value)[3].distance

    ends = [distance(bound) for bound in bounds]
    if ends[0] * ends[1] > 0.0:
        raise NoTangency(
            f"the tip lies on the same side at both bounds: {ends[0]:.3g} from the stable manifold at {parameter} = "
            f"{bounds[0]:.9g}, {ends[1]:.3g} at {bounds[1]:.9g}"
        )
    value = float(brentq(distance, *bounds, xtol=1e-15, rtol=4.0 * np.finfo(float).eps))
    one, other, there, gap = seen(value)
    if abs(gap.distance) > _ZERO:
        raise NoTangency(f"the distance jumps by {abs(gap.distance):.3g} at {parameter} = {value:.9g}")
    step = _SLOPE * abs(bounds[1] - bounds[0])
    low, high = max(min(bounds), value - step), min(max(bounds), value + step)
    slope = (distance(high) - distance(low)) / (high - low)
    return Tangency(parameter, value, checked.at(**{parameter: value}), one, other, there, gap, slope)


def follow_tangency(
    tangency: Tangency, parameter: str, values: np.typing.ArrayLike, pause: Pause = never_stopped
) -> tuple[Tangency, ...]:
    """Follow a tangency along a second parameter.

    Parameters
    ----------
    tangency : Tangency
        From `find_tangency`.
    parameter : str
        Name of the second parameter.
    values : array_like of float, shape (n,)
        Its values, in steps from that of the tangency on.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    tuple of Tangency, shape (n,)
        In ``tangency.parameter``, one at each value of the second parameter.

    Raises
    ------
    NoTangency
        Naming the first value at which it was not found. A smaller step may help, or it has ended.
    ValueError
        If the second parameter is the first.
    """
    first = tangency.parameter
    if parameter == first:
        raise ValueError(f"the second parameter must be another than the first, {first}")
    found: list[Tangency] = []
    last = tangency
    for value in np.asarray(values, np.float64).tolist():
        ends = last.oscillator.value_of(parameter), value
        if ends[0] == value:
            found.append(last)
            continue
        here = last.oscillator.at(**{parameter: value})
        try:
            unstable, stable = (
                _saddles(last.oscillator, orbit, parameter, ends, pause)(value)
                for orbit in (last.unstable, last.stable)
            )
            tip = _tip(here, unstable, last.tip, pause)
            beside = -_gap(here, tip, stable).distance / last.slope
            located = None
            for reach in _REACHES:
                bounds = sorted((last.value, last.value + reach * beside))
                with contextlib.suppress(NoTangency):
                    located = find_tangency(here, unstable, tip, stable, first, (bounds[0], bounds[1]), pause)
                    break
            if located is None:
                raise NoTangency(f"none lies within {_REACHES[-1] * beside:.3g} of {first} = {last.value:.9g}")
        except NoTangency as error:
            raise NoTangency(
                f"the tangency was lost at {parameter} = {value:.9g}, after {len(found)} values: {error}"
            ) from error
        last = located
        found.append(located)
    return tuple(found)

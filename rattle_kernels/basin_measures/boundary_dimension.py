"""Boundary dimension without a grid: how often two close departures end in different motions.

A pair of departures a distance e apart is *uncertain* if the two end in different motions. The share of such pairs
scales as the measure of the boundary's neighbourhood:

    f(e) ~ e^alpha,    alpha = 2 - d

with d the box dimension of the boundary. First points are uniform in a window of the (t, v) plane. Second points lie a
distance e away in a random direction. Every pair is drawn anew, so numbers of uncertain pairs are independent and
binomial. Their likelihood then gives alpha, its standard error, and how well a power law fits:

    k_i ~ Binomial(n_i, f_i),    ln f_i = c + alpha ln e_i

The error is that of the slope over the distances drawn, if a power law holds there. It is not what smaller distances
would give: stripes that thin out towards a curve, f ~ e ln(1/e), have a slope of 1 - 1/ln(1/e) at e. Their dimension is
1, and the slope grows as e shrinks.

Grebogi, McDonald, Ott and Yorke, Final state sensitivity: an obstruction to predictability, Phys. Lett. A 99, 415
(1983); McDonald, Grebogi, Ott and Yorke, Fractal basin boundaries, Physica D 17, 125 (1985).
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractors.attractor import Attractor
from rattle_kernels.attractors.attractor_search import find_attractors
from rattle_kernels.attractors.classify import UNASSIGNED, name_solutions
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.pausing import Pause, never_stopped

_DISTANCES = (1e-5, 3e-5, 1e-4, 3e-4, 1e-3)
_SEEDS = 4096
# Their ends are named in a second at most.
_PAIRS_AT_A_TIME = 1 << 17
_TOLERANCE = 1e-12
_MOST_STEPS = 200

Span = tuple[float, float]
Label = Callable[[np.ndarray, np.ndarray], np.ndarray]


class BoundaryDimension(NamedTuple):
    """Exponent alpha of the share of uncertain pairs with its standard error, how well it fits, and the data fitted.

    ``distance`` (float64) holds the distances e, parts of the window's sides. ``pairs`` (int64) are those at each
    distance of which both ends are known, ``uncertain`` (int64) those that end differently, ``undecided`` (int64)
    those left out because an end is not known. ``chi_square`` is Pearson's, with two ``degrees_of_freedom`` fewer than
    distances used. Exponent, error and chi square are NaN if fewer than three distances have uncertain pairs.
    """

    exponent: float
    error: float
    chi_square: float
    degrees_of_freedom: int
    distance: np.ndarray
    pairs: np.ndarray
    uncertain: np.ndarray
    undecided: np.ndarray

    @property
    def dimension(self) -> float:
        """Box dimension ``d = 2 - alpha`` of the boundary, with the same error."""
        return 2.0 - self.exponent

    @property
    def uncertain_share(self) -> np.ndarray:
        """Share f(e) of uncertain pairs at each distance; NaN where no pair is known."""
        return np.where(self.pairs > 0, self.uncertain / np.maximum(self.pairs, 1), np.nan)

    @property
    def share_error(self) -> np.ndarray:
        """Binomial standard error of each share, sqrt(f (1 - f)/n)."""
        share = self.uncertain_share
        return np.sqrt(share * (1.0 - share) / np.maximum(self.pairs, 1))

    @property
    def goodness_of_fit(self) -> float:
        """Probability of so large a chi square if a power law holds. If it is small, none does: alpha depends on e."""
        return _chi_square_beyond(self.chi_square, self.degrees_of_freedom)


def _chi_square_beyond(chi_square: float, degrees: int) -> float:
    """Probability that a chi square is larger, from Q(a + 1, x) = Q(a, x) + x^a exp(-x)/Gamma(a + 1)."""
    if math.isnan(chi_square):
        return math.nan
    x = 0.5 * chi_square
    a, beyond = (1.0, math.exp(-x)) if degrees % 2 == 0 else (0.5, math.erfc(math.sqrt(x)))
    while a < 0.5 * degrees:
        beyond += x**a * math.exp(-x) / math.gamma(a + 1.0)
        a += 1.0
    return beyond


def _likelihood(line: np.ndarray, pairs: np.ndarray, uncertain: np.ndarray) -> float:
    """Logarithm of the likelihood of shares exp(line), all below 1; it is concave in the line."""
    if (line >= 0.0).any():
        return -math.inf
    return float((uncertain * line + (pairs - uncertain) * np.log(-np.expm1(line))).sum())


def _most_likely(distance: np.ndarray, pairs: np.ndarray, uncertain: np.ndarray) -> tuple[float, float, float]:
    """Slope of ln f over ln e of the greatest likelihood, its standard error from Fisher's information, and chi square.

    Fisher's scoring, each step halved until it climbs: there is one summit, and shares stay below 1 on the way.
    """
    log = np.log(distance)
    design = np.column_stack([np.ones(log.size), log - log.mean()])
    line = np.array([math.log(uncertain.sum() / pairs.sum()), 0.0])
    height = _likelihood(design @ line, pairs, uncertain)
    for _ in range(_MOST_STEPS):
        share = np.exp(design @ line)
        information = design.T @ (design * (pairs * share / (1.0 - share))[:, None])
        step = np.linalg.solve(information, design.T @ ((uncertain - pairs * share) / (1.0 - share)))
        while (climbed := _likelihood(design @ (line + step), pairs, uncertain)) < height:
            step = 0.5 * step
        line, height = line + step, climbed
        if np.abs(step).max() < _TOLERANCE:
            break
    share = np.exp(design @ line)
    information = design.T @ (design * (pairs * share / (1.0 - share))[:, None])
    chi_square = ((uncertain - pairs * share) ** 2 / (pairs * share * (1.0 - share))).sum()
    return float(line[1]), math.sqrt(np.linalg.inv(information)[1, 1]), float(chi_square)


def _pairs(
    rng: np.random.Generator, time: Span, velocity: Span, distance: float, pairs: int
) -> tuple[np.ndarray, np.ndarray]:
    """Phases and speeds of random pairs, shape (2, pairs): uniform first, the second at a distance in any direction.

    Distances are parts of the window's sides. A second point without a positive speed is taken on the other side of
    the first.
    """
    period, height = time[1] - time[0], velocity[1] - velocity[0]
    # Draws lie in [0, 1): no first speed is 0.
    t, v = time[1] - period * rng.random(pairs), velocity[1] - height * rng.random(pairs)
    direction = 2.0 * np.pi * rng.random(pairs)
    dt, dv = distance * period * np.cos(direction), distance * height * np.sin(direction)
    side = np.where(v + dv > 0.0, 1.0, -1.0)
    return np.stack([t, t + side * dt]), np.stack([v, v + side * dv])


def _checked(
    time: Span, velocity: Span, distances: Sequence[float], pairs: int | Sequence[int]
) -> tuple[np.ndarray, np.ndarray]:
    """Distances in ascending order, and the number of pairs at each; raise if an argument is not valid."""
    distance = np.asarray(distances, np.float64)
    if np.unique(distance).size != distance.size or distance.size < 3 or not ((distance > 0) & (distance <= 0.5)).all():
        raise ValueError(f"distances must be three or more different ones above 0 and up to 0.5, not {distances}")
    if not (math.isfinite(time[0]) and time[0] < time[1] <= time[0] + 1.0):
        raise ValueError(f"time must go from one phase to a later one, at most a period on, not {time}")
    if not 0.0 <= velocity[0] < velocity[1] < math.inf:
        raise ValueError(f"velocity must go from 0 or more to a larger finite speed, not {velocity}")
    number = np.asarray(pairs)
    if number.shape not in ((), distance.shape) or number.dtype.kind not in "iu" or not (number > 0).all():
        raise ValueError(f"pairs must be a whole number above 0, or one for each of the distances, not {pairs}")
    order = np.argsort(distance)
    return distance[order], np.broadcast_to(number, distance.shape)[order]


def exponent_of_labels(
    label: Label,
    time: Span,
    velocity: Span,
    distances: Sequence[float],
    pairs: int | Sequence[int],
    seed: int,
) -> BoundaryDimension:
    """As `boundary_dimension`, for any labelling of the plane.

    Parameters
    ----------
    label : callable
        Takes phases and speeds of shape (n,), returns an integer for each, UNASSIGNED where it is not known.
    time, velocity, distances, pairs, seed
        As there.

    Returns
    -------
    BoundaryDimension
    """
    distance, number = _checked(time, velocity, distances, pairs)
    counts = np.zeros((3, distance.size), np.int64)
    for place, rng in enumerate(np.random.default_rng(seed).spawn(distance.size)):
        for start in range(0, number[place], _PAIRS_AT_A_TIME):
            some = min(_PAIRS_AT_A_TIME, int(number[place]) - start)
            t, v = _pairs(rng, time, velocity, float(distance[place]), some)
            ends = np.reshape(label(t.ravel(), v.ravel()), (2, some))
            known = (ends != UNASSIGNED).all(axis=0)
            counts[:, place] += known.sum(), (known & (ends[0] != ends[1])).sum(), (~known).sum()
    known, uncertain, undecided = counts
    used = known > 0
    if (used & (uncertain == known)).any():
        raise ValueError(
            f"at some distance all pairs end differently: take more pairs, or smaller ones than {distances}"
        )
    enough = (uncertain > 0).sum() >= 3
    fit = _most_likely(distance[used], known[used], uncertain[used]) if enough else (math.nan, math.nan, math.nan)
    return BoundaryDimension(*fit, max(int(used.sum()) - 2, 0), distance, known, uncertain, undecided)


def boundary_dimension(
    oscillator: Oscillator,
    *,
    time: Span = (0.0, 1.0),
    velocity: Span = (0.0, 7.0),
    distances: Sequence[float] = _DISTANCES,
    pairs: int | Sequence[int] = 200_000,
    attractors: Sequence[Attractor] | None = None,
    seed: int = 0,
    pause: Pause = never_stopped,
) -> BoundaryDimension:
    """Uncertainty exponent and dimension of the boundaries between all basins, from random pairs of departures.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    time, velocity : (float, float)
        The window of first departures: forcing periods, at most one, and speeds.
    distances : sequence of float
        Distances e between the two departures of a pair, as parts of the window's sides: three or more. Take them over
        several decades.
    pairs : int or sequence of int
        Number of pairs at each distance. Smaller distances need more: the relative error of a share f is
        ``sqrt((1 - f)/(f n))``.
    attractors : sequence of Attractor, optional
        Catalogue that names the ends. Without it, one is found from 4096 random departures of the window.
    seed : int
        Of the random numbers; another seed gives independent pairs.
    pause : callable
        Called several times a second; an exception raised there ends the measurement.

    Returns
    -------
    BoundaryDimension
        Pairs with an end outside the catalogue are left out and counted as ``undecided``.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    ValueError
        If an argument is not valid, or all pairs of a distance end differently.

    Notes
    -----
    ``f(e) ~ e^alpha`` and ``d = 2 - alpha`` (Grebogi et al., 1983; McDonald et al., 1985). Alpha maximizes the binomial
    likelihood of the numbers of uncertain pairs, so distances without any count, too. Its standard error is from
    Fisher's information: it covers the slope if a power law holds over the distances. ``goodness_of_fit`` says whether
    one does.

    Examples
    --------
    >>> found = boundary_dimension(Oscillator(), distances=(1e-4, 1e-3, 1e-2), pairs=20_000)
    >>> print(f"{found.uncertain_share[-1]:.2f}, {found.exponent:.1f}")
    0.07, 0.8
    """
    checked = check_oscillator(oscillator)
    _checked(time, velocity, distances, pairs)
    if attractors is None:
        seeds_t, seeds_v = _pairs(np.random.default_rng([seed, 1]), time, velocity, 0.0, _SEEDS)
        attractors = find_attractors(checked, seeds_t[0], seeds_v[0], pause=pause)
    catalogue = attractors

    def label(t: np.ndarray, v: np.ndarray) -> np.ndarray:
        return name_solutions(checked, catalogue, t, v, pause)

    return exponent_of_labels(label, time, velocity, distances, pairs, seed)

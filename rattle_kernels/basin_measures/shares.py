"""Shares of motions among departures of one's own, of any distribution.

A sample of a window asks how likely each motion is if every departure is equally likely. A machine may be disturbed
otherwise. Departures drawn from its own distribution, or from any other with weights, give the shares of that instead:

    s_j = sum_i w_i [departure i ends in motion j] / sum_i w_i

For independent departures the standard error follows from the scatter of the terms of this ratio (the delta method):

    error_j^2 = sum_i w_i^2 ([departure i ends in motion j] - s_j)^2 / (sum_i w_i)^2

With equal weights it is the binomial law's, s (1 - s)/n.

Owen, Monte Carlo theory, methods and examples (2013), chapter 9.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractors.attractor import Attractor, AttractorKind, with_undecided
from rattle_kernels.attractors.attractor_search import find_attractors
from rattle_kernels.attractors.classify import UNASSIGNED, name_solutions
from rattle_kernels.model.departures import check_departures
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.pausing import Pause, never_stopped

_SEEDS = 4096


class Shares(NamedTuple):
    """Motions that departures end in, and the share of each with its standard error.

    ``attractors`` is the catalogue: permanent contact first, and a motion of kind UNDECIDED last if some departures
    arrive nowhere. ``solution`` (int16, one for each departure) is the place of its motion there. ``share`` and
    ``error`` (float64) are one for each motion. ``effective_size`` is ``(sum w)^2/sum w^2``: so many departures of
    equal weight scatter as much.
    """

    attractors: tuple[Attractor, ...]
    solution: np.ndarray
    share: np.ndarray
    error: np.ndarray
    effective_size: float


def weighted_shares(solution: np.ndarray, weights: np.ndarray, motions: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Shares of motions, their standard errors, and the effective size.

    Parameters
    ----------
    solution : ndarray of int, shape (n,)
        Motion of each departure.
    weights : ndarray of float64, shape (n,)
        Not negative, not all 0.
    motions : int
        How many there are.

    Returns
    -------
    share, error : ndarray of float64, shape (motions,)
    effective_size : float
    """
    part = weights / weights.max()
    part /= part.sum()
    share = np.bincount(solution, part, motions)
    square = np.bincount(solution, part**2, motions)
    total = square.sum()
    size = float(1.0 / total)
    variance = square * (1.0 - share) ** 2 + (total - square) * share**2
    # Where all departures of any weight agree, their scatter says nothing. Laplace's rule of succession does.
    likely = (size * share + 1.0) / (size + 2.0)
    agree = np.minimum(square, total - square) <= 1e-15 * total
    variance = np.where(agree, likely * (1.0 - likely) / (size + 3.0), variance)
    return share, np.sqrt(variance), size


def _checked_weights(weights: np.typing.ArrayLike | None, shape: tuple[int, ...]) -> np.ndarray:
    if weights is None:
        return np.ones(shape)
    array = np.asarray(weights, np.float64)
    if array.shape != shape:
        raise ValueError(f"weights must be one for each departure, of shape {shape}, not {array.shape}")
    if not (np.isfinite(array) & (array >= 0.0)).all() or not array.any():
        raise ValueError("weights must be finite and not negative, and one at least above 0")
    return array


def shares_of(
    oscillator: Oscillator,
    t: np.typing.ArrayLike,
    v: np.typing.ArrayLike,
    weights: np.typing.ArrayLike | None = None,
    *,
    attractors: Sequence[Attractor] | None = None,
    pause: Pause = never_stopped,
) -> Shares:
    """Motions that given departures end in, and the share of each.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    t, v : array_like, shape (n,)
        Departures from +beta: phases in forcing periods, and positive speeds.
    weights : array_like, shape (n,), optional
        Weight of each departure, such as the density wanted over the density drawn from. All equal if left out.
    attractors : sequence of Attractor, optional
        Catalogue that names the ends. Without it, one is found from the departures themselves.
    pause : callable
        Called several times a second; an exception raised there ends the search.

    Returns
    -------
    Shares
        Its errors are those of independent departures.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    ValueError
        If a point is no departure, there is none, or the weights do not fit.

    Examples
    --------
    Disturbances in the phase of the saddle P(1,1,0), with speeds about 3 that scatter by 0.5:

    >>> import numpy as np
    >>> rng = np.random.default_rng(0)
    >>> found = shares_of(Oscillator(), np.full(2000, 0.6), np.abs(rng.normal(3.0, 0.5, 2000)))
    >>> print(found.attractors[0].name, f"{found.share[0]:.2f} +- {found.error[0]:.2f}")
    permanent contact 0.94 +- 0.01
    """
    checked = check_oscillator(oscillator)
    times, speeds = check_departures(t, v)
    if times.ndim != 1 or times.shape != speeds.shape or not times.size:
        raise ValueError(f"t and v must be lists of the same length, 1 or more, not {times.shape} and {speeds.shape}")
    weight = _checked_weights(weights, times.shape)
    catalogue = tuple(attractors or ())
    if attractors is None:
        every = math.ceil(times.size / _SEEDS)
        catalogue = find_attractors(checked, times[::every], speeds[::every], pause=pause)
    solution = name_solutions(checked, catalogue, times, speeds, pause)
    lost = solution == UNASSIGNED
    if attractors is None and lost.any():
        catalogue = find_attractors(checked, times[lost], speeds[lost], known=catalogue, pause=pause)
        solution = name_solutions(checked, catalogue, times, speeds, pause)
        lost = solution == UNASSIGNED
    if lost.any():
        catalogue = with_undecided(catalogue)
        solution[lost] = [attractor.kind for attractor in catalogue].index(AttractorKind.UNDECIDED)
    return Shares(catalogue, solution, *weighted_shares(solution, weight, len(catalogue)))

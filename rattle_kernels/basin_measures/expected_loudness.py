"""How loud a machine is on average over a window of departures: the loudness of each motion, weighted by its share."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractors.loudness import Loudness


class ExpectedLoudness(NamedTuple):
    """Means over a window of departures, with standard errors, and the share of those whose motion is not decided.

    Undecided departures count as silent, and never in contact. So each mean is a lower bound where ``undecided_share``
    is not 0.
    """

    impacts_per_period: float
    largest_impact_speed: float
    impact_power: float
    time_in_contact: float
    impacts_per_period_error: float
    largest_impact_speed_error: float
    impact_power_error: float
    time_in_contact_error: float
    undecided_share: float


def expected_loudness(
    shares: np.typing.ArrayLike,
    motions: Sequence[Loudness],
    points: int | None = None,
    shares_of_sets: np.typing.ArrayLike | None = None,
) -> ExpectedLoudness:
    """Mean loudness of a basin picture.

    Parameters
    ----------
    shares : array_like, shape (motions,)
        Share of each motion; NaN where the basin has no such motion.
    motions : sequence of Loudness
        From `loudness`.
    points : int, optional
        Number of independent points from which the shares are known, if they are of a sample.
    shares_of_sets : array_like, shape (sets, motions), optional
        Shares in each of the sample's scrambled sets, two or more of the same size: they measure the error.

    Returns
    -------
    ExpectedLoudness
        Errors come from those of chaotic motions. Those of a sample come from its shares, too: from what these may be
        once so many points are known (Laplace's rule of succession, for as many motions as there are). Of several sets
        it is the standard error of the mean of their expectations; where all agree, their scatter says nothing, and
        Laplace's stays. NaN where no share is known.

    Examples
    --------
    >>> quiet, loud = Loudness(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0), Loudness(1.0, 3.0, 4.5, 0.0, 0.0, 0.0, 0.0)
    >>> expected_loudness([0.75, 0.25], [quiet, loud]).impact_power
    1.125
    """
    share = np.asarray(shares, np.float64)
    there = np.isfinite(share)
    if not there.any():
        return ExpectedLoudness._make([np.nan] * len(ExpectedLoudness._fields))
    share, heard = share[there], np.reshape(motions, (-1, len(Loudness._fields)))[there]
    known = np.isfinite(heard[:, 0])
    # Four means; the second, the largest speed, has no error of its own.
    severity, own_error = np.where(known[:, None], heard[:, :4], 0.0), np.zeros((len(heard), 4))
    own_error[:, [0, 2, 3]] = np.nan_to_num(heard[:, 4:])
    square = (share**2) @ own_error**2
    if points is not None:
        likely = (share * points + 1.0) / (points + share.size)
        # Of motions that are all alike it is nothing, but for rounding.
        variance = np.maximum(likely @ severity**2 - (likely @ severity) ** 2, 0.0) / (points + share.size + 1.0)
        if shares_of_sets is not None:
            expected = np.asarray(shares_of_sets, np.float64)[:, there] @ severity
            scatter = expected.var(axis=0, ddof=1) / len(expected)
            variance = np.where(np.ptp(expected, axis=0) > 0.0, scatter, variance)
        square += variance
    return ExpectedLoudness._make([*(share @ severity).tolist(), *np.sqrt(square).tolist(), float(share[~known].sum())])

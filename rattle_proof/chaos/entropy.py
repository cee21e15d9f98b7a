"""A lower bound of the topological entropy, from which strips cross which.

Each strip has a number of impacts after which its image crosses strips: then so many words of strips are followed by
paths, and so many departures are told apart. If ``sum of x over the strips that strip i crosses >= growth^k(i) x(i)``
for numbers x >= 0 that are not all 0, the entropy is log(growth) at least (theorem 5 of `docs/theory/proof.md`).
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_proof.chaos.crossings import Crossings

_BITS = 20
_ROUNDS, _HALVINGS = 400, 40


class Growth(NamedTuple):
    """How many times as many words there are with each impact, at least: a fraction; and what shows it.

    ``impacts`` and ``weights``, of shape (strips,), are after how many impacts each strip is looked at, and x.
    """

    numerator: int
    bits: int
    impacts: np.ndarray
    weights: np.ndarray

    @property
    def entropy(self) -> float:
        """Its logarithm, rounded down: a bound of the topological entropy for an impact, in nats."""
        # The library's logarithm is off by far less.
        return math.log(self.numerator / 2**self.bits) - 1e-12


def _sums(crossings: Crossings, weights: np.ndarray) -> np.ndarray:
    """Sum of the weights over what each strip crosses, by impacts."""
    upto = np.concatenate([np.zeros(1, weights.dtype), np.cumsum(weights)])
    return upto[crossings.last] - upto[crossings.first]


def _settled(crossings: Crossings, growth: float) -> tuple[float, np.ndarray, np.ndarray]:
    """By how much the weights grow in one step if words are counted with a weight of growth^-impacts, and these."""
    strips, impacts = crossings.first.shape
    shrunk = growth ** -np.arange(1.0, impacts + 1.0)
    weights, rate = np.ones(strips), 0.0
    chosen = np.zeros(strips, np.int64)
    for _ in range(_ROUNDS):
        sums = _sums(crossings, weights) * shrunk
        chosen = sums.argmax(axis=1)
        new = sums[np.arange(strips), chosen]
        rate = float(new.max())
        if rate == 0.0:
            break
        weights = new / rate
    return rate, chosen, weights


def growth_of(crossings: Crossings) -> Growth | None:
    """The largest growth that is found.

    Parameters
    ----------
    crossings : Crossings

    Returns
    -------
    Growth or None
        None if it is not above 1.
    """
    least, most = 1.0, 4.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (least + most)
        if _settled(crossings, middle)[0] > 1.0:
            least = middle
        else:
            most = middle
    _, chosen, weights = _settled(crossings, least)
    whole = np.floor(weights * 2.0**30).astype(np.int64)
    numerator = math.floor(least * 2**_BITS)
    while (numerator := numerator - 1) > 2**_BITS:
        found = Growth(numerator, _BITS, chosen + 1, whole)
        if holds(crossings, found):
            return found
    return None


def holds(crossings: Crossings, growth: Growth) -> bool:
    """Whether a growth is shown by its weights, in whole numbers.

    Parameters
    ----------
    crossings : Crossings
    growth : Growth

    Returns
    -------
    bool
    """
    weights = growth.weights.astype(object)
    if not (weights >= 0).all() or not weights.any():
        return False
    strips = np.arange(len(weights))
    crossed = _sums(crossings, weights)[strips, growth.impacts - 1]
    return all(
        int(sum_) << (growth.bits * int(k)) >= growth.numerator ** int(k) * int(x)
        for sum_, k, x in zip(crossed, growth.impacts, weights, strict=True)
    )

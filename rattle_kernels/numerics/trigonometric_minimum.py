"""The least value of a trigonometric polynomial, and its changes of sign: to rounding, and for sure.

*Least value.* On an interval of length h between two samples the polynomial lies above their chord less M h^2/8, M a
bound on its second derivative. So intervals that cannot hold a value below the least sample are dropped, and the others
are halved. Near the minimum only few are left each time.

*Changes of sign.* On an interval of length h the polynomial differs from its value in the middle by M' h/2 at most, M'
a bound on its first derivative, and its slope by M h/2. So an interval has no zero, or the polynomial is monotone there
and the ends tell, or it is halved. Only at a double zero this would not end: there it does once M h^2/8 is rounding.
"""

import math
from typing import NamedTuple

import numpy as np

TWO_PI = 2.0 * math.pi
# Samples of the first mesh for a period of the highest order.
_A_PERIOD = 16
_ROUNDING = 1e-14
_HALVINGS = 60
# Parts of an interval at which its sign is looked at: a double zero may lie at one of them.
_INSIDE = np.array([0.25, 0.5, 0.7])


class TrigonometricPolynomial(NamedTuple):
    """``mean + sum cosine cos(2 pi order t) + sine sin(2 pi order t)``; arrays of one shape (n,)."""

    mean: float
    order: np.ndarray
    cosine: np.ndarray
    sine: np.ndarray

    def at(self, t: np.ndarray) -> np.ndarray:
        """Values at some times, shape of `t`."""
        angle = TWO_PI * np.multiply.outer(t, self.order)
        return np.asarray(self.mean + np.cos(angle) @ self.cosine + np.sin(angle) @ self.sine)

    @property
    def slope(self) -> "TrigonometricPolynomial":
        """The derivative by t."""
        rate = TWO_PI * self.order
        return TrigonometricPolynomial(0.0, self.order, rate * self.sine, -rate * self.cosine)

    @property
    def bend(self) -> float:
        """Bound on the second derivative by t."""
        return float(((TWO_PI * self.order) ** 2 * np.hypot(self.cosine, self.sine)).sum())

    @property
    def size(self) -> float:
        """Bound on the absolute value."""
        return float(abs(self.mean) + np.hypot(self.cosine, self.sine).sum())


def least_value(polynomial: TrigonometricPolynomial) -> tuple[float, float]:
    """Least value over a period, and where it is taken.

    Parameters
    ----------
    polynomial : TrigonometricPolynomial
        Of period 1: orders are whole numbers.

    Returns
    -------
    (float, float)
        The least value, too large by at most 1e-14 of the polynomial's size, and its phase in [0, 1). It is NaN where
        values overflow.
    """
    highest = float(polynomial.order.max(initial=1.0))
    step = 1.0 / (_A_PERIOD * highest)
    begin = np.arange(round(1.0 / step)) * step
    tolerance = _ROUNDING * polynomial.size
    while True:
        low, high = polynomial.at(begin), polynomial.at(begin + step)
        least = min(low.min(), high.min())
        sag = polynomial.bend * step * step / 8.0
        if not (math.isfinite(least) and math.isfinite(sag)):
            return math.nan, 0.0
        if sag <= tolerance:
            place = int(low.argmin())
            return float(least), float(begin[place] % 1.0)
        open_ = np.minimum(low, high) - sag < least
        step *= 0.5
        begin = np.concatenate([begin[open_], begin[open_] + step])


def changes_of_sign(polynomial: TrigonometricPolynomial) -> np.ndarray:
    """Phases at which a polynomial changes its sign.

    Parameters
    ----------
    polynomial : TrigonometricPolynomial
        Of period 1, with finite values.

    Returns
    -------
    ndarray of float64, shape (n,)
        In [0, 1), ascending; an even number, at most twice the highest order. Two that rounding cannot tell from a
        double zero may be missing.
    """
    slope, rounding = polynomial.slope, _ROUNDING * polynomial.size
    # Powers of two: the ends of neighbouring intervals are the same numbers, and so are 0 and 1 once they are wrapped.
    step = 0.5 ** math.ceil(math.log2(_A_PERIOD * float(polynomial.order.max(initial=1.0))))
    begin, brackets = np.arange(round(1.0 / step)) * step, [np.empty((0, 2))]
    while begin.size:
        middle = begin + 0.5 * step
        open_ = np.abs(polynomial.at(middle)) <= 0.5 * slope.size * step + rounding
        begin, middle = begin[open_], middle[open_]
        known = np.abs(slope.at(middle)) > 0.5 * polynomial.bend * step + _ROUNDING * slope.size
        known |= polynomial.bend * step * step / 8.0 <= rounding
        ends = np.stack([begin[known], begin[known] + step], axis=1)
        positive = polynomial.at(ends % 1.0) > 0.0
        brackets.append(ends[positive[:, 0] != positive[:, 1]])
        step *= 0.5
        begin = np.concatenate([begin[~known], begin[~known] + step])
    found, times = np.unique(_bisected(polynomial, np.concatenate(brackets)) % 1.0, return_counts=True)
    found = found[times % 2 == 1]
    # Rounding at the end of an interval may count a zero twice, or one half of a pair: signs between them decide, each
    # where it is clearest.
    inside = polynomial.at(found[:, None] + np.diff(found, append=found[:1] + 1.0)[:, None] * _INSIDE)
    between = inside[np.arange(found.size), np.abs(inside).argmax(axis=1)] > 0.0
    return found[between != np.roll(between, 1)]


def _bisected(polynomial: TrigonometricPolynomial, brackets: np.ndarray) -> np.ndarray:
    """The one change of sign in each bracket (rows of two ends), halved down to neighbouring numbers."""
    low, high = brackets.T
    rises = polynomial.at(high % 1.0) > 0.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        beyond = (polynomial.at(middle) > 0.0) == rises
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    return np.asarray(high)

"""The least value of a trigonometric polynomial, to rounding and for sure.

On an interval of length h between two samples the polynomial lies above their chord less M h^2/8, M a bound on its
second derivative. So intervals that cannot hold a value below the least sample are dropped, and the others are halved.
Near the minimum only few are left each time.
"""

import math
from typing import NamedTuple

import numpy as np

TWO_PI = 2.0 * math.pi
# Samples of the first mesh for a period of the highest order.
_A_PERIOD = 16
_ROUNDING = 1e-14


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

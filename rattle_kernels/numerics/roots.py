"""One root-finder: Newton's method kept inside a bracket.

Every caller makes sure of its bracket (exactly one sign change between the two ends) and says so where it builds it.
Where a Newton step leaves the bracket, bisection replaces it. So the root is found from any guess, and in a few steps
from a good one.
"""

from rattle_kernels.numerics.jit import inlined

_NEWTON_STEPS = 60
# Some 60 + 11 halvings lead from any bracket of doubles to neighbouring numbers; the rest is margin.
_ALL_STEPS = 160
_ROUNDING = 4.5e-16


def root_finder(residual):
    """Build the compiled root-finder of one residual.

    This is a factory because Numba does not cache kernels that take compiled functions as arguments.

    Parameters
    ----------
    residual : compiled function
        ``residual(problem, x)`` returns the value and the slope at x.

    Returns
    -------
    compiled function
        ``find_root(problem, negative, positive, guess)`` returns the root and whether it was found to rounding. The
        residual is < 0 at `negative` and > 0 at `positive`, the ends of the bracket in either order.
    """

    @inlined
    def find_root(problem, negative, positive, guess):
        x = guess
        if not (min(negative, positive) < x < max(negative, positive)):
            x = 0.5 * (negative + positive)
        for iteration in range(_ALL_STEPS):
            value, slope = residual(problem, x)
            if value < 0.0:
                negative = x
            else:
                positive = x
            next_x = x - value / slope
            inside = min(negative, positive) <= next_x <= max(negative, positive)
            # Past the Newton steps only rounding can be the obstacle (a nearly double root): halve until the ends meet.
            if not inside or iteration >= _NEWTON_STEPS:
                next_x = 0.5 * (negative + positive)
            if abs(next_x - x) <= _ROUNDING * abs(next_x):
                return next_x, True
            x = next_x
        return x, False

    return find_root

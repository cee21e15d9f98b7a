"""One root-finder: Newton's method kept inside a bracket.

Every caller proves its bracket (exactly one sign change between the two ends) and says so where it builds it. Newton's
steps that leave the bracket are replaced by bisection; so the root is found whatever the guess, and in a few steps
where the guess is good.
"""

from rattle_kernels.numerics.jit import inlined

_NEWTON_STEPS = 60
# From any bracket of doubles, some 60 + 11 halvings reach neighbouring numbers; the rest is margin.
_ALL_STEPS = 160
_ROUNDING = 4.5e-16


def root_finder(residual):
    """Build the compiled root-finder of one residual.

    A factory rather than a function argument: Numba does not cache kernels into which compiled functions are passed.

    Parameters
    ----------
    residual : compiled function
        ``residual(problem, x)`` returns the value and the slope at x.

    Returns
    -------
    compiled function
        ``find_root(problem, negative, positive, guess)`` returns the root between `negative` (where the residual is <
        0) and `positive` (where it is > 0), ends of a bracket in either order, and whether it was found to rounding.
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
            following = x - value / slope
            inside = min(negative, positive) <= following <= max(negative, positive)
            # Past the Newton steps only round-off is left to fight (a nearly double root): halve until the ends meet.
            if not inside or iteration >= _NEWTON_STEPS:
                following = 0.5 * (negative + positive)
            if abs(following - x) <= _ROUNDING * abs(following):
                return following, True
            x = following
        return x, False

    return find_root

"""The number k of applications in ``P_corr o P^k``: 1 or a prime.

Under ``P^k`` a cycle of impact period p splits into gcd(p, k) cycles. If k is 1 or a prime above every period, none
splits, and the periods of the cell map are those of the motion (Sec. 4).

The damping determines how large k must be for a picture to settle. Distances to a weakly damped orbit shrink by
e^{-delta/2} in every period, whatever the orbit. The paper's k = 1499 at its damping of 0.6 makes k delta = 900.
"""

import math

PAPERS_ITERATIONS = 1499
# A trajectory of as many impacts takes hours.
_MOST_ITERATIONS = 10**12
# The paper keeps its k from this damping up (Fig. 9).
_PAPERS_DAMPING = 0.5
_SETTLED = 900.0
_LEAST_DAMPING = 9e-5
# No chaotic attractor is known below this damping. On one, a trajectory takes all k applications.
_WEAK_DAMPING = 0.02
# Impacts until a trajectory is trapped or captured, times delta: 50 at a damping of 6e-4, fewer above it.
_TRAPPED = 54.0


def is_prime(number: int) -> bool:
    """Whether `number` is a prime, by trial division: 20 ms at the most that `check_iterations` takes."""
    if number < 4:
        return number > 1
    return number % 2 == 1 and all(number % divisor for divisor in range(3, math.isqrt(number) + 1, 2))


def nearest_primes(number: int) -> tuple[int, ...]:
    """The nearest primes below (if there is one) and above `number`."""
    above = max(number + 1, 2)
    while not is_prime(above):
        above += 1
    below = number - 1
    while below > 1 and not is_prime(below):
        below -= 1
    return (below, above) if below > 1 else (above,)


def check_iterations(iterations: int) -> int:
    """Return `iterations` if it is 1 or a prime.

    Raises
    ------
    ValueError
        If it is neither; names the nearest primes. If it is more than 10**12.
    """
    if iterations > _MOST_ITERATIONS:
        raise ValueError(f"iterations must be at most {_MOST_ITERATIONS}")
    if iterations == 1 or is_prime(iterations):
        return iterations
    nearest = " or ".join(str(prime) for prime in nearest_primes(iterations))
    raise ValueError(
        f"iterations must be 1 or a prime, so that periods are not split, not {iterations}; nearest: {nearest}"
    )


def settled_iterations(damping: float) -> int:
    """Default k of a request: 1499 for a damping of 0.5 or more, else the first prime from 900/damping up.

    Below a damping of 9e-5 it stays constant.

    Parameters
    ----------
    damping : float
        delta > 0; for a sweep, the smallest.

    Returns
    -------
    int

    Examples
    --------
    >>> settled_iterations(0.6), settled_iterations(6e-4)
    (1499, 1500007)
    """
    if damping >= _PAPERS_DAMPING:
        return PAPERS_ITERATIONS
    least = math.ceil(_SETTLED / max(damping, _LEAST_DAMPING))
    return least if is_prime(least) else nearest_primes(least)[-1]


def expected_applications(damping: float, iterations: int) -> float:
    """Estimate the applications of P per cell: k, or fewer where damping is weak and orbits are known.

    Parameters
    ----------
    damping : float
        Of the oscillator.
    iterations : int
        k.

    Returns
    -------
    float
        At most ``iterations``.
    """
    if damping > _WEAK_DAMPING:
        return float(iterations)
    return min(float(iterations), _TRAPPED / max(damping, _LEAST_DAMPING))

"""The number k of applications in ``P_corr o P^k``: 1, or a prime.

Under ``P^k`` a cycle of impact period p falls apart into gcd(p, k) cycles. With k = 1 or a prime above every period
nothing falls apart, so that the periods of the cell map are those of the motion (Sec. 4).

How many it takes for a picture to be settled follows from the damping: distances to a weakly damped orbit shrink by
e^{-delta/2} with every period, whatever the orbit. The paper's 1499 at its damping of 0.6 makes k delta = 900.
"""

import math

PAPERS_ITERATIONS = 1499
# The paper keeps its k from here on (Fig. 9).
_PAPERS_DAMPING = 0.5
_SETTLED = 900.0
_LEAST_DAMPING = 9e-5
# Below it no chaotic attractor is known, in which a trajectory would do all k.
_WEAK_DAMPING = 0.02
# Impacts until a trajectory is trapped or captured, times delta: 50 at 6e-4, less above.
_TRAPPED = 54.0


def is_prime(number: int) -> bool:
    """Whether `number` is a prime, by trial division (a request bounds it to a millisecond)."""
    if number < 4:
        return number > 1
    return number % 2 == 1 and all(number % divisor for divisor in range(3, math.isqrt(number) + 1, 2))


def nearest_primes(number: int) -> tuple[int, ...]:
    """The primes next to `number`, below (where there is one) and above."""
    above = max(number + 1, 2)
    while not is_prime(above):
        above += 1
    below = number - 1
    while below > 1 and not is_prime(below):
        below -= 1
    return (below, above) if below > 1 else (above,)


def check_iterations(iterations: int) -> int:
    """Return `iterations` where it is 1 or a prime.

    Raises
    ------
    ValueError
        Naming the nearest primes.
    """
    if iterations == 1 or is_prime(iterations):
        return iterations
    nearest = " or ".join(str(prime) for prime in nearest_primes(iterations))
    raise ValueError(
        f"iterations must be 1 or a prime, so that periods are not split, not {iterations}; nearest: {nearest}"
    )


def settled_iterations(damping: float) -> int:
    """The k of a request that names none: 1499 where the damping is 0.5 or more, else the first prime from 900/damping.

    Below a damping of 9e-5 it grows no further.

    Parameters
    ----------
    damping : float
        delta > 0, the smallest of a sweep.

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
    """Estimate how many applications of P a cell takes. Below k only where damping is weak, and orbits are known.

    Parameters
    ----------
    damping : float
        Of the oscillator.
    iterations : int
        k.

    Returns
    -------
    float
        At most `iterations`.
    """
    if damping > _WEAK_DAMPING:
        return float(iterations)
    return min(float(iterations), _TRAPPED / max(damping, _LEAST_DAMPING))

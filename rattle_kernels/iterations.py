"""The number k of applications in ``P_corr o P^k``: 1, or a prime.

Under ``P^k`` a cycle of impact period p falls apart into gcd(p, k) cycles. With k = 1 or a prime above every period
nothing falls apart, so that the periods of the cell map are those of the motion (Sec. 4).
"""

import math


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

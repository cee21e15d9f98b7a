"""Time a loop such as the kernels have, as Numba compiles it in this process: ``python -m rattle.vector_speed``.

Prints the seconds of the fastest round.
"""

import time

import numba
import numpy as np

_LANES = 512
_FLIGHTS = 12_000
_ROUNDS = 15


@numba.njit(error_model="numpy", fastmath={"contract", "nsz", "arcp"})
def _fly(lanes: np.ndarray, flights: int) -> None:
    """Polynomials and a select on numbers that stay in the first-level cache, as in the flights of lanes."""
    for _ in range(flights):
        for i in range(_LANES):
            x = lanes[i]
            r = x - np.floor(x + 0.5)
            z = r * r
            sine = r * (3.1 + z * (-5.2 + z * (2.6 + z * (-0.6 + z * (0.08 + z * (-0.007 + z * 4e-4))))))
            cosine = 1.0 + z * (-4.9 + z * (4.1 + z * (-1.3 + z * (0.2 + z * (-0.03 + z * 2e-3)))))
            decay = 1.0 - r * (0.5 - r * (0.17 - r * (0.04 - r * (0.008 - r * (0.001 - r * 2e-4)))))
            change = 2.0 * sine * (cosine * decay - sine * r)
            lanes[i] = 0.7 + x * r + 0.1 * change if sine > -0.9 else x + 0.3


def fastest_round() -> float:
    """Seconds of the fastest round. All of them together take some tenths of a second, so clocks settle.

    Returns
    -------
    float
    """
    lanes = np.linspace(0.0, 1.0, _LANES)
    _fly(lanes, 1)
    seconds = []
    for _ in range(_ROUNDS):
        begun = time.perf_counter()
        _fly(lanes, _FLIGHTS)
        seconds.append(time.perf_counter() - begun)
    return min(seconds)


if __name__ == "__main__":
    print(fastest_round())

"""What harmonics and losses cost: ``python -m benchmarks.wider_model``.

Applications of P on the same departures, one oscillator after the other in each round, and the fastest round of each.
Printed are the seconds as a multiple of those of the paper's model, and the part of the flights that took the careful
path.
"""

import time

import numpy as np

from rattle_kernels import Oscillator, check_domain
from rattle_kernels.lanes.run import run_lanes

_HARMONICS = ((2, 0.008, 0.3), (3, 0.002, 0.1), (5, 0.0005, 0.7))
OSCILLATORS = {
    "the paper's model": Oscillator(),
    "restitution 0.999": Oscillator(restitution=0.999),
    "two orders": Oscillator(harmonics=_HARMONICS[:1]),
    "three orders": Oscillator(harmonics=_HARMONICS[:2]),
    "four orders": Oscillator(harmonics=_HARMONICS),
}
_POINTS, _APPLICATIONS, _ROUNDS = 8192, 200, 15


def main() -> None:
    """Measure and print."""
    rng = np.random.default_rng(1)
    t, v = rng.random(_POINTS), rng.uniform(0.01, 12.0, _POINTS)
    seconds = {name: np.inf for name in OSCILLATORS}
    runs = {}
    for _ in range(_ROUNDS + 1):  # the first compiles, and builds tables
        for name, oscillator in OSCILLATORS.items():
            begun = time.process_time()
            _, runs[name] = run_lanes(check_domain(oscillator), t, v, _APPLICATIONS, shortcuts=False)
            seconds[name] = min(seconds[name], (time.process_time() - begun) / runs[name].applications)
    usual = seconds["the paper's model"]
    for name, each in seconds.items():
        careful = runs[name].careful_flights / runs[name].applications
        print(f"{name:20s} {each / usual:5.2f} times  {1e-6 / each:6.1f} million/s  careful {careful:.5f}")


if __name__ == "__main__":
    main()

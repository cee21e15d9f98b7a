"""How fast a loose gear is followed: ``python -m benchmarks.loose_gears``.

P with its shortcuts, and P contact by contact, in lanes and by the scalar path, which searches each bracket by Newton's
method. One way after the other in each round; the fastest round of each counts. Printed are applications a second, how
many times the scalar path that is, and the part of the applications that lanes have left to it.
"""

import math
import time

import numpy as np

from rattle_kernels import Harmonic, Oscillator
from rattle_kernels.impact_map.loose_map import contact_by_contact, next_loose_impact
from rattle_kernels.lanes.run import run_lanes
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.numerics.jit import kernel

_POINTS, _SCALAR_POINTS, _APPLICATIONS, _ROUNDS = 8192, 256, 50, 7


def _machine(gamma: float, restitution: float, *harmonics: Harmonic) -> Oscillator:
    """Machine whose first harmonic alone has this Gamma."""
    eccentricity = gamma * 0.2 / math.hypot(2.0 * math.pi, 0.1)
    return check_oscillator(Oscillator(0.1, eccentricity, 0.3, restitution=restitution, harmonics=harmonics))


MACHINES = {
    "Gamma 1.1, r 0.9": _machine(1.1, 0.9),
    "Gamma 1.5, r 0.95": _machine(1.5, 0.95),
    "Gamma 2, r 0.7": _machine(2.0, 0.7),
    "Gamma 4, r 0.6": _machine(4.0, 0.6),
    "two orders, r 0.8": _machine(2.0, 0.8, Harmonic(2.0, 0.015, 0.2)),
}


@kernel
def _by_scalars(oscillator, t, v, applications, shortcuts):
    for i in range(t.size):
        phase, speed = t[i], v[i]
        for _ in range(applications):
            if shortcuts:
                impact = next_loose_impact(oscillator, phase, speed)
            else:
                impact = contact_by_contact(oscillator, phase, speed).impact
            phase, speed = impact.t, impact.v
        t[i], v[i] = phase, speed


def main() -> None:
    """Measure and print."""
    rng = np.random.default_rng(1)
    t, v = rng.random(_POINTS), rng.uniform(0.0, 1.5, _POINTS)
    for name, oscillator in MACHINES.items():
        for shortcuts in (True, False):
            lanes = scalar = math.inf
            for _ in range(_ROUNDS + 1):  # the first compiles
                begun = time.process_time()
                _, run = run_lanes(oscillator, t, v, _APPLICATIONS, shortcuts=shortcuts)
                between = time.process_time()
                _by_scalars(oscillator, t[:_SCALAR_POINTS].copy(), v[:_SCALAR_POINTS].copy(), _APPLICATIONS, shortcuts)
                lanes = min(lanes, (between - begun) / run.applications)
                scalar = min(scalar, (time.process_time() - between) / (_SCALAR_POINTS * _APPLICATIONS))
            kind = "shortcuts" if shortcuts else "contact by contact"
            careful = run.careful_flights / run.applications
            rates = f"{1e-6 / lanes:5.2f} million/s  {scalar / lanes:5.1f} times"
            print(f"{name:18s} {kind:19s} {rates}  careful {careful:.5f}")


if __name__ == "__main__":
    main()

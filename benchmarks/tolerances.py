"""A production within tolerances against plain following: ``python -m benchmarks.tolerances [MACHINES [DEPARTURES]]``.

For each nominal machine: seconds of `rattle.tolerances`, by default 1,024 machines with 1,000 departures each, on all
cores. The bar is a minute on two quiet ones. Beside it stand a few machines of the same production whose departures are
all followed by P in the same lanes, without capture, lock or catalogue, until all of them have settled: processor time
of a machine by `shares_of`, by plain following, the one in units of the other, and by how much quiet shares differ at
most. Plain following finds no motions, and has the tables of the lanes for nothing. An elastic machine of such weak
damping really rattles for so long, so only some are computed.
"""

import math
import sys
import time

import numpy as np

import rattle
from rattle_kernels import capture_velocity, next_impacts, settled_iterations, shares_of, warm_up
from rattle_machine.departures import sample_of
from rattle_machine.numbers import number_of
from rattle_machine.tolerances import tolerances

_WEAK = {
    "speed": 305.0, "inertia": 0.0173, "drag_torque": 0.41, "base_radius": 0.0571, "backlash": 61e-6,
    "transmission_error": 5.2e-6,
}  # fmt: skip
_PAPERS = {
    "speed": 100.0, "inertia": 0.01, "drag_torque": 9.5493, "base_radius": 0.1, "backlash": 0.12,
    "transmission_error": 0.01,
}  # fmt: skip
_LOSING = _WEAK | {"restitution": 0.9}
MACHINES = {
    "the paper's, damping 0.6": (_PAPERS, 1),
    "damping 0.0016, restitution 0.9": (_LOSING, 1),
    "the same with 31 MN/m": (_LOSING | {"mesh_stiffness": 3.1e7}, 1),
    "damping 0.0016, restitution 0.99": (_WEAK | {"restitution": 0.99}, 1),
    "damping 0.0016, elastic": (_WEAK, 16),
}
"""Numbers of each nominal machine, and by how much fewer of it are computed."""
BAR = 60.0
_PLAIN = 2


def tolerances_of(pair):
    """A fifth more or less of two numbers: so all machines that are asked for are computed."""
    middle = {name: number_of(pair, name) for name in ("backlash", "transmission_error.1.amplitude")}
    return {name: (0.8 * value, 1.2 * value) for name, value in middle.items()}


def quiet_share(oscillator, t, v):
    """Share of departures that are quiet at the end, all of them followed to it."""
    applications = settled_iterations(oscillator.damping)
    if oscillator.restitution < 1.0:  # each impact takes that part of the speed: e^-60 is left, and no denormal number
        applications = min(applications, math.ceil(60.0 / (1.0 - oscillator.restitution)))
    landed = next_impacts(oscillator, t, v, applications)
    fast = landed.v >= capture_velocity(oscillator, np.nan_to_num(landed.t))
    return 1.0 - np.mean(np.isfinite(landed.v) & fast)


def beside_plain(pair, departures):
    """Processor time of a machine as a production has it and of plain following, s, and how shares differ at most."""
    sample = sample_of(
        pair, size=None, distribution=None, pressing="bounces", fastest=None, departures=departures, seed=0
    )
    made, plain, apart = 0.0, 0.0, 0.0
    for part in np.linspace(0.9, 1.1, _PLAIN):
        machine = pair.model_copy(update={"backlash": pair.backlash * part})
        t, v = sample(machine)
        begun = time.process_time()
        found = shares_of(machine.oscillator, t, v)
        middle = time.process_time()
        share = quiet_share(machine.oscillator, t, v)
        made, plain = made + middle - begun, plain + time.process_time() - middle
        apart = max(apart, abs(share - found.share[0]))
    return made / _PLAIN, plain / _PLAIN, apart


def main(machines=1024, departures=1000):
    """Print a line for each nominal machine; exit with 1 if one takes more than the bar."""
    warm_up()
    longest = 0.0
    for name, (numbers, fewer) in MACHINES.items():
        pair = rattle.GearPair(**numbers)
        beside_plain(pair, 8)  # compiles what is not there yet
        count = int(machines) // fewer
        begun = time.perf_counter()
        study = tolerances(pair, tolerances_of(pair), machines=count, departures=int(departures), tighten=1.0)
        seconds = time.perf_counter() - begun
        longest = max(longest, seconds)
        made, plain, apart = beside_plain(pair, int(departures))
        print(
            f"{name:32} {seconds:5.1f} s for {count} machines, quiet {study.production.mean}; one {1e3 * made:6.1f} "
            f"ms, plainly {1e3 * plain:7.1f} ms: {made / plain:5.2f} times; shares differ by {apart:.4f}", flush=True,
        )  # fmt: skip
    sys.exit(longest > BAR)


if __name__ == "__main__":
    main(*sys.argv[1:])

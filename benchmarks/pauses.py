"""How long tasks go without a look at cancellation: ``python -m benchmarks.pauses [SECONDS [NAME]]``.

A cancelled task is left within two seconds, so none may go longer than one without a look. Requests are extreme and
valid. Each is run in this thread and cut off after some seconds, five by default; all seconds are processor time. Some
kernels are compiled when they are first needed, so only a second run counts.
"""

import resource
import sys
import tempfile
import time
from pathlib import Path

from rattle_kernels import warm_up, warm_up_analyses, warm_up_curves
from tests.watched_run import Watch, run_watched
from worker.errors import NotFound
from worker.estimate import estimate
from worker.kinds import KINDS

SECONDS = 5.0
LIMIT = 1.0
# Damping, eccentricity and half backlash.
WEAK = {"damping": 1e-3, "eccentricity": 1e-4, "half_backlash": 0.6}
WEAKER = {"damping": 1e-4, "eccentricity": 1e-5, "half_backlash": 0.6}
WIDE = {"damping": 0.6, "eccentricity": 0.01, "half_backlash": 4e5}
SOFT = {"model": "piecewise_linear", "stiffness": 0.05, "allow_no_quiet_solution": True}
SOFTISH = SOFT | {"stiffness": 1.0}
STIFF = {"model": "piecewise_linear", "stiffness": 1e9}
CELLS = {"time": {"cells": 300}, "velocity": {"cells": 300}}


def damping(*values):
    """Values of the damping."""
    return {"parameter": "damping", "values": list(values)}


def up_to(speed):
    """A region of all phases."""
    return {"time": {"start": 0, "stop": 1}, "velocity": {"start": 0, "stop": speed}}


SEED = [{"time": 0.553, "velocity": 4.703}]
SADDLE = {"time": 0.6017, "velocity": 3.7699}
REQUESTS = {
    "basin": ("basin", {"grid": CELLS}),
    "basin, weak damping": ("basin", {"oscillator": WEAK, "grid": CELLS}),
    "basin, weaker damping": ("basin", {"oscillator": WEAKER, "grid": CELLS}),
    "basin, wide backlash": ("basin", {"oscillator": WIDE, "grid": CELLS}),
    "basin, soft": ("basin", {"oscillator": SOFT, "grid": CELLS}),
    "basin, softish": ("basin", {"oscillator": SOFTISH, "grid": CELLS}),
    "basin, stiff": ("basin", {"oscillator": STIFF, "grid": CELLS}),
    "basin, k of ten million": ("basin", {"grid": CELLS, "iterations": 10_000_019}),
    "basin, fast": ("basin", {"grid": CELLS | {"velocity": {"stop": 1.8e5, "cells": 300}}}),
    "sample": ("basin", {"sample": {"points": 1 << 20}}),
    "sweep": ("sweep", {"grid": CELLS, "vary": [damping(1e-3, 1e-2, 0.6)], "oscillator": {"eccentricity": 1e-4}}),
    "orbits, many cells": ("orbits", {"cells": 1000, "longest": 1}),
    "orbits, long": ("orbits", {"cells": 10, "longest": 2500}),
    "orbits, longest": ("orbits", {"cells": 1, "longest": 9_999}),
    "orbits, soft": ("orbits", {"oscillator": SOFT}),
    "orbits, softish": ("orbits", {"oscillator": SOFTISH}),
    "orbits, weak damping": ("orbits", {"oscillator": WEAK}),
    "orbits, a long seed": ("orbits", {"seeds": [{"time": 0.553, "velocity": 4.703, "period": 9_999}]}),
    "orbits, followed": ("orbits", {"continuation": {"parameter": "damping", "start": 0.01, "stop": 5.0}}),
    "diagram, much kept": ("bifurcation", {"vary": damping(0.6), "seeds": SEED, "kept": 10_000_000}),
    "diagram, long transient": ("bifurcation", {"vary": damping(0.6), "seeds": SEED, "transient": 4_000_000_000}),
    "diagram, many values": (
        "bifurcation",
        {"vary": {"parameter": "damping", "start": 0.5, "stop": 0.6, "count": 1_000_000}, "seeds": SEED, "kept": 1}
        | {"transient": 0},
    ),
    "diagram, fast": ("bifurcation", {"vary": damping(0.5, 0.6), "region": up_to(1e6)}),
    "diagram, weak damping": (
        "bifurcation", {"vary": damping(1e-3, 2e-3), "oscillator": {"eccentricity": 1e-4}, "region": up_to(7.0)},
    ),
    "diagram, soft": ("bifurcation", {"oscillator": SOFT, "vary": damping(0.5, 0.6)}),
    "manifold": ("manifold", {"saddles": [SADDLE], "side": "both", "arclength": 1e4, "most_points": 2_000_000}),
    "manifold of a name": ("manifold", {"saddles": [{"itinerary": "P(40,40,0)"}], "cells": 150}),
    "grazing curves": ("grazing_curve", {"order": 16, "most_points": 2_000_000}),
    "grazing curves, weak damping": ("grazing_curve", {"oscillator": WEAK, "order": 16, "most_points": 2_000_000}),
}  # fmt: skip


def measure(kind, request, seconds):
    """The job's watch, the bytes of its estimate, and how it ended."""
    job = KINDS[kind].job_class.from_request(request)
    watch = Watch(seconds)
    with tempfile.TemporaryDirectory() as folder:
        try:
            ended = "ended" if run_watched(job, Path(folder) / "store.zarr", watch) else "cut off"
        except NotFound:
            ended = "not found"
    return watch, estimate(job).bytes, ended


def main(seconds=SECONDS, name=""):
    """Print a line for each request; exit with 1 if one goes too long without a look."""
    for warm in (warm_up, warm_up_curves, warm_up_analyses):
        warm()
    longest = 0.0
    for title, (kind, request) in REQUESTS.items():
        if name in title:
            begin = time.thread_time()
            watch, size, ended = measure(kind, request, float(seconds))
            longest = max(longest, watch.longest)
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
            print(
                f"{title:32} {watch.longest:7.2f} s {watch.where:32} {time.thread_time() - begin:6.1f} s, {ended}; "
                f"store {size / 1e6:.0f} MB, peak so far {peak:.0f} MB", flush=True,
            )  # fmt: skip
    sys.exit(longest > LIMIT)


if __name__ == "__main__":
    main(*sys.argv[1:])

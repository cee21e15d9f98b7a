"""The seed pass: find attractors before a basin is mapped, so that they can trap its trajectories.

With weak damping, the end of a trajectory can be recognised long before it settles, if the attractors are known. The
seed pass follows points of the window to their ends: a few without traps, then more with the traps of the attractors
found. Trajectories on attractors that it misses take longer, but their images are the same. Since images do not depend
on the seed pass, each process makes its own.
"""

from functools import lru_cache

import numpy as np

from rattle_kernels.attractors.attractor import Attractor
from rattle_kernels.attractors.attractor_search import find_attractors
from rattle_kernels.attractors.trap_table import build_trap_table
from rattle_kernels.cell_mapping.cell_grid import CellGrid
from rattle_kernels.cell_mapping.cell_map import map_points
from rattle_kernels.lanes.traps import NO_TRAPS, LaneTraps
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.pausing import Pause, never_stopped

# Seeds in each round. At a damping of 6e-4 the first finds the orbits of 93 % of the window, the second those of 98 %.
_ROUNDS = (128, 2048)
# At a damping of 0.06 a seed pass of one second saves three quarters of the applications; at 0.6, half a per cent.
_LARGEST_DAMPING = 0.1
# With fewer cells the pass would cost more than it saves.
_CELLS_PER_SEED = 8


@lru_cache(maxsize=4)
def traps_of_seeds(
    oscillator: Oscillator, grid: CellGrid, iterations: int, places: int, pause: Pause = never_stopped
) -> LaneTraps:
    """Traps of the attractors that a sample of the window ends in; none if they would not pay, or beyond Eq. (8).

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    grid : CellGrid
    iterations : int
        k, applied to each seed. Seeds captured by then are left out.
    places : int
        Number of cells or points that will use the traps.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    LaneTraps
    """
    if oscillator.damping > _LARGEST_DAMPING or oscillator.is_loose:
        return NO_TRAPS
    attractors: tuple[Attractor, ...] = ()
    traps = NO_TRAPS
    for number in (number for number in _ROUNDS if number * _CELLS_PER_SEED <= places):
        unit = np.random.default_rng(number).random((2, number))
        t = grid.time_start + unit[0] * (grid.time_stop - grid.time_start)
        v = grid.velocity_start + (1.0 - unit[1]) * (grid.velocity_stop - grid.velocity_start)
        landed = map_points(oscillator, grid, iterations, t, v, traps=traps, pause=pause)
        there = np.isfinite(landed.landing_time)
        attractors = find_attractors(
            oscillator, landed.landing_time[there], landed.landing_velocity[there], known=attractors, pause=pause
        )
        traps = build_trap_table(oscillator, attractors, pause)
    return traps

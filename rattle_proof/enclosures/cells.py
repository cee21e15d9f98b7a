"""Cells of a basin picture: what part of each is proven to end as the cell is coloured, or never to fall quiet.

A cell is followed as a whole. Where that proves nothing it is cut into four, as often as asked.
"""

from typing import NamedTuple

import numpy as np

from rattle_kernels.cell_mapping.cell_grid import CellGrid
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import inlined_as_written, kernel_as_written
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_proof.enclosures import MOST_LEVELS
from rattle_proof.enclosures.flight import Box
from rattle_proof.enclosures.following import follow
from rattle_proof.enclosures.interval import Interval, down, up
from rattle_proof.enclosures.lattice import UNPROVEN
from rattle_proof.enclosures.machine import Machine
from rattle_proof.enclosures.targets import Targets

WHOLE = 4**MOST_LEVELS
"""Parts of a cell that are counted: 64."""
ENDS_ELSEWHERE = 4
"""Reason why not all of a cell is proven, beside those of `following`: some of it is proven to end otherwise."""
RATTLES = 5
"""All of it that is not proven never falls quiet, as the cell is coloured; in which motion it ends is not known."""
IMPACTS = 12
"""How many impacts a cell is followed at most."""
# Parts of cells that are followed between two pauses: some tenth of a second, even where each takes all its images.
_PIECES_AT_A_TIME = 2048
_ROUNDED = 2.0**-50


class ProvenCells(NamedTuple):
    """What is proven of cells, arrays of one shape (rows, columns), uint8.

    ``proven`` counts the sixty-fourths of a cell of which every departure ends as the cell is coloured, and
    ``never_quiet`` those of which none falls quiet. ``reason`` says why not all are proven, 0 where they are.
    """

    proven: np.ndarray
    never_quiet: np.ndarray
    reason: np.ndarray


@inlined_as_written
def _push_quarters(stack, waiting, early, late, low, high, level, never_quiet):
    half_t, half_v = 0.5 * (early + late), 0.5 * (low + high)
    stack[waiting] = early, half_t, low, half_v, level, never_quiet
    stack[waiting + 1] = half_t, late, low, half_v, level, never_quiet
    stack[waiting + 2] = early, half_t, half_v, high, level, never_quiet
    stack[waiting + 3] = half_t, late, half_v, high, level, never_quiet
    return waiting + 4


@inlined_as_written
def _prove_cell(machine, oscillator, targets, colour, levels, slack, stack):
    """Parts of the cell on the stack that are proven to end as coloured, those that rattle, and why not all are."""
    proven, rattling, reason, waiting = 0, 0, 0, 1
    rattles = False
    while waiting > 0:
        waiting -= 1
        early, late, low, high = stack[waiting, 0], stack[waiting, 1], stack[waiting, 2], stack[waiting, 3]
        level, known = stack[waiting, 4], stack[waiting, 5]
        # The edges are rounded: neighbours overlap.
        times = Interval(down(early - slack[0]), up(late + slack[0]))
        box = Box(times, Interval(max(down(low - slack[1]), 0.0), up(high + slack[1])))
        followed = follow(machine, oscillator, targets, box, IMPACTS)
        never_quiet = followed.never_quiet or known > 0.0
        if followed.end == UNPROVEN and level < levels:
            waiting = _push_quarters(stack, waiting, early, late, low, high, level + 1.0, 1.0 if never_quiet else 0.0)
            continue
        part = WHOLE >> (2 * int(level))
        if never_quiet:
            rattling += part
        if followed.end == colour + 1:
            proven += part
        elif followed.end != UNPROVEN or (never_quiet and colour + 1 == targets.quiet):
            reason = ENDS_ELSEWHERE
        elif never_quiet:
            rattles = True
        else:
            reason = max(reason, followed.reason)
    return proven, rattling, RATTLES if rattles and reason == 0 else reason


@kernel_as_written
def _prove_all(machine, oscillator, targets, times, speeds, colours, levels, slack, stack, proven, never_quiet, reason):
    for i in range(colours.shape[0]):
        for j in range(colours.shape[1]):
            stack[0] = times[j], times[j + 1], speeds[i], speeds[i + 1], 0.0, 0.0
            proven[i, j], never_quiet[i, j], reason[i, j] = _prove_cell(
                machine, oscillator, targets, int(colours[i, j]), levels, slack, stack
            )


def prove_cells(
    machine: Machine,
    oscillator: Oscillator,
    targets: Targets,
    grid: CellGrid,
    rows: tuple[int, int],
    columns: tuple[int, int],
    colours: np.ndarray,
    levels: int = 0,
    pause: Pause = never_stopped,
) -> ProvenCells:
    """Prove a rectangle of cells.

    Parameters
    ----------
    machine : Machine
    oscillator : Oscillator
        One of them: where roots are sought first. Nothing rests on it.
    targets : Targets
        Grown (`growth`).
    grid : CellGrid
    rows, columns : (int, int)
        First cell and the one after the last, along velocity and time.
    colours : ndarray of int, shape (rows, columns)
        Number of the motion that each cell is coloured as.
    levels : int
        How often a cell may be cut into four, 0 to 3.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    ProvenCells
        Of the shape of `colours`.
    """
    if not 0 <= levels <= MOST_LEVELS:
        raise ValueError(f"levels must be 0 to {MOST_LEVELS}, not {levels}")
    width = (grid.time_stop - grid.time_start) / grid.time_cells
    height = (grid.velocity_stop - grid.velocity_start) / grid.velocity_cells
    times = grid.time_start + np.arange(columns[0], columns[1] + 1) * width
    speeds = grid.velocity_start + np.arange(rows[0], rows[1] + 1) * height
    proven, never_quiet, reason = (np.empty(colours.shape, np.uint8) for _ in range(3))
    # An edge comes of four operations with numbers no larger than the ends of its window.
    slack = _ROUNDED * max(abs(grid.time_start), abs(grid.time_stop)), _ROUNDED * grid.velocity_stop
    stack = np.empty((3 * MOST_LEVELS + 2, 6))
    # Whole rows, or parts of one: these are contiguous in memory.
    most = max(1, _PIECES_AT_A_TIME >> (2 * levels))
    wide = max(1, min(colours.shape[1], most))
    high = max(1, most // wide)
    for i in range(0, colours.shape[0], high):
        for j in range(0, colours.shape[1], wide):
            pause()
            here = slice(i, i + high), slice(j, j + wide)
            _prove_all(
                machine, oscillator, targets, times[j : j + wide + 1], speeds[i : i + high + 1], colours[here],
                float(levels), slack, stack, proven[here], never_quiet[here], reason[here],
            )  # fmt: skip
    return ProvenCells(proven, never_quiet, reason)

"""Maps a small basin of each model: ``python -m tests.rattle_kernels.numerics.small_maps FOLDER``."""

import sys
from pathlib import Path

import numpy as np

from rattle_kernels import CellGrid, Oscillator, map_cells

OSCILLATORS = {"impacting": Oscillator(), "piecewise_linear": Oscillator(stiffness=1e4)}
_GRID = CellGrid(time_cells=32, velocity_cells=32)


def map_all(folder):
    """Write the image cells and landing points of each."""
    for name, oscillator in OSCILLATORS.items():
        images = map_cells(oscillator, _GRID, 1499, (0, 32), (0, 32))
        for part, values in zip(("image_cell", "landing_time", "landing_velocity"), images[:3], strict=True):
            np.save(folder / f"{name}_{part}.npy", values)


if __name__ == "__main__":
    map_all(Path(sys.argv[1]))

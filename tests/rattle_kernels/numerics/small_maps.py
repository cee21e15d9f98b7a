"""Maps a small basin and many departures: ``python -m tests.rattle_kernels.numerics.small_maps FOLDER``."""

import sys
from pathlib import Path

import numpy as np

from rattle_kernels import CellGrid, Oscillator, map_cells, next_impacts

OSCILLATORS = {"impacting": Oscillator(), "piecewise_linear": Oscillator(stiffness=1e4)}
_GRID = CellGrid(time_cells=32, velocity_cells=32)
# One flight in 10,000 takes the careful path, and one contact in 50 where kappa = 1000: few departures meet both.
_SECOND_ORDER = ((2, 0.008, 0.3),)
OF_DEPARTURES = {
    "impacting": Oscillator(),
    "soft": Oscillator(stiffness=100.0),
    "stiff": Oscillator(stiffness=1000.0),
    "wider": Oscillator(restitution=0.95, harmonics=_SECOND_ORDER),
    "wider_stiff": Oscillator(stiffness=1000.0, contact_damping=0.05, harmonics=_SECOND_ORDER),
}
_DEPARTURES = 50_000


def map_all(folder):
    """Write the image cells and landing points of each."""
    for name, oscillator in OSCILLATORS.items():
        images = map_cells(oscillator, _GRID, 1499, (0, 32), (0, 32))
        for part, values in zip(("image_cell", "landing_time", "landing_velocity"), images[:3], strict=True):
            np.save(folder / f"{name}_{part}.npy", values)
    chance = np.random.default_rng(0)
    t, v = chance.random(_DEPARTURES), 7.0 * chance.random(_DEPARTURES)
    for name, oscillator in OF_DEPARTURES.items():
        landed = [next_impacts(oscillator, t, v, applications)[:2] for applications in (1, 10)]
        np.save(folder / f"departures_{name}.npy", np.array(landed))


if __name__ == "__main__":
    map_all(Path(sys.argv[1]))

"""How long tiles will take, from a few cells of each: a chaotic cell takes all applications, a quiet one few.

Where tiles are few for the workers, the order decides how long the others wait for the last: longest first. With four
workers the panels of Fig. 7 took 5 to 24 % longer than their share in the order of tiles, and take 1 % longer so. The
order changes nothing in a store.
"""

import numpy as np

from rattle_kernels import map_points
from rattle_kernels.attractors.seed_pass import traps_of_seeds
from rattle_kernels.numerics.pausing import Pause
from worker.jobs.basin_job import BasinJob
from worker.stores.basin_store import BasinStore
from worker.stores.tiles import Tile

# Cells looked at each way: 64 fill all lanes, and are a six-hundredth of a tile of the panels.
_EACH_WAY = 8
# Fewer take no shorter where they are last; of more, the last one is short beside all of them.
_FEWEST_TILES, _MOST_TILES = 6, 256


def worth_weighing(job: BasinJob, tiles: int) -> bool:
    """Whether the order of some tiles that are to be mapped matters: of one basin, and not all alike."""
    alike = job.sample is not None or job.basins > 1 or job.iterations == 1
    return not alike and _FEWEST_TILES <= tiles <= _MOST_TILES


def _some(span: tuple[int, int]) -> np.ndarray:
    start, stop = span
    return start + ((np.arange(_EACH_WAY) + 0.5) / _EACH_WAY * (stop - start)).astype(np.int64)


def weigh(store: BasinStore, tile: Tile, pause: Pause) -> int:
    """Applications of P that some cells of a tile take."""
    job, oscillator = store.job, store.job.oscillator_of(tile.basin)
    traps = traps_of_seeds(oscillator, job.grid, job.iterations, job.grid.cells, pause)
    t, v = np.meshgrid(job.grid.time_centres()[_some(tile.columns)], job.grid.velocity_centres()[_some(tile.rows)])
    images = map_points(oscillator, job.grid, job.iterations, t.ravel(), v.ravel(), traps=traps, pause=pause)
    return images.applications

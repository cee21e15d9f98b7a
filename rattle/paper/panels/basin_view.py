"""A basin as a figure shows it: its motions, and its cells, thinned out if they are too many for a sheet."""

from dataclasses import dataclass

import numpy as np

from rattle_kernels import Attractor, Oscillator
from worker.jobs.basin_job import BasinJob
from worker.stores.basin_store import BasinStore
from worker.stores.summary import count_images
from worker.views.reading import attractors_of, basin_of, job_of, open_basin

# Most cells along each axis. In larger basins every n-th cell stands for its neighbours: labels cannot be averaged.
_MOST_CELLS = 1000


@dataclass(frozen=True)
class BasinView:
    """Contents of a complete store.

    ``shares`` count all cells. ``solution``, ``group``, ``landing_time`` and ``landing_velocity``, of shape (rows,
    columns), are those of the cells shown. ``image_counts`` is the number of cells with each reserved image.
    """

    job: BasinJob
    attractors: tuple[Attractor, ...]
    shares: tuple[float, ...]
    image_counts: dict[str, int]
    solution: np.ndarray
    group: np.ndarray
    landing_time: np.ndarray
    landing_velocity: np.ndarray

    @property
    def oscillator(self) -> Oscillator:
        """Oscillator of the basin."""
        return self.job.oscillator

    @property
    def names(self) -> np.ndarray:
        """Name of each cell's solution."""
        return np.array([attractor.name for attractor in self.attractors])[self.solution]


def view_basin(location: str, panel: int = 0) -> BasinView:
    """Read a complete store.

    Parameters
    ----------
    location : str
    panel : int
        Number of the basin in a sweep. The view has the ``job`` of this basin alone, and the ``attractors`` of the
        whole sweep by number. An attractor that the basin lacks has no points and the share NaN.

    Raises
    ------
    StoreConflict
        If there is no store.
    """
    whole = open_basin(location)
    dataset = basin_of(whole, **job_of(whole).values_of(panel))
    every = slice(None, None, max(1, -(-max(dataset.solution.shape) // _MOST_CELLS)))
    cells = dataset[["solution", "group", "landing_time", "landing_velocity"]].isel(time=every, velocity=every)
    return BasinView(
        job_of(dataset), attractors_of(dataset), tuple(dataset.share.values.tolist()),
        count_images(BasinStore(location), panel),
        *(cells[name].values for name in ("solution", "group", "landing_time", "landing_velocity")),
    )  # fmt: skip

"""A basin as a figure sees it: its motions, and its cells, thinned out where they are more than a sheet shows."""

from dataclasses import dataclass

import numpy as np

from rattle_kernels import Attractor, Oscillator
from worker.jobs.basin_job import BasinJob
from worker.stores.basin_store import BasinStore
from worker.stores.summary import count_images
from worker.views.reading import attractors_of, basin_of, job_of, open_basin

# Cells each way at the most: beyond, every n-th cell stands for its neighbours (labels cannot be averaged).
_MOST_CELLS = 1000


@dataclass(frozen=True)
class BasinView:
    """What a complete store says.

    ``shares`` are those of all cells; ``solution``, ``group``, ``landing_time`` and ``landing_velocity`` (shape (rows,
    columns)) those of the cells shown; ``image_counts`` says how many cells have each reserved image.
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
        """The one whose basin it is."""
        return self.job.oscillator

    @property
    def names(self) -> np.ndarray:
        """Name of the solution of each cell."""
        return np.array([attractor.name for attractor in self.attractors])[self.solution]


def view_basin(location: str, panel: int = 0) -> BasinView:
    """Read a complete store.

    Parameters
    ----------
    location : str
    panel : int
        Of a sweep, which basin: its ``job`` is that of the basin alone, its ``attractors`` those of the sweep by
        number; one that it lacks has no points and the share NaN.

    Raises
    ------
    StoreConflict
        Where there is none.
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

"""A sample of the window in place of its grid of cells: scrambled Sobol points."""

from dataclasses import dataclass

import numpy as np

from rattle_kernels import CellGrid
from worker.errors import InvalidJob

_BITS = 30


@dataclass(frozen=True)
class Sample:
    """How many points, and the seed of their scrambling: the same seed gives the same points."""

    points: int
    seed: int = 0

    def __post_init__(self) -> None:
        if not 1 <= self.points <= 1 << _BITS:
            raise InvalidJob(f"a sample has 1 to {1 << _BITS} points, not {self.points}", ("sample", "points"))
        if self.seed < 0:
            raise InvalidJob(f"the seed of a sample must not be negative, not {self.seed}", ("sample", "seed"))

    def departures(self, window: CellGrid, start: int, stop: int) -> tuple[np.ndarray, np.ndarray]:
        """Times and speeds of some of the points.

        Parameters
        ----------
        window : CellGrid
            Its limits are what counts.
        start, stop : int
            Numbers of the points.

        Returns
        -------
        t, v : ndarray of float64, shape (stop - start,)
            Inside the window; the speeds are positive.
        """
        from scipy.stats.qmc import Sobol  # takes a second, which no other command should wait

        sequence = Sobol(2, scramble=True, bits=_BITS, rng=self.seed)
        if start > 0:
            sequence.fast_forward(start)
        # Powers of two, as the sequence asks for; in the middle of their little squares, so that no speed is zero.
        unit = sequence.random(1 << (stop - start - 1).bit_length())[: stop - start] + 0.5 ** (_BITS + 1)
        t = window.time_start + unit[:, 0] * (window.time_stop - window.time_start)
        v = window.velocity_start + unit[:, 1] * (window.velocity_stop - window.velocity_start)
        return t, v

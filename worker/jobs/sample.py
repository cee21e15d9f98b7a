"""A sample of the window in place of its grid of cells: scrambled Sobol points."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from pydantic import ConfigDict, Field

from rattle_kernels import CellGrid
from worker.errors import InvalidJob
from worker.jobs.request import Count, values_config

_BITS = 30


@dataclass(frozen=True)
class Sample:
    """Points of the window to start from in place of a grid of cells: a scrambled Sobol sequence.

    Parameters
    ----------
    points : int
    seed : int
        The same seed gives the same points.

    Raises
    ------
    InvalidJob
        If there are too few or too many points, or the seed is negative.

    Examples
    --------
    >>> import rattle
    >>> rattle.BasinJob(sample=Sample(512)).sample
    Sample(points=512, seed=0)
    """

    __pydantic_config__: ClassVar[ConfigDict] = values_config("SampleRequest")

    points: Annotated[Count, Field(description="Number of points")]
    seed: Annotated[int, Field(strict=True, ge=0, description="The same seed gives the same points")] = 0

    def __post_init__(self) -> None:
        if not 1 <= self.points <= 1 << _BITS:
            raise InvalidJob(f"a sample has 1 to {1 << _BITS} points, not {self.points}", ("points",))
        if self.seed < 0:
            raise InvalidJob(f"the seed of a sample must not be negative, not {self.seed}", ("seed",))

    def departures(self, window: CellGrid, start: int, stop: int) -> tuple[np.ndarray, np.ndarray]:
        """Times and speeds of some of the points.

        Parameters
        ----------
        window : CellGrid
            Only its limits are used.
        start, stop : int
            Numbers of the first point and of the one after the last.

        Returns
        -------
        t, v : ndarray of float64, shape (stop - start,)
            Inside the window; the speeds are positive.
        """
        from scipy.stats.qmc import Sobol  # takes a second to load

        sequence = Sobol(2, scramble=True, bits=_BITS, rng=self.seed)
        if start > 0:
            sequence.fast_forward(start)
        # The sequence asks for powers of two. Half a step is added so that no speed is zero.
        unit = sequence.random(1 << (stop - start - 1).bit_length())[: stop - start] + 0.5 ** (_BITS + 1)
        t = window.time_start + unit[:, 0] * (window.time_stop - window.time_start)
        v = window.velocity_start + unit[:, 1] * (window.velocity_stop - window.velocity_start)
        return t, v

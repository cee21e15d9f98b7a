"""A sample of the window in place of its grid of cells: scrambled Sobol points."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from pydantic import ConfigDict, Field

from rattle_kernels import CellGrid
from worker.errors import InvalidJob
from worker.jobs.request import INTEGRAL, Count, in_schema

_BITS = 30
_MOST_SCRAMBLINGS = 1000


@dataclass(frozen=True)
class Sample:
    """Points of the window to start from in place of a grid of cells: a scrambled Sobol sequence.

    Parameters
    ----------
    points : int
    seed : int
        The same seed gives the same points.
    scramblings : int
        Sets that the points are dealt out to in turn, each a sequence scrambled by itself. From two on, the errors of
        shares are measured by the scatter of the sets; of one, they are those of independent points.

    Raises
    ------
    InvalidJob
        If there are too few or too many points, the seed is negative, or the points cannot be dealt out evenly.

    Examples
    --------
    >>> import rattle
    >>> rattle.BasinJob(sample=Sample(512)).sample
    Sample(points=512, seed=0, scramblings=1)
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid", title="SampleRequest")

    points: Annotated[Count, Field(description="Number of points"), in_schema(maximum=1 << _BITS)]
    seed: Annotated[int, Field(strict=True, ge=0, description="The same seed gives the same points"), INTEGRAL] = 0
    # Left out of requests where it is 1: they, and their digests, are those of before there were scramblings.
    scramblings: Annotated[
        Count,
        Field(
            description="Sets of points, each scrambled by itself; from two on their scatter measures the errors",
            exclude_if=lambda number: number == 1,
        ),
        in_schema(maximum=_MOST_SCRAMBLINGS),
    ] = 1

    def __post_init__(self) -> None:
        if not 1 <= self.points <= 1 << _BITS:
            raise InvalidJob(f"a sample has 1 to {1 << _BITS} points, not {self.points}", ("points",))
        if self.seed < 0:
            raise InvalidJob(f"the seed of a sample must not be negative, not {self.seed}", ("seed",))
        if not 1 <= self.scramblings <= _MOST_SCRAMBLINGS:
            message = f"a sample has 1 to {_MOST_SCRAMBLINGS} scramblings, not {self.scramblings}"
            raise InvalidJob(message, ("scramblings",))
        if self.points % self.scramblings:
            message = (
                f"the points must be a multiple of the scramblings, and {self.points} is none of {self.scramblings}"
            )
            raise InvalidJob(message, ("scramblings",))
        if self.scramblings > 1 and self.points < 2 * self.scramblings:
            raise InvalidJob("each scrambling has two points or more", ("scramblings",))

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
        unit = np.empty((stop - start, 2))
        for number in range(self.scramblings):
            # Of this set, those that are dealt out before the start, and before the stop.
            first, last = (-(-(end - number) // self.scramblings) for end in (start, stop))
            if first < last:
                unit[first * self.scramblings + number - start :: self.scramblings] = self._set(number, first, last)
        t = window.time_start + unit[:, 0] * (window.time_stop - window.time_start)
        v = window.velocity_start + unit[:, 1] * (window.velocity_stop - window.velocity_start)
        return t, v

    def _set(self, number: int, start: int, stop: int) -> np.ndarray:
        """Some of the points of a set, in the unit square."""
        from scipy.stats.qmc import Sobol  # takes a second to load

        rng = self.seed if self.scramblings == 1 else np.random.SeedSequence(self.seed, spawn_key=(number,))
        sequence = Sobol(2, scramble=True, bits=_BITS, rng=np.random.default_rng(rng))
        if start > 0:
            sequence.fast_forward(start)
        # The sequence asks for powers of two. Half a step is added so that no speed is zero.
        points: np.ndarray = sequence.random(1 << (stop - start - 1).bit_length())[: stop - start]
        return points + 0.5 ** (_BITS + 1)

    def set_of(self, start: int, stop: int) -> np.ndarray:
        """Number of the set that each of some points belongs to.

        Parameters
        ----------
        start, stop : int
            Numbers of the first point and of the one after the last.

        Returns
        -------
        ndarray of int
        """
        return np.arange(start, stop) % self.scramblings

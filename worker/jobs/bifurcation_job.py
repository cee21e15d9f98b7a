"""What to compute: a bifurcation diagram, by following motions from value to value of one parameter."""

from enum import StrEnum
from functools import cached_property
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import ConfigDict, Field

from rattle_kernels import Oscillator
from worker.errors import InvalidJob
from worker.jobs.design import SweepAxis
from worker.jobs.job import AnalysisJob, Sizes
from worker.jobs.region import Departure, Region
from worker.jobs.request import INTEGRAL, Count
from worker.jobs.swept_parameter import SweptParameter, check_swept

_EXAMPLE: dict[str, Any] = {
    "kind": "bifurcation",
    "oscillator": {"model": "impacting", "eccentricity": 0.1, "half_backlash": 0.6},
    "vary": {"parameter": "damping", "start": 0.5, "stop": 0.6, "count": 1000},
    "direction": "both",
}

STARTS, SETTLING = 48, 1499
"""Departures along each axis in the search for seeds, and impacts until their motions have settled."""
# Motions that such a search seldom finds more of: at 40 oscillators with damping 0.4 to 0.8 five were found twice.
_FOUND = 4

_SEEDS_OR_REGION: dict[str, Any] = {
    "if": {"properties": {"seeds": {"type": "array"}}, "required": ["seeds"]},
    "then": {"properties": {"region": {"type": "null"}}},
}


def _ascending(values: tuple[float, ...]) -> tuple[float, ...]:
    """The values of a range upwards; of a list, sorted."""
    return tuple(sorted(values if values[:1] <= values[-1:] else values[::-1]))


class Direction(StrEnum):
    """Which way the values are visited."""

    UP = "up"
    DOWN = "down"
    BOTH = "both"
    """Up and then, from where that ends, down again."""


class BifurcationJob(AnalysisJob):
    """A bifurcation diagram: at each value the last departures after a transient, the very last seeding the next.

    Examples
    --------
    >>> import rattle
    >>> job = rattle.BifurcationJob(vary=rattle.SweptParameter("damping", (0.58, 0.59)), direction="both", kept=4)
    >>> job.vary.values, job.direction.value
    ((0.58, 0.59), 'both')
    """

    model_config = ConfigDict(title="BifurcationRequest", json_schema_extra={"examples": [_EXAMPLE]} | _SEEDS_OR_REGION)

    loose_gears = True

    kind_: Literal["bifurcation"] = "bifurcation"
    vary_: SweptParameter = Field(description="The parameter and its values")
    seeds: Annotated[list[Departure], Field(min_length=1, max_length=100)] | None = Field(
        None, description="Departures to begin with; without them, the attractors found at the first value visited"
    )
    region: Region | None = Field(None, description="Where those attractors are looked for")
    direction: Direction = Field(Direction.UP, description="both: up and then, from where that ends, down again")
    transient: Annotated[int, Field(strict=True, ge=0), INTEGRAL] = Field(
        1000, description="Impacts at each value before any departure is kept"
    )
    kept: Count = Field(20, description="Departures kept at each value")

    @property
    def fastest(self) -> float:
        """Highest speed of the region, or of the seeds."""
        return max((seed.velocity for seed in self.seeds or ()), default=(self.region or Region()).velocity.stop)

    def sizes(self) -> Sizes:
        """Sizes of the request, for limits."""
        # Seeds that are still to be found count as one.
        visits = self._visits * len(self.seeds or [None])
        return (
            ("impacts", visits * (self.transient + self.kept), "max_diagram_applications"),
            ("departures kept", visits * self.kept, "max_diagram_points"),
            ("values", self.vary_.size, "max_values"),
            *self.forcing_terms(self.vary_.size),
        )

    @property
    def impacts(self) -> int:
        """Most applications of P; where seeds are still to be found, with the search, and as many as there may be."""
        return self.impacts_together + self._motions * self._visits * (self.transient + self.kept)

    @property
    def impacts_together(self) -> int:
        """Those of the search for seeds."""
        return 0 if self.seeds else STARTS**2 * SETTLING

    @property
    def tasks_at_once(self) -> int:
        """As many as there are motions: each value needs the one before."""
        return self._motions

    @property
    def bytes(self) -> int:
        """Bytes of the store before compression: phase, speed and outcome of each departure."""
        return self._motions * self._visits * self.kept * 17

    @property
    def _motions(self) -> int:
        return len(self.seeds) if self.seeds else _FOUND

    @property
    def _visits(self) -> int:
        return self.vary_.size * (2 if self.direction == Direction.BOTH else 1)

    def _settled(self) -> dict[str, Any]:
        if self.seeds and self.region:
            raise InvalidJob("give seeds, or a region to look for attractors in, not both", ("region",))
        self.check_oscillators(self.check_oscillator)
        names = ("direction", "transient", "kept")
        vary = self.vary_.settled()
        settled = {"kind_": self.kind_, "vary_": vary if vary.is_rule else self.vary}
        settled |= {name: getattr(self, name) for name in names}
        return settled | ({"seeds": self.seeds} if self.seeds else {"region": self.region or Region()})

    @cached_property
    def vary(self) -> SweptParameter:
        """The parameter and its values in ascending order, checked."""
        ascending = SweptParameter.listed(self.vary_.parameter, _ascending(self.vary_.values))
        try:
            check_swept((ascending,), self.oscillator_.value)
        except InvalidJob as error:
            # Here `vary` is not a list.
            raise InvalidJob(str(error), tuple(part for part in error.place if part != 0)) from error
        return ascending

    def oscillator_at(self, value: float) -> Oscillator:
        """Oscillator with a value of the parameter.

        Parameters
        ----------
        value : float

        Returns
        -------
        Oscillator
        """
        return self.oscillator_.value.at(**{self.vary.parameter: value})

    @property
    def axes(self) -> tuple[SweepAxis, ...]:
        """The parameter, in ascending order."""
        return (self.vary,)

    @property
    def visits(self) -> np.ndarray:
        """Values in the order in which they are visited."""
        up = np.array(self.vary.values)
        return {Direction.UP: up, Direction.DOWN: up[::-1], Direction.BOTH: np.concatenate([up, up[::-1]])}[
            self.direction
        ]

"""What to compute: a bifurcation diagram, by following motions from value to value of one parameter."""

from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Any, ClassVar

import numpy as np

from rattle_kernels import Oscillator, OutsideDomain, check_domain, check_quiet
from worker.errors import InvalidJob, SweptOutsideDomain
from worker.jobs.analysis_job import AnalysisJob, Region, check_departure, check_region
from worker.jobs.oscillator_request import oscillator_from
from worker.jobs.swept_parameter import SweptParameter, check_swept


class Direction(StrEnum):
    """Which way the values are visited."""

    UP = "up"
    DOWN = "down"
    BOTH = "both"
    """Up and then, from where that ends, down again."""


@dataclass(frozen=True)
class BifurcationJob(AnalysisJob):
    """A diagram as in Figs. 10(a) and 11, several motions side by side.

    Parameters
    ----------
    oscillator : Oscillator
        Its own value of the parameter that varies counts for nothing: it becomes the first value.
    vary : SweptParameter
        The values, visited in ascending order going up.
    seeds : tuple of (float, float)
        Departures (t, v) to begin with at the first value visited. None: the attractors found there by starting from
        `region`, permanent contact aside.
    region : Region
        Where attractors are looked for if there are no seeds.
    direction : Direction
    transient, kept : int
        Impacts at each value before any departure is kept, and departures kept.
    """

    kind: ClassVar[str] = "bifurcation"

    vary: SweptParameter = field(default=SweptParameter("damping", (0.6,)))
    seeds: tuple[tuple[float, float], ...] = ()
    region: Region = Region()
    direction: Direction = Direction.UP
    transient: int = 1000
    kept: int = 20

    def __post_init__(self) -> None:
        values = tuple(sorted(self.vary.values))
        try:
            (swept,) = check_swept((replace(self.vary, values=values),), self.oscillator)
        except InvalidJob as error:
            raise InvalidJob(str(error), tuple(part for part in error.place if part != 0)) from error
        object.__setattr__(self, "vary", swept)
        self._check_values(check_domain)
        object.__setattr__(self, "oscillator", self.oscillator_at(swept.values[0]))
        seeds = tuple(check_departure(*seed, ("seeds", i)) for i, seed in enumerate(self.seeds))
        object.__setattr__(self, "seeds", seeds)
        object.__setattr__(self, "region", check_region(self.region))
        object.__setattr__(self, "direction", Direction(self.direction))
        if self.transient < 0 or self.kept < 1:
            place = "transient" if self.transient < 0 else "kept"
            raise InvalidJob(
                f"transient must be 0 or more and kept 1 or more, not {self.transient} and {self.kept}", (place,)
            )
        super().__post_init__()

    def oscillator_at(self, value: float) -> Oscillator:
        """Oscillator with a value of the parameter."""
        return self.oscillator._replace(**{self.vary.parameter: value})

    def _check_values(self, check: Any) -> None:
        for index, value in enumerate(self.vary.values):
            try:
                check(self.oscillator_at(value))
            except OutsideDomain as error:
                where = f"{self.vary.parameter} = {value:g}"
                raise SweptOutsideDomain(error, ("vary", "values", index), where) from error

    def demand_quiet(self) -> None:
        """Refuse a diagram of which some value has no quiet solution (Eq. 3).

        Raises
        ------
        OutsideDomain
        """
        self._check_values(check_quiet)

    @property
    def visits(self) -> np.ndarray:
        """Values in the order in which they are visited."""
        up = np.array(self.vary.values)
        return {Direction.UP: up, Direction.DOWN: up[::-1], Direction.BOTH: np.concatenate([up, up[::-1]])}[
            self.direction
        ]

    def asked(self) -> dict[str, Any]:
        """What is asked about the oscillator, as JSON."""
        start: dict[str, Any] = {"region": self.region.request()}
        if self.seeds:
            start = {"seeds": [{"time": t, "velocity": v} for t, v in self.seeds]}
        return {
            "vary": {"parameter": self.vary.parameter, "values": list(self.vary.values)},
            **start,
            "direction": self.direction.value,
            "transient": self.transient,
            "kept": self.kept,
        }

    @classmethod
    def from_request(cls, request: dict[str, Any]) -> "BifurcationJob":
        """Job that a request in the shape of `request` asks for."""
        vary = SweptParameter(request["vary"]["parameter"], tuple(request["vary"]["values"]))
        seeds = tuple((seed["time"], seed["velocity"]) for seed in request.get("seeds", ()))
        region = Region.from_request(request["region"]) if "region" in request else Region()
        return cls(
            oscillator_from(request["oscillator"]), vary, seeds, region, Direction(request["direction"]),
            request["transient"], request["kept"],
        )  # fmt: skip

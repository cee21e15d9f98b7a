"""What to compute: periodic orbits, their branches in one parameter, and curves of special points in two."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

from rattle_kernels import Oscillator
from worker.errors import InvalidJob
from worker.jobs.analysis_job import AnalysisJob, Place, Region, check_departure, check_region
from worker.jobs.oscillator_request import oscillator_from

_PARAMETERS = Oscillator._fields[:4]


class OrbitSeed(NamedTuple):
    """A departure close to a periodic orbit, and the impact period to look for."""

    time: float
    velocity: float
    period: int = 1


class Continuation(NamedTuple):
    """A parameter to follow something in, from where to where, and how many points each way at the most."""

    parameter: str
    start: float
    stop: float
    most_points: int = 2000


@dataclass(frozen=True)
class OrbitsJob(AnalysisJob):
    """Periodic orbits, stable or not: all that a search of a region finds, or those near seeds.

    Parameters
    ----------
    oscillator : Oscillator
    longest : int
        Greatest n+ that is searched for.
    region : Region
        Where it is searched.
    cells : int
        Each way: the search starts from the centre of every cell.
    seeds : tuple of OrbitSeed
        Start from these alone, without a search.
    continuation : Continuation or None
        Follow each orbit in this parameter, through folds, and locate special points.
    curves : Continuation or None
        Follow each special point in a second parameter, too.
    """

    kind: ClassVar[str] = "orbits"

    longest: int = 4
    region: Region = Region()
    cells: int = 40
    seeds: tuple[OrbitSeed, ...] = ()
    continuation: Continuation | None = None
    curves: Continuation | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, value in (("longest", self.longest), ("cells", self.cells)):
            if value < 1:
                raise InvalidJob(f"{name} must be 1 or more, not {value}", (name,))
        object.__setattr__(self, "region", check_region(self.region))
        seeds = tuple(check_orbit_seed(seed, ("seeds", i)) for i, seed in enumerate(self.seeds))
        object.__setattr__(self, "seeds", seeds)
        if self.continuation is not None:
            checked = _check_continuation(self.continuation, self.oscillator, "continuation")
            object.__setattr__(self, "continuation", checked)
        if self.curves is not None:
            object.__setattr__(self, "curves", self._check_curves(self.curves))

    def _check_curves(self, curves: Continuation) -> Continuation:
        if self.continuation is None:
            raise InvalidJob("curves start from the special points of branches: give a continuation, too", ("curves",))
        if curves.parameter == self.continuation.parameter:
            message = f"the second parameter must be another than the first, {curves.parameter}"
            raise InvalidJob(message, ("curves", "parameter"))
        return _check_continuation(curves, self.oscillator, "curves")

    def asked(self) -> dict[str, Any]:
        """What is asked about the oscillator, as JSON."""
        asked: dict[str, Any] = {"longest": self.longest, "region": self.region.request(), "cells": self.cells}
        if self.seeds:
            asked = {"seeds": [seed._asdict() for seed in self.seeds]}
        for name in ("continuation", "curves"):
            if getattr(self, name) is not None:
                asked[name] = getattr(self, name)._asdict()
        return asked

    @classmethod
    def from_request(cls, request: dict[str, Any]) -> "OrbitsJob":
        """Job that a request in the shape of `request` asks for."""
        oscillator = oscillator_from(request["oscillator"])
        continuation, curves = (
            Continuation(**request[name]) if name in request else None for name in ("continuation", "curves")
        )
        if "seeds" in request:
            seeds = tuple(OrbitSeed(**seed) for seed in request["seeds"])
            return cls(oscillator, seeds=seeds, continuation=continuation, curves=curves)
        region = Region.from_request(request["region"])
        return cls(oscillator, request["longest"], region, request["cells"], (), continuation, curves)


def check_orbit_seed(seed: OrbitSeed, place: Place) -> OrbitSeed:
    """Return the seed with its phase in [0, 1), or say what is wrong with it.

    Raises
    ------
    InvalidJob
    """
    if seed.period < 1:
        raise InvalidJob(
            f"period must be 1 or more, the number of impacts with +beta in one turn, not {seed.period}",
            (*place, "period"),
        )
    return OrbitSeed(*check_departure(seed.time, seed.velocity, place), seed.period)


def _check_continuation(asked: Continuation, oscillator: Oscillator, place: str) -> Continuation:
    if asked.parameter not in _PARAMETERS:
        message = f"{asked.parameter} is no parameter; these are: {', '.join(_PARAMETERS)}"
        raise InvalidJob(message, (place, "parameter"))
    value = getattr(oscillator, asked.parameter)
    if not (0.0 <= asked.start <= value <= asked.stop and math.isfinite(asked.stop)):
        message = f"{asked.parameter} must be followed between bounds that hold its value {value:g}"
        raise InvalidJob(f"{message}, not {asked.start:g} and {asked.stop:g}", (place,))
    if asked.most_points < 2:
        raise InvalidJob(f"most_points must be 2 or more, not {asked.most_points}", (place, "most_points"))
    return Continuation(asked.parameter, float(asked.start), float(asked.stop), asked.most_points)

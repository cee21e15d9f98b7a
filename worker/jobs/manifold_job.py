"""What to compute: stable and unstable manifolds of saddles."""

import re
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, ClassVar, NamedTuple

from rattle_kernels import CurveResolution, ManifoldLimits, check_impacting, check_limits, check_resolution
from worker.errors import InvalidJob
from worker.jobs.analysis_job import AnalysisJob, Region, check_region, check_velocity
from worker.jobs.orbits_job import OrbitSeed, check_orbit_seed
from worker.jobs.oscillator_request import oscillator_from


class Side(StrEnum):
    """Which manifolds of a saddle."""

    STABLE = "stable"
    """Departures that P takes to it."""
    UNSTABLE = "unstable"
    """Departures that come from it."""
    BOTH = "both"

    @property
    def each(self) -> tuple["Side", ...]:
        """Stable and unstable one by one."""
        return (Side.STABLE, Side.UNSTABLE) if self is Side.BOTH else (self,)


class Itinerary(NamedTuple):
    """P(m, n+, n-) of all the saddles that a search of the region finds."""

    forcing_periods: int
    upper_contacts: int
    lower_contacts: int

    @classmethod
    def from_text(cls, text: str, place: tuple[str | int, ...] = ()) -> "Itinerary":
        """Itinerary as people write it.

        Raises
        ------
        InvalidJob
        """
        found = re.fullmatch(r"P\((\d{1,4}),\s*(\d{1,4}),\s*(\d{1,4})\)", text.strip())
        if found is None or "0" in found.groups()[:2]:
            raise InvalidJob(f"an itinerary is P(m, n+, n-) with m and n+ above 0, as in P(1,1,0), not {text!r}", place)
        return cls(*(int(number) for number in found.groups()))

    @property
    def name(self) -> str:
        """As orbits are called."""
        return f"P({self.forcing_periods},{self.upper_contacts},{self.lower_contacts})"


@dataclass(frozen=True)
class ManifoldJob(AnalysisJob):
    """Manifolds of some saddles of the impacting model.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model.
    saddles : tuple of OrbitSeed and Itinerary
        Where Newton's method starts, or what the saddles are called.
    side : Side
    limits : ManifoldLimits
        How far each branch is grown.
    resolution : CurveResolution
    region : Region
        Where saddles of an itinerary are looked for.
    cells : int
        Of that search, each way.
    """

    kind: ClassVar[str] = "manifold"

    saddles: tuple[OrbitSeed | Itinerary, ...] = ()
    side: Side = Side.STABLE
    limits: ManifoldLimits = ManifoldLimits(highest_velocity=7.0)
    resolution: CurveResolution = CurveResolution()
    region: Region = Region()
    cells: int = 40

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "oscillator", check_impacting(self.oscillator))
        if not self.saddles:
            raise InvalidJob("give at least one saddle, by a seed or by its itinerary", ("saddles",))
        checked = tuple(
            check_orbit_seed(saddle, ("saddles", i)) if isinstance(saddle, OrbitSeed) else saddle
            for i, saddle in enumerate(self.saddles)
        )
        object.__setattr__(self, "saddles", checked)
        object.__setattr__(self, "side", Side(self.side))
        check_velocity(self.limits.lowest_velocity, self.limits.highest_velocity)
        try:
            check_limits(self.limits)
            object.__setattr__(self, "resolution", check_resolution(self.resolution))
        except ValueError as error:
            raise InvalidJob(str(error)) from error
        object.__setattr__(self, "region", check_region(self.region))
        if self.cells < 1:
            raise InvalidJob(f"cells must be 1 or more, not {self.cells}", ("cells",))

    def asked(self) -> dict[str, Any]:
        """What is asked about the oscillator, as JSON."""
        saddles = [
            saddle._asdict() if isinstance(saddle, OrbitSeed) else {"itinerary": saddle.name} for saddle in self.saddles
        ]
        asked: dict[str, Any] = {
            "saddles": saddles,
            "side": self.side.value,
            "arclength": self.limits.arclength,
            "velocity": {"start": self.limits.lowest_velocity, "stop": self.limits.highest_velocity},
            "most_points": self.limits.points,
            "resolution": self.resolution._asdict(),
        }
        if any(isinstance(saddle, Itinerary) for saddle in self.saddles):
            asked |= {"region": self.region.request(), "cells": self.cells}
        return asked

    @classmethod
    def from_request(cls, request: dict[str, Any]) -> "ManifoldJob":
        """Job that a request in the shape of `request` asks for."""
        saddles = tuple(
            Itinerary.from_text(saddle["itinerary"]) if "itinerary" in saddle else OrbitSeed(**saddle)
            for saddle in request["saddles"]
        )
        velocity = request["velocity"]
        limits = ManifoldLimits(request["arclength"], velocity["start"], velocity["stop"], request["most_points"])
        search = {}
        if "region" in request:
            search = {"region": Region.from_request(request["region"]), "cells": request["cells"]}
        return cls(
            oscillator_from(request["oscillator"]), saddles, Side(request["side"]), limits,
            CurveResolution(**request["resolution"]), **search,
        )  # fmt: skip

"""What the requests of analyses have in common: an oscillator, departures to start from, a region to search."""

import hashlib
import json
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

from rattle_kernels import Oscillator, check_domain, check_quiet
from worker.errors import InvalidJob
from worker.jobs.oscillator_request import oscillator_request

# Part of every digest: a store of another layout, or of kernels that answer otherwise, is another result.
RESULT_VERSION = 1
Place = tuple[str | int, ...]


class Region(NamedTuple):
    """Window of the (t, v) plane: phases within [0, 1], speeds of departure."""

    time_start: float = 0.0
    time_stop: float = 1.0
    velocity_start: float = 0.0
    velocity_stop: float = 7.0

    def request(self) -> dict[str, Any]:
        """Region as requests have it."""
        return {
            "time": {"start": self.time_start, "stop": self.time_stop},
            "velocity": {"start": self.velocity_start, "stop": self.velocity_stop},
        }

    @classmethod
    def from_request(cls, request: dict[str, Any]) -> "Region":
        """Region that a request in the shape of `request` describes."""
        return cls(*(request[axis][end] for axis in ("time", "velocity") for end in ("start", "stop")))


def check_region(region: Region, place: Place = ("region",)) -> Region:
    """Return the region with plain floats, or say what is wrong with it.

    Raises
    ------
    InvalidJob
    """
    checked = Region(*(float(value) for value in region))
    if not 0.0 <= checked.time_start < checked.time_stop <= 1.0:
        told = f"from {checked.time_start:g} to {checked.time_stop:g}"
        raise InvalidJob(f"phases of the region must ascend within 0 and 1, not run {told}", (*place, "time"))
    check_velocity(checked.velocity_start, checked.velocity_stop, (*place, "velocity"))
    return checked


def check_velocity(start: float, stop: float, place: Place = ("velocity",)) -> None:
    """Refuse a window of speeds that is none.

    Raises
    ------
    InvalidJob
    """
    if not (0.0 <= start < stop and math.isfinite(stop)):
        raise InvalidJob(f"speeds must ascend from 0 or more and be finite, not run from {start:g} to {stop:g}", place)


def check_departure(time: float, velocity: float, place: Place) -> tuple[float, float]:
    """Phase in [0, 1) and speed of a point of the section {departures from +beta}, or why it lies outside.

    Raises
    ------
    InvalidJob
    """
    if not math.isfinite(time):
        raise InvalidJob(f"the phase of a departure must be finite, not {time}", (*place, "time"))
    if not (math.isfinite(velocity) and velocity > 0.0):
        raise InvalidJob(
            f"a seed lies in the section of departures from +beta, whose speeds are above 0: {velocity:g} is none",
            (*place, "velocity"),
        )
    return float(time) - math.floor(time), float(velocity)


@dataclass(frozen=True)
class AnalysisJob(ABC):
    """A job about one oscillator.

    Raises
    ------
    InvalidJob, OutsideDomain
        Saying which parameter is at fault and what would be right.
    """

    kind: ClassVar[str]

    oscillator: Oscillator = field(default_factory=Oscillator)

    def __post_init__(self) -> None:
        object.__setattr__(self, "oscillator", check_domain(self.oscillator))

    def demand_quiet(self) -> None:
        """Refuse an oscillator that has no quiet solution (Eq. 3).

        Raises
        ------
        OutsideDomain
        """
        check_quiet(self.oscillator)

    @property
    def quiet(self) -> bool:
        """Whether there is a quiet solution."""
        try:
            self.demand_quiet()
        except ValueError:
            return False
        return True

    @property
    def places(self) -> int:
        """None: neither cells nor points of samples are computed."""
        return 0

    @abstractmethod
    def asked(self) -> dict[str, Any]:
        """What is asked about the oscillator, as JSON."""

    def request(self) -> dict[str, Any]:
        """Request that asks for this job, in the JSON shape of its route."""
        oscillator = oscillator_request(self.oscillator, quiet=self.quiet)
        return {"kind": self.kind, "oscillator": oscillator, **self.asked()}

    @cached_property
    def digest(self) -> str:
        """Hash of the request and of the version of the result: equal digests, equal bytes."""
        text = json.dumps({"request": self.request(), "version": RESULT_VERSION}, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()

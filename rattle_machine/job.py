"""What to compute: a report on a machine, with all that is asked of it."""

from collections.abc import Mapping
from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal, cast

import numpy as np
from pydantic import ConfigDict, Field, model_validator

from rattle.arguments import job_of
from rattle_kernels import expected_applications, settled_iterations
from rattle_machine.numbers import RPM
from rattle_machine.pulses import Pulses, rate_in_si
from rattle_machine.tolerances import Question, demand_proof
from worker.errors import InvalidJob
from worker.gear_pair import MACHINE, GearPair, in_si
from worker.jobs.basin_job import BasinJob
from worker.jobs.job import AnalysisJob, Sizes
from worker.jobs.request import Count, Real, Whole, in_schema
from worker.machine_series import MachineSeries
from worker.precision_limits import fastest_of

_EXAMPLE: dict[str, Any] = {
    "kind": "report",
    "machine": {
        "speed": 314.159,
        "inertia": 0.01,
        "drag_torque": 0.0942,
        "base_radius": 0.1,
        "backlash": 120e-6,
        "transmission_error": 10e-6,
    },
    "rate": 0.001,
    "size": 0.02,
    "numbers": {"backlash": [100e-6, 140e-6]},
}
# Of the threshold, and of the machine's own speed.
_NEAR_THRESHOLD, _UP_TO, _FROM = 0.98, 2.0, 0.4
# As many again, where a tolerance is tightened.
_PRODUCTIONS = 2
_LONGEST_TITLE = 200


class ReportJob(AnalysisJob):
    """A report on a machine. The oscillator is the machine's.

    Examples
    --------
    >>> from rattle_machine.job import ReportJob
    >>> job = ReportJob(
    ...     machine={"speed": 100.0, "inertia": 0.01, "drag_torque": 9.5493, "base_radius": 0.1, "backlash": 0.12,
    ...              "transmission_error": 0.01},
    ...     speeds=3,
    ... )
    >>> len(job.over.machines), job.basin.grid.time_cells
    (3, 300)
    """

    model_config = ConfigDict(title="ReportRequest", json_schema_extra={"examples": [_EXAMPLE]})

    loose_gears: ClassVar[bool] = True
    result_version: ClassVar[int] = 2  # a page that says something else needs a new one, too

    kind_: Literal["report"] = "report"
    machine_: dict[str, Any] = Field(description="As the body of `POST /v1/machines`, in place of the oscillator")
    rate: Real | str | None = Field(
        None, description="How often torque pulses come, 1/s or with its unit; with their size, or neither"
    )
    size: Real | str | list[Real] | None = Field(
        None, description="Torque pulse on the driven shaft, N m s or with its unit; or sizes that were measured"
    )
    distribution: Literal["normal", "exponential", "fixed"] | None = Field(
        None, description="Of the sizes of pulses about their size: normal by default"
    )
    pressing: Literal["bounces", "held"] = Field("bounces", description="What a pulse does that presses the teeth")
    numbers: dict[str, str | list[Real | str]] | None = Field(
        None, description='Tolerances by the numbers of the machine: "35 +- 10 um", limits, or "any" phase'
    )
    machines: Count = Field(1024, description="Most machines of the production")
    limit: Annotated[Real, in_schema(exclusiveMinimum=0, maximum=1)] = Field(
        0.99, description="Quiet share below which a machine of the production is bad"
    )
    certain: Annotated[bool, Field(strict=True)] = Field(
        False,
        description="Prove how fast teeth may part and fall quiet in every machine of the production that is tightened",
    )
    departures: Annotated[Count, in_schema(minimum=4)] = Field(
        2000, description="At each speed, and of pulses; of each machine of a production a half of them"
    )
    cells: Count = Field(300, description="Of the basin, each way")
    speeds: Annotated[Whole, in_schema(minimum=2)] = Field(16, description="At which the machine is looked at")
    seed: Annotated[Whole, in_schema(minimum=0)] = Field(0, description="Of all random numbers")
    title: str | None = Field(None, max_length=_LONGEST_TITLE, description="Of the page")

    @model_validator(mode="before")
    @classmethod
    def _with_an_oscillator(cls, given: Any) -> Any:
        """A request in which the oscillator of the machine is, if it is not there yet."""
        if not isinstance(given, Mapping) or MACHINE not in given:
            return given
        machine = given[MACHINE]
        if isinstance(machine, GearPair):
            machine = machine.as_request
        own = {} if "oscillator" in given else {"oscillator": _pair_of(machine).oscillator}
        return {**given, MACHINE: machine, **own}

    @cached_property
    def pair(self) -> GearPair:
        """The machine."""
        return _pair_of(self.machine_)

    @cached_property
    def over(self) -> MachineSeries:
        """The machine at several speeds, its own among them.

        Those beyond the threshold are looked at where impacts lose energy. Elastic ones never come to rest, so they are
        followed slowly there, and so are contacts with a mesh stiffness.
        """
        own = self.pair.speed
        speeds = np.linspace(_FROM * own, max(self._highest_speed, own), self.speeds)
        speeds[np.abs(speeds - own).argmin()] = own
        return MachineSeries.over(self.pair, "speed", [f"{value * RPM:.9g} rpm" for value in speeds])

    @cached_property
    def _highest_speed(self) -> float:
        highest = _UP_TO * self.pair.speed
        if self.pair.oscillator.restitution < 1.0:
            return highest
        return min(highest, _NEAR_THRESHOLD * self.pair.threshold_speed)

    @cached_property
    def basin(self) -> BasinJob:
        """The basin at the machine's own speed."""
        return cast(BasinJob, job_of("basin", {MACHINE: self.pair, "cells": self.cells}))

    @cached_property
    def sweep(self) -> BasinJob:
        """Samples at several speeds."""
        return cast(BasinJob, job_of("sweep", {MACHINE: self.over, "sample": self.departures, "seed": self.seed}))

    @cached_property
    def pulses(self) -> Pulses | None:
        """Torque pulses, if there are any."""
        return None if self.rate is None else self._pulses(self.departures)

    def _pulses(self, departures: int) -> Pulses:
        return Pulses.drawn(self._size, self.distribution, departures, self.seed, self.pressing)

    @cached_property
    def _size(self) -> float | list[float] | None:
        """Size of the pulses in SI. A text is never the name of a file: a request may come from anywhere."""
        if not isinstance(self.size, str):
            return self.size
        try:
            return float(in_si(self.size, "N m s"))
        except InvalidJob as error:
            raise InvalidJob(f"size: {error}, or a list of sizes that were measured", ("size",)) from None

    @cached_property
    def production(self) -> Question | None:
        """What is asked of a production, if tolerances are given."""
        if not self.numbers:
            return None
        return Question.of(
            self.pair, self.numbers, machines=self.machines, departures=max(self.departures // 2, 2), size=self._size,
            distribution=self.distribution, pressing=self.pressing, rate=self.rate, limit=self.limit, seed=self.seed,
        )  # fmt: skip

    @property
    def fastest(self) -> float:
        """Highest speed of a departure."""
        return fastest_of(self.oscillator)

    def sizes(self) -> Sizes:
        """Sizes of the request, for limits."""
        most, of_all = max(self.cells**2, self.departures), self._points * self._applications
        return (
            ("cells or departures", most, "max_cells"),
            ("speeds, or machines", max(self.speeds, self.machines if self.numbers else 0), "max_basins"),
            ("cells and departures times iterations", of_all, "max_sweep_applications"),
            *self.forcing_terms(self.speeds),
        )

    @property
    def _points(self) -> int:
        """Cells and departures that are followed."""
        produced = _PRODUCTIONS * self.machines * (self.departures // 2) if self.numbers else 0
        hit = 0 if self.rate is None else self.departures
        return self.cells**2 + self.speeds * self.departures + hit + produced

    @property
    def _applications(self) -> int:
        """Of P, for one of them, at the highest speed, where the damping is least."""
        least = self.pair.at_speed(max(self._highest_speed, self.pair.speed)).oscillator.damping
        return round(expected_applications(least, settled_iterations(least)))

    @property
    def impacts(self) -> int:
        """Most applications of P, nearly all of them side by side."""
        return self._points * self._applications

    @property
    def impacts_together(self) -> int:
        """All of them."""
        return self.impacts

    @property
    def bytes(self) -> int:
        """Most bytes while it is computed; of what is left the page is the most."""
        return self.basin.bytes + self.sweep.bytes

    def _settled(self) -> dict[str, Any]:
        if self.oscillator_.value != self.pair.oscillator:
            raise InvalidJob("give the machine or the oscillator, not both: one follows from the other", (MACHINE,))
        if (self.rate is None) != (self.size is None):
            missing = "rate" if self.rate is None else "size"
            raise InvalidJob("pulses have a rate and a size: give both, or neither", (missing,))
        if self.distribution is not None and self.size is None:
            raise InvalidJob("distribution is of the sizes of pulses: give a size", ("distribution",))
        if self.speeds < 2:
            raise InvalidJob(f"speeds must be a whole number from 2 on, not {self.speeds!r}", ("speeds",))
        if self.departures < 4:
            raise InvalidJob(f"departures must be a whole number from 4 on, not {self.departures!r}", ("departures",))
        if self.seed < 0:
            raise InvalidJob(f"seed must be a whole number from 0 on, not {self.seed!r}", ("seed",))
        settled: dict[str, Any] = {
            name: getattr(self, name) for name in ("kind_", "departures", "cells", "speeds", "seed")
        }
        settled["machine_"] = self.pair.as_request
        if self.rate is not None:
            self._pulses(2).check_pressing(self.pair)
            try:
                self.pair.check_pulses()
            except InvalidJob as error:
                raise InvalidJob(
                    f"pulses are of a quiet machine: leave out rate and size. {error}", ("rate",)
                ) from None
            settled |= {"rate": rate_in_si(self.rate), "size": self._size, "pressing": self.pressing}
            settled |= {} if self.distribution is None else {"distribution": self.distribution}
        asked = self.production
        if asked is not None:
            limits = {each.name: each.limits for each in asked.ranges}
            settled |= {"numbers": limits, "machines": self.machines, "limit": self.limit}
        if self.certain:
            if asked is None:
                message = "what is proven is of a production: give numbers, which are its tolerances"
                raise InvalidJob(message, ("certain",))
            demand_proof()
            settled["certain"] = True
        assert self.basin.basins and self.sweep.basins  # both are checked where they are made
        return settled if self.title is None else settled | {"title": self.title}


def _pair_of(machine: Any) -> GearPair:
    """Machine that JSON describes, if it is followed. It is never the name of a file."""
    if not isinstance(machine, Mapping):
        raise InvalidJob("a machine is an object, as POST /v1/machines takes it", (MACHINE,))
    try:
        pair = GearPair(**machine)
    except InvalidJob as error:
        raise InvalidJob(str(error), (MACHINE,)) from None
    return pair

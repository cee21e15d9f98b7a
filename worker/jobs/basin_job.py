"""What to compute: a basin, or one for each combination of swept parameters, on a grid of cells or on a sample."""

import hashlib
import json
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from rattle_kernels import (
    CellGrid,
    Oscillator,
    OutsideDomain,
    check_domain,
    check_grid,
    check_iterations,
    check_quiet,
    expected_applications,
    settled_iterations,
)
from worker.errors import InvalidJob, SweptOutsideDomain
from worker.jobs.oscillator_request import oscillator_from, oscillator_request
from worker.jobs.sample import Sample
from worker.jobs.swept_parameter import SweptParameter, check_swept

# Part of every digest: a store of another layout, or of kernels that answer otherwise, is another result.
RESULT_VERSION = 4

SETTLED = -1
"""In place of k: the one of `settled_iterations`."""


@dataclass(frozen=True)
class BasinJob:
    """Basins of attraction: oscillator, grid of cells, and k of ``P_corr o P^k``.

    Each combination of the swept parameters' values is a *basin*, numbered with the last parameter running fastest; one
    basin is the sweep of no parameter, of one basin.

    Parameters
    ----------
    oscillator : Oscillator
        Of either model, with its rule for permanent contact. Its swept fields count for nothing: they become the first
        value.
    grid : CellGrid
        The paper's by default. With a sample it becomes one row of as many cells as there are points.
    iterations : int
        k: 1 or a prime; SETTLED for the one that gives a settled picture at the least damping (`settled_iterations`).
    vary : tuple of SweptParameter
        None, one or two.
    sample : Sample or None
        Points to start from in place of the grid's cell centres.

    Raises
    ------
    InvalidJob, OutsideDomain
        Saying which parameter is at fault and what would be right.
    """

    oscillator: Oscillator = field(default_factory=Oscillator)
    grid: CellGrid = field(default_factory=CellGrid)
    iterations: int = SETTLED
    vary: tuple[SweptParameter, ...] = ()
    sample: Sample | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "vary", check_swept(self.vary, self.oscillator))
        object.__setattr__(self, "oscillator", self.oscillator._replace(**self.values_of(0)))
        if self.sample is not None:
            row = self.grid._replace(time_cells=self.sample.points, velocity_cells=1)
            object.__setattr__(self, "grid", row)
        try:
            object.__setattr__(self, "grid", check_grid(self.grid))
            if self.iterations != SETTLED:
                check_iterations(self.iterations)
        except ValueError as error:
            raise InvalidJob(str(error)) from error
        self._check_basins(check_domain)
        object.__setattr__(self, "oscillator", check_domain(self.oscillator))
        if self.iterations == SETTLED:
            object.__setattr__(self, "iterations", settled_iterations(self._least_damping))

    def demand_quiet(self) -> None:
        """Refuse a job in which some basin has no quiet solution (Eq. 3).

        Raises
        ------
        OutsideDomain
        """
        self._check_basins(check_quiet)

    def _check_basins(self, check: Callable[[Oscillator], Oscillator]) -> None:
        for basin in range(self.basins):
            try:
                check(self.oscillator._replace(**self.values_of(basin)))
            except OutsideDomain as error:
                if not self.vary:
                    raise
                axis, place = self._at_fault(basin, error.parameter)
                where = ", ".join(f"{name} = {value:g}" for name, value in self.values_of(basin).items())
                where = f"value {place} of {self.vary[axis].parameter} (at {where})"
                raise SweptOutsideDomain(error, ("vary", axis, "values", place), where) from error

    def _at_fault(self, basin: int, parameter: str) -> tuple[int, int]:
        """Which swept parameter, and which of its values, is to blame for a basin outside the domain."""
        names = [swept.parameter for swept in self.vary]
        axis = names.index(parameter) if parameter in names else len(names) - 1
        return axis, self.place_of(basin)[axis]

    @property
    def _least_damping(self) -> float:
        swept = [value for each in self.vary if each.parameter == "damping" for value in each.values]
        return min(swept, default=self.oscillator.damping)

    @property
    def applications(self) -> int:
        """About how many applications of P a place takes at the least damping."""
        return round(expected_applications(self._least_damping, self.iterations))

    @property
    def sweep_shape(self) -> tuple[int, ...]:
        """Values of each swept parameter; empty for one basin."""
        return tuple(len(swept.values) for swept in self.vary)

    @property
    def basins(self) -> int:
        """Number of basins."""
        return math.prod(self.sweep_shape)

    @property
    def places(self) -> int:
        """Cells, or points of samples, of all basins."""
        return self.grid.cells * self.basins

    @property
    def kind(self) -> str:
        """``basin``, or ``sweep`` where something is swept."""
        return "sweep" if self.vary else "basin"

    def place_of(self, basin: int) -> tuple[int, ...]:
        """Index of a panel's value in each swept parameter."""
        place = []
        for count in reversed(self.sweep_shape):
            basin, at = divmod(basin, count)
            place.append(at)
        return tuple(reversed(place))

    def values_of(self, basin: int) -> dict[str, float]:
        """Values of the swept parameters in a basin."""
        return {swept.parameter: swept.values[at] for swept, at in zip(self.vary, self.place_of(basin), strict=True)}

    def oscillator_of(self, basin: int) -> Oscillator:
        """Oscillator of a basin, checked."""
        return check_domain(self.oscillator._replace(**self.values_of(basin)))

    @property
    def quiet_everywhere(self) -> bool:
        """Whether every basin has a quiet solution (Eq. 3)."""
        try:
            self.demand_quiet()
        except OutsideDomain:
            return False
        return True

    def request(self) -> dict[str, Any]:
        """Request that asks for this job, in the JSON shape of ``POST /v1/basins`` or ``POST /v1/sweeps``."""
        oscillator = oscillator_request(self.oscillator, quiet=self.quiet_everywhere)
        grid = self.grid
        time: dict[str, Any] = {"start": grid.time_start, "stop": grid.time_stop}
        velocity: dict[str, Any] = {"start": grid.velocity_start, "stop": grid.velocity_stop}
        asked: dict[str, Any] = {"oscillator": oscillator, "grid": {"time": time, "velocity": velocity}}
        asked["iterations"] = self.iterations
        if self.sample is None:
            time["cells"], velocity["cells"] = grid.time_cells, grid.velocity_cells
        else:
            asked["sample"] = {"points": self.sample.points, "seed": self.sample.seed}
        if self.vary:
            asked["vary"] = [{"parameter": swept.parameter, "values": list(swept.values)} for swept in self.vary]
        return asked

    @cached_property
    def digest(self) -> str:
        """Hash of the request and of the version of the result: equal digests, equal bytes."""
        text = json.dumps({"request": self.request(), "version": RESULT_VERSION}, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()

    @classmethod
    def from_request(cls, request: dict[str, Any]) -> "BasinJob":
        """Job that a request in the shape of `request` asks for."""
        time, velocity = request["grid"]["time"], request["grid"]["velocity"]
        cells = time.get("cells", 1), velocity.get("cells", 1)
        grid = CellGrid(time["start"], time["stop"], cells[0], velocity["start"], velocity["stop"], cells[1])
        vary = tuple(SweptParameter(each["parameter"], tuple(each["values"])) for each in request.get("vary", ()))
        sample = Sample(**request["sample"]) if "sample" in request else None
        return cls(oscillator_from(request["oscillator"]), grid, request["iterations"], vary, sample)

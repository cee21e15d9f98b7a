"""What to compute: a basin, or one for each combination of swept parameters or each machine of a design.

Each has a grid of cells, or a sample of points.
"""

import math
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, ConfigDict, Field, model_validator

from rattle_kernels import CellGrid, Oscillator, OutsideDomain, expected_applications, settled_iterations
from rattle_kernels.cell_mapping.cell_grid import check_grid
from rattle_kernels.cell_mapping.iterations import check_iterations
from worker.additions import additions, asked_of, with_fields
from worker.errors import InvalidJob, SweptOutsideDomain
from worker.jobs.design import Design, SweepAxis, changes_at, check_design, is_sweep
from worker.jobs.job import Job, Sizes
from worker.jobs.request import Count, Real, Request, accepting, as_real, in_schema
from worker.jobs.sample import Sample
from worker.jobs.swept_parameter import MOST_SWEPT, SweptParameter, check_swept
from worker.precision_limits import FOLLOWED, check_window, fastest_decided, fastest_of

_BASIN_EXAMPLE: dict[str, Any] = {
    "oscillator": {"model": "impacting", "damping": 0.6, "eccentricity": 0.1, "half_backlash": 0.6},
    "grid": {"time": {"start": 0, "stop": 1, "cells": 1000}, "velocity": {"start": 0, "stop": 7, "cells": 1000}},
    "iterations": 1499,
}
_SWEEP_EXAMPLE: dict[str, Any] = {
    "oscillator": {"model": "impacting", "eccentricity": 0.1, "half_backlash": 0.6},
    "vary": [{"parameter": "damping", "start": 0.5, "stop": 0.7, "count": 21}],
    "grid": {"time": {"cells": 200}, "velocity": {"cells": 200}},
}
_DESIGN_EXAMPLE: dict[str, Any] = {
    "oscillator": {"model": "impacting", "eccentricity": 0.1},
    "design": {
        "name": "speed",
        "units": "rpm",
        "values": [800, 1000, 1200],
        "parameters": {"damping": [0.9, 0.6, 0.45], "half_backlash": [0.6, 0.6, 0.55]},
    },
    "grid": {"time": {"cells": 200}, "velocity": {"cells": 200}},
}
_ONE_OF: list[dict[str, Any]] = [
    {"required": ["vary"], "properties": {"design": {"type": "null"}}},
    {"required": ["design"], "properties": {"design": {"type": "object"}, "vary": False}},
]
# Group, period, step, solution; image cell, landing time and speed: see `worker.stores.layout`.
_BYTES_OF_LABELS, _BYTES_OF_A_CELL = 3 * 4 + 2, 8 + 2 * 8 + 3 * 4 + 2
# Longest side of a basin that is shown without levels of fewer cells.
_LONGEST_ALONE = 4000
_WINDOW = CellGrid()
# Rounding: 1.001 - 0.001 is not 1.
_PERIOD = 1.0 + 1e-12


class _Window(Request):
    start: Real
    stop: Real

    @model_validator(mode="after")
    def _ascends(self) -> Self:
        if not self.start < self.stop:
            raise ValueError(f"stop must be above start = {self.start:g}, not {self.stop:g}")
        return self


class TimeWindow(_Window):
    """Cells along time, in forcing periods; the window may cross phase 0 (from 0.9 to 1.1)."""

    start: Real = Field(_WINDOW.time_start, ge=0, lt=1)
    stop: Real = Field(_WINDOW.time_stop, gt=0, le=2)
    cells: Count = _WINDOW.time_cells

    @model_validator(mode="after")
    def _spans_at_most_a_period(self) -> Self:
        if self.stop - self.start > _PERIOD:
            raise ValueError(
                f"stop must be above start = {self.start:g} by at most one period, so {self.start + 1.0:g} or less, "
                f"not {self.stop:g}"
            )
        return self


class VelocityWindow(_Window):
    """Cells along velocity, nondimensional."""

    start: Real = Field(_WINDOW.velocity_start, ge=0)
    stop: Real = Field(_WINDOW.velocity_stop, gt=0)
    cells: Count = _WINDOW.velocity_cells


class GridRequest(Request):
    """Window of the (t, v) plane, cut into equal cells."""

    time: TimeWindow = Field(default_factory=TimeWindow)
    velocity: VelocityWindow = Field(default_factory=VelocityWindow)

    @cached_property
    def value(self) -> CellGrid:
        """Grid of the kernels, which check it."""
        time, velocity = self.time, self.velocity
        return CellGrid(time.start, time.stop, time.cells, velocity.start, velocity.stop, velocity.cells)

    def settled(self, *, with_cells: bool) -> "GridRequest":
        """The window in canonical form. It has no cells if a sample takes their place."""
        names = ("start", "stop", "cells") if with_cells else ("start", "stop")
        return GridRequest.model_construct(time=self.time.settled_to(names), velocity=self.velocity.settled_to(names))


def grid_of(grid: CellGrid) -> GridRequest:
    """A grid that Python gives, unchecked. Its cells are no part of the request where a sample takes their place."""
    named = {"start", "stop"}
    start, stop = map(as_real, grid[:2])
    time = TimeWindow.model_construct(named, start=start, stop=stop, cells=int(grid.time_cells))
    start, stop = map(as_real, grid[3:5])
    velocity = VelocityWindow.model_construct(named, start=start, stop=stop, cells=int(grid.velocity_cells))
    return GridRequest.model_construct(time=time, velocity=velocity)


Grid = Annotated[GridRequest, BeforeValidator(accepting(CellGrid, grid_of))]
"""From Python also a `CellGrid`."""


# Points take the place of cells.
_NO_CELLS = {"properties": {"cells": False}}
_SAMPLED: dict[str, Any] = {
    "if": {"properties": {"sample": {"type": "object"}}, "required": ["sample"]},
    "then": {"properties": {"grid": {"properties": {"time": _NO_CELLS, "velocity": _NO_CELLS}}}},
}
# Of several basins nothing is added.
_NOTHING_ADDED: dict[str, Any] = {"properties": {each.name: {"enum": [None, False]} for each in additions()}}


class _Fields(Job):
    # Every answer has the kind, so a request may have it, too. It is no part of the canonical form.
    kind_: Literal["basin"] = "basin"
    grid_: Grid = Field(default_factory=GridRequest)
    iterations_: Annotated[Count, in_schema(maximum=10**12)] | None = Field(
        None,
        description="k of P_corr o P^k: 1 or a prime. By default 1499 where the least damping is 0.5 or more, else the "
        "first prime from 900/damping",
    )
    sample: Sample | None = Field(None, description="Points in place of cells; leave out `cells` then")


if TYPE_CHECKING:
    _AllFields = _Fields
else:
    _AllFields = with_fields(_Fields, {each.name: each.field() for each in additions()})


class BasinJob(_AllFields):
    """One basin of attraction.

    Examples
    --------
    >>> import rattle
    >>> job = rattle.BasinJob(oscillator=rattle.Oscillator(damping=0.7), grid={"time": {"cells": 500}})
    >>> job.oscillator.damping, job.grid.time_cells, job.iterations
    (0.7, 500, 1499)
    """

    model_config = ConfigDict(title="BasinRequest", json_schema_extra={"examples": [_BASIN_EXAMPLE]} | _SAMPLED)
    result_version: ClassVar[int] = 4
    loose_gears = True

    @property
    def kind(self) -> str:
        """``basin``; a sweep is of another kind."""
        return "basin"

    @cached_property
    def vary(self) -> tuple[SweptParameter, ...]:
        """Swept parameters: none. One basin is the sweep of no parameter."""
        return ()

    @cached_property
    def grid(self) -> CellGrid:
        """Grid of the kernels. A sample is one row of as many cells as there are points."""
        grid = self.grid_.value
        if self.sample is not None:
            grid = grid._replace(time_cells=self.sample.points, velocity_cells=1)
        return grid

    @cached_property
    def iterations(self) -> int:
        """k: as requested, or large enough for a settled picture at the lowest damping."""
        return self.iterations_ or settled_iterations(self._least_damping)

    def sizes(self) -> Sizes:
        """Sizes of the request, for limits."""
        cells = self.cell_count // self.basins if self.basins else 0
        # At weak damping no cell takes all k iterations. A float cannot hold every integer.
        applications = round(
            min(cells, 10**18) * expected_applications(self._least_damping, min(self.iterations, 10**18))
        )
        return (
            ("cells or points", cells, "max_cells"),
            ("iterations", self.iterations, "max_iterations"),
            ("cells times iterations", applications, "max_applications"),
            ("basins", self.basins, "max_basins"),
            ("cells times iterations of all basins", self.basins * applications, "max_sweep_applications"),
            *self.forcing_terms(self.basins),
        )

    @property
    def impacts(self) -> int:
        """Most applications of P, those of all cells."""
        return round(self.cell_count * expected_applications(self._least_damping, self.iterations))

    @property
    def impacts_together(self) -> int:
        """All of them: cells fly side by side."""
        return self.impacts

    @property
    def bytes(self) -> int:
        """Most bytes of the store before compression."""
        # Levels have a quarter, a sixteenth ... of the cells, so a third of them or, at the edges, little more.
        of_levels = self.cell_count * _BYTES_OF_LABELS // 2 if self.has_levels else 0
        return self.cell_count * _BYTES_OF_A_CELL + of_levels

    @property
    def has_levels(self) -> bool:
        """Whether the basins are so large that they have levels of fewer cells."""
        return self.sample is None and max(self.grid.shape) > _LONGEST_ALONE

    def _settled(self) -> dict[str, Any]:
        for name, window in (("time", self.grid_.time), ("velocity", self.grid_.velocity)):
            if self.sample and "cells" in window.model_fields_set:
                raise InvalidJob(f"a sample has no cells: leave out grid.{name}.cells", ("grid", name, "cells"))
        try:
            check_grid(self.grid)
        except ValueError as error:
            raise InvalidJob(str(error)) from error
        try:
            check_iterations(self.iterations)
        except ValueError as error:
            raise InvalidJob(str(error), ("iterations",)) from error
        self.check_oscillators(self.check_oscillator)
        self._let_window_follow()
        self.check_oscillators(lambda oscillator: check_window(oscillator, self.grid, self.iterations))
        settled = {"grid_": self.grid_.settled(with_cells=self.sample is None), "iterations_": self.iterations}
        settled |= {each.name: each.check(self, self.has_levels) for each in asked_of(self)}
        return settled if self.sample is None else settled | {"sample": self.sample}

    def _let_window_follow(self) -> None:
        """Where the usual window cannot be decided, one that was not asked for ends as the machine wants it."""
        window = self.grid_.velocity
        if self.axes or "stop" in window.model_fields_set:
            return
        limit, fastest = fastest_decided(self.oscillator, self.iterations + FOLLOWED), fastest_of(self.oscillator)
        if window.stop > limit and window.start < fastest:
            velocity = VelocityWindow.model_construct(start=window.start, stop=fastest, cells=window.cells)
            self.__dict__.pop("grid", None)
            self.__dict__["grid_"] = GridRequest.model_construct(time=self.grid_.time, velocity=velocity)

    def _swept_error(self, place: tuple[int, ...], error: OutsideDomain) -> SweptOutsideDomain:
        pairs = zip(self.axes, place, strict=True)
        values = ", ".join(f"{axis.name} = {axis.values[at]:g}{_behind(axis)}" for axis, at in pairs)
        first = self.axes[0]
        if isinstance(first, Design):
            column = ("parameters", error.parameter) if error.parameter in first.columns else ("values",)
            return SweptOutsideDomain(error, ("design", *column, place[0]), f"machine {place[0]} (at {values})")
        axis = self._at_fault(error.parameter)
        where = f"value {place[axis]} of {self.axes[axis].name} (at {values})"
        return SweptOutsideDomain(error, ("vary", axis, "values", place[axis]), where)

    def _at_fault(self, parameter: str) -> int:
        """Which swept parameter puts a basin outside the domain by one of its oscillator's parameters."""
        names = [axis.name for axis in self.axes]
        return names.index(parameter) if parameter in names else len(names) - 1

    @property
    def _least_damping(self) -> float:
        return self.oscillator_.damping

    @property
    def applications(self) -> int:
        """Approximate number of applications of P for one cell at the lowest damping."""
        return round(expected_applications(self._least_damping, self.iterations))

    @property
    def sweep_shape(self) -> tuple[int, ...]:
        """Number of values along each axis; empty for one basin."""
        return ()

    @property
    def basins(self) -> int:
        """Number of basins."""
        return math.prod(self.sweep_shape)

    @property
    def cell_count(self) -> int:
        """Cells, or points of samples, of all basins."""
        time, velocity = self.grid_.time, self.grid_.velocity
        return (self.sample.points if self.sample else time.cells * velocity.cells) * self.basins

    def place_of(self, basin: int) -> tuple[int, ...]:
        """Index of a basin along each axis; the last axis runs fastest.

        Parameters
        ----------
        basin : int

        Returns
        -------
        tuple of int
        """
        place = []
        for count in reversed(self.sweep_shape):
            basin, at = divmod(basin, count)
            place.append(at)
        return tuple(reversed(place))

    def values_of(self, basin: int) -> dict[str, float]:
        """Where on the axes a basin lies: values of the swept parameters, or of the design's coordinate.

        Parameters
        ----------
        basin : int

        Returns
        -------
        dict
            Values by the axis's name.
        """
        return {axis.name: axis.values[at] for axis, at in zip(self.axes, self.place_of(basin), strict=True)}

    def oscillator_of(self, basin: int) -> Oscillator:
        """Oscillator of a basin, checked.

        Parameters
        ----------
        basin : int

        Returns
        -------
        Oscillator
        """
        return self.check_oscillator(self.oscillator_.value.at(**changes_at(self.axes, self.place_of(basin))))


def _behind(axis: SweepAxis) -> str:
    """Units of an axis as they stand behind a value."""
    return f" {axis.units}" if isinstance(axis, Design) and axis.units else ""


class SweepJob(BasinJob):
    """Basins over one or two parameters, one for each combination of their values; or those of a list of machines.

    Examples
    --------
    >>> import rattle
    >>> job = rattle.SweepJob(vary=[rattle.SweptParameter("damping", (0.5, 0.6, 0.7))])
    >>> job.basins, job.oscillator_of(1).damping
    (3, 0.6)
    >>> machines = {"damping": [0.9, 0.6], "eccentricity": [0.12, 0.1]}
    >>> job = rattle.SweepJob(design={"name": "speed", "units": "rpm", "values": [800, 1000], "parameters": machines})
    >>> job.values_of(1), job.oscillator_of(1).damping
    ({'speed': 1000.0}, 0.6)
    """

    model_config = ConfigDict(
        title="SweepRequest",
        json_schema_extra={"examples": [_SWEEP_EXAMPLE, _DESIGN_EXAMPLE], "allOf": [_NOTHING_ADDED], "oneOf": _ONE_OF}
        | _SAMPLED,
    )

    kind_: Literal["sweep"] = "sweep"  # type: ignore[assignment]
    vary_: Annotated[list[SweptParameter], Field(min_length=1, max_length=MOST_SWEPT)] = Field(
        default_factory=list, description="Swept parameters; the last one runs fastest"
    )
    design: Design | None = Field(None, description="A list of machines, in place of `vary`")

    @model_validator(mode="before")
    @classmethod
    def _steps_along_one_or_the_other(cls, request: Any) -> Any:
        if isinstance(request, dict) and "vary" in request and request.get("design") is not None:
            raise InvalidJob("give vary, or a design, not both", ("design",))
        return request

    @model_validator(mode="after")
    def _steps_along_something(self) -> Self:
        if not self.vary_ and self.design is None:
            raise InvalidJob("Field required: the swept parameters, or else a design", ("vary",))
        return self

    @property
    def kind(self) -> str:
        """``sweep``."""
        return "sweep"

    @cached_property
    def vary(self) -> tuple[SweptParameter, ...]:
        """Swept parameters with their values, checked; none if there is a design."""
        check_swept(self.vary_, self.oscillator_.value)
        return tuple(self.vary_)

    @property
    def axes(self) -> tuple[SweepAxis, ...]:
        """Swept parameters, or the design."""
        return self.vary if self.design is None else (self.design,)

    @property
    def _unchecked(self) -> Sequence[SweepAxis]:
        return self.vary_ if self.design is None else [self.design]

    @property
    def sweep_shape(self) -> tuple[int, ...]:
        """Number of values along each axis."""
        return tuple(axis.size for axis in self._unchecked)

    @property
    def _least_damping(self) -> float:
        least = (axis.least("damping") for axis in self._unchecked)
        return min((damping for damping in least if damping is not None), default=super()._least_damping)

    def _settled(self) -> dict[str, Any]:
        if self.design is None:
            settled: dict[str, Any] = {"vary_": [swept.settled() for swept in self.vary]}
        else:
            check_design(self.design, self.oscillator_.value)
            settled = {"design": self.design.settled()}
        return super()._settled() | settled


def basin_job(request: dict[str, Any], digest: str | None = None) -> BasinJob:
    """Job of a basin, or of a sweep if the request has ``vary`` or ``design``.

    Parameters
    ----------
    request : dict
        As JSON, of either kind.
    digest : str, optional
        That it was stored with; see `Job.trusted`.

    Returns
    -------
    BasinJob

    Raises
    ------
    InvalidJob, OutsideDomain
        Naming the field at fault.
    """
    job_class = SweepJob if is_sweep(request) else BasinJob
    return job_class.from_request(request) if digest is None else job_class.trusted(request, digest)

"""The window of a request, cut into cells."""

from functools import cached_property
from typing import Annotated, Self

from pydantic import BeforeValidator, Field, model_validator

from rattle_kernels import CellGrid
from worker.jobs.request import Count, Real, Request, accepting, as_real

_DEFAULT = CellGrid()
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

    start: Real = Field(_DEFAULT.time_start, ge=0, lt=1)
    stop: Real = Field(_DEFAULT.time_stop, gt=0, le=2)
    cells: Count = _DEFAULT.time_cells

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

    start: Real = Field(_DEFAULT.velocity_start, ge=0)
    stop: Real = Field(_DEFAULT.velocity_stop, gt=0)
    cells: Count = _DEFAULT.velocity_cells


class GridRequest(Request):
    """Window of the (t, v) plane, cut into equal cells."""

    time: TimeWindow = Field(default_factory=TimeWindow)
    velocity: VelocityWindow = Field(default_factory=VelocityWindow)

    @cached_property
    def value(self) -> CellGrid:
        """Grid of the kernels, which check it."""
        time, velocity = self.time, self.velocity
        return CellGrid(time.start, time.stop, time.cells, velocity.start, velocity.stop, velocity.cells)

    def settled(self, *, with_cells: bool) -> Self:
        """The window in canonical form. It has no cells if a sample takes their place."""
        names = ("start", "stop", "cells") if with_cells else ("start", "stop")
        return self.model_construct(time=self.time.settled_to(names), velocity=self.velocity.settled_to(names))


def grid_of(grid: CellGrid) -> GridRequest:
    """A grid that Python gives, unchecked. Its cells are no part of the request where a sample takes their place."""
    named = {"start", "stop"}
    time, velocity = (
        window.model_construct(named, start=as_real(start), stop=as_real(stop), cells=int(cells))
        for window, start, stop, cells in ((TimeWindow, *grid[:3]), (VelocityWindow, *grid[3:]))
    )
    return GridRequest.model_construct(time=time, velocity=velocity)


Grid = Annotated[GridRequest, BeforeValidator(accepting(CellGrid, grid_of))]
"""From Python also a `CellGrid`."""

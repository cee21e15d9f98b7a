"""The window of a request, cut into cells."""

from typing import Annotated, Self

from pydantic import BeforeValidator, Field, model_validator

from rattle_kernels import CellGrid
from worker.jobs.request import Count, Real, Request, accepting, without_sign_of_zero

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

    def to_grid(self) -> CellGrid:
        """Grid of the kernels, which check it."""
        time, velocity = self.time, self.velocity
        return CellGrid(time.start, time.stop, time.cells, velocity.start, velocity.stop, velocity.cells)


def grid_request(grid: CellGrid, *, names_cells: bool = False) -> GridRequest:
    """Grid of the kernels as requests describe it, unchecked.

    Parameters
    ----------
    grid : CellGrid
    names_cells : bool
        Whether the numbers of cells are part of the request. They are not if a sample takes the place of cells.

    Returns
    -------
    GridRequest
    """
    grid = CellGrid(*map(without_sign_of_zero, grid))
    named = {"start", "stop", "cells"} if names_cells else {"start", "stop"}
    time = TimeWindow.model_construct(named, start=grid.time_start, stop=grid.time_stop, cells=grid.time_cells)
    velocity = VelocityWindow.model_construct(
        named, start=grid.velocity_start, stop=grid.velocity_stop, cells=grid.velocity_cells
    )
    return GridRequest.model_construct(time=time, velocity=velocity)


Grid = Annotated[GridRequest, BeforeValidator(accepting(CellGrid, grid_request))]
"""From Python also a `CellGrid`."""

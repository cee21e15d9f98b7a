"""A small basin, computed at once and without a job."""

from typing import Annotated, NamedTuple

from pydantic import BeforeValidator, ConfigDict, Field

from rattle_kernels import (
    CellGrid,
    Oscillator,
    check_oscillator,
    check_quiet,
    expected_applications,
    settled_iterations,
)
from rattle_kernels.basins.preview import Preview, preview
from rattle_kernels.cell_mapping.cell_grid import check_grid
from rattle_kernels.cell_mapping.iterations import check_iterations, is_prime, nearest_primes
from rattle_kernels.numerics.pausing import Pause, never_stopped
from worker.errors import InvalidJob
from worker.jobs.basin_job import GridRequest, TimeWindow, VelocityWindow, grid_of
from worker.jobs.oscillator_request import ImpactingOscillator, OscillatorRequest, check_quiet_unless_allowed
from worker.jobs.request import Count, Request, accepting, in_schema
from worker.precision_limits import check_window

PREVIEW_CELLS = 128
"""Cells each way, unless a request says otherwise."""

# Of a settled picture's k. At a damping of 0.6 the labels are those of k = 1499 in all cells but some of chaos.
_SHARE_OF_SETTLED = 127 / 1499


class CheckedPreview(NamedTuple):
    """Oscillator, grid and k, as kernels take them."""

    oscillator: Oscillator
    grid: CellGrid
    iterations: int

    @property
    def applications(self) -> int:
        """Approximate number of applications of P for all cells."""
        return round(
            min(self.grid.cells, 10**18) * expected_applications(self.oscillator.damping, min(self.iterations, 10**18))
        )


class PreviewTimeWindow(TimeWindow):
    """Cells along time, 128 by default."""

    cells: Count = PREVIEW_CELLS


class PreviewVelocityWindow(VelocityWindow):
    """Cells along velocity, 128 by default."""

    cells: Count = PREVIEW_CELLS


class PreviewGrid(GridRequest):
    """Window of the (t, v) plane, cut into equal cells."""

    time: PreviewTimeWindow = Field(default_factory=PreviewTimeWindow)
    velocity: PreviewVelocityWindow = Field(default_factory=PreviewVelocityWindow)


class PreviewRequest(Request):
    """A small basin: the request of a basin, with fewer cells and a smaller k by default."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={"examples": [{"oscillator": {"model": "impacting", "damping": 0.6}, "iterations": 127}]},
    )

    oscillator: OscillatorRequest = Field(default_factory=ImpactingOscillator)
    grid: Annotated[PreviewGrid, BeforeValidator(accepting(CellGrid, grid_of))] = Field(default_factory=PreviewGrid)
    iterations: Annotated[Count, in_schema(maximum=10**12)] | None = Field(
        None, description="k: 1 or a prime. By default 127 where damping is 0.5 or more, else about 76/damping"
    )
    quick: Annotated[bool, Field(strict=True)] = Field(
        False,
        description="Name motions by what a few thousand impacts show: what settles later may be called chaotic, or "
        "undecided. Otherwise names are those of a job, which can take seconds",
    )

    def checked(self) -> CheckedPreview:
        """Oscillator, grid and k of the request, checked.

        Returns
        -------
        CheckedPreview

        Raises
        ------
        OutsideDomain, InvalidJob
            Naming the field at fault.
        """
        oscillator = check_oscillator(self.oscillator.value)
        check_quiet_unless_allowed(lambda: check_quiet(oscillator), allowed=self.oscillator.allow_no_quiet_solution)
        try:
            grid = check_grid(self.grid.value)
            k = check_iterations(self.iterations or _few(oscillator.damping))
        except ValueError as error:
            raise InvalidJob(str(error)) from error
        return CheckedPreview(check_window(oscillator, grid, k), grid, k)


def _few(damping: float) -> int:
    few = round(settled_iterations(damping) * _SHARE_OF_SETTLED)
    return few if is_prime(few) else nearest_primes(few)[-1]


def preview_basin(request: PreviewRequest, pause: Pause = never_stopped) -> Preview:
    """Compute the basin of a request at once.

    The solutions of its cells are those of a job with the same k, unless the request asks for quick names.

    Parameters
    ----------
    request : PreviewRequest
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    Preview
        Its catalogue lists the motions that its cells end in, and what the chaotic transients among them end in.

    Raises
    ------
    OutsideDomain, InvalidJob
        Naming what is wrong with the request.
    """
    return preview(*request.checked(), quick=request.quick, pause=pause)

"""A small basin over HTTP, answered at once."""

import base64

import numpy as np
from pydantic import BaseModel, Field

from rattle_kernels import Attractor, grazing_velocity
from service.models.viewer import DrawnSolution, PolylineView, WindowView, drawn, in_hex
from worker.basins.preview import Preview
from worker.pictures.colours import MISSING

_CURVE_POINTS = 192
_MOST_POINTS = 400
_DIGITS = 6


class PreviewView(BaseModel):
    """A small basin: its window, its motions, and the number of the motion that each cell ends in."""

    time: WindowView
    velocity: WindowView
    iterations: int = Field(description="k")
    solutions: list[DrawnSolution] = Field(description="By number")
    missing_colour: str
    grazing: PolylineView = Field(description="The grazing curve v*(t)")
    labels: str = Field(
        description="Base64 of one byte a cell: the number of its solution, row by row from the lowest speed",
        json_schema_extra={"contentEncoding": "base64"},
    )

    @classmethod
    def from_preview(cls, preview: Preview, iterations: int) -> "PreviewView":
        """View of a preview."""
        grid = preview.grid
        phases = np.linspace(grid.time_start, grid.time_stop, _CURVE_POINTS)
        curve = grazing_velocity(preview.oscillator, phases)
        return cls(
            time=WindowView(start=grid.time_start, stop=grid.time_stop, cells=grid.time_cells),
            velocity=WindowView(start=grid.velocity_start, stop=grid.velocity_stop, cells=grid.velocity_cells),
            iterations=iterations,
            solutions=drawn(tuple(_thinned(each) for each in preview.attractors), preview.shares.tolist()),
            missing_colour=in_hex(MISSING),
            grazing=PolylineView(time=phases.round(_DIGITS).tolist(), velocity=curve.round(_DIGITS).tolist()),
            labels=base64.b64encode(preview.solution.astype(np.uint8).tobytes()).decode(),
        )


def _thinned(attractor: Attractor) -> Attractor:
    if not attractor.is_chaotic:
        return attractor
    every = -(-attractor.time.size // _MOST_POINTS) or 1
    time, velocity = attractor.time[::every].round(_DIGITS), attractor.velocity[::every].round(_DIGITS)
    return attractor._replace(time=time, velocity=velocity)

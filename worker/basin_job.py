"""What to compute: one basin."""

import hashlib
import json
import math
from dataclasses import dataclass, field
from typing import Any

from rattle_kernels import CellGrid, Oscillator, OutsideDomain, check_grid, check_impacting, check_iterations
from worker.errors import InvalidJob

# Part of every digest: a store of another layout, or of kernels that answer otherwise, is another result.
RESULT_VERSION = 1


@dataclass(frozen=True)
class BasinJob:
    """A basin of attraction: oscillator, grid of cells, and k of ``P_corr o P^k``.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model.
    grid : CellGrid
        The paper's by default.
    iterations : int
        k: 1 or a prime.

    Raises
    ------
    InvalidJob
        Saying which parameter is at fault and what would be right.
    """

    oscillator: Oscillator = field(default_factory=Oscillator)
    grid: CellGrid = field(default_factory=CellGrid)
    iterations: int = 1499

    def __post_init__(self) -> None:
        try:
            object.__setattr__(self, "oscillator", check_impacting(self.oscillator))
            object.__setattr__(self, "grid", check_grid(self.grid))
            check_iterations(self.iterations)
        except OutsideDomain:
            raise
        except ValueError as error:
            raise InvalidJob(str(error)) from error

    def request(self) -> dict[str, Any]:
        """Request that asks for this job, in the JSON shape of ``POST /v1/basins``."""
        damping, eccentricity, half_backlash, stiffness, _ = self.oscillator
        oscillator = {
            "model": "impacting" if math.isinf(stiffness) else "piecewise_linear",
            "damping": damping,
            "eccentricity": eccentricity,
            "half_backlash": half_backlash,
        }
        grid = self.grid
        time = {"start": grid.time_start, "stop": grid.time_stop, "cells": grid.time_cells}
        velocity = {"start": grid.velocity_start, "stop": grid.velocity_stop, "cells": grid.velocity_cells}
        return {"oscillator": oscillator, "grid": {"time": time, "velocity": velocity}, "iterations": self.iterations}

    @property
    def digest(self) -> str:
        """Hash of the request and of the version of the result: equal digests, equal bytes."""
        text = json.dumps({"request": self.request(), "version": RESULT_VERSION}, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()

    @classmethod
    def from_request(cls, request: dict[str, Any]) -> "BasinJob":
        """Job that a request in the shape of `request` asks for."""
        oscillator = {name: value for name, value in request["oscillator"].items() if name != "model"}
        time, velocity = request["grid"]["time"], request["grid"]["velocity"]
        grid = CellGrid(
            time["start"], time["stop"], time["cells"], velocity["start"], velocity["stop"], velocity["cells"]
        )
        return cls(Oscillator(**oscillator), grid, request["iterations"])

"""What a proof takes is said before it begins: its boxes, whatever the speed of the map is."""

import pytest
import xarray as xr

from rattle_kernels import CellGrid
from rattle_proof.request import _BYTES_OF_A_BOX
from tests.watched_run import Watch, run_watched
from worker import estimate as estimates
from worker.estimate import estimate
from worker.jobs.basin_job import BasinJob


@pytest.fixture(autouse=True)
def known_speed(monkeypatch):
    monkeypatch.setattr(estimates, "measured_speed", lambda model, together: 1e6)


# Seconds of a core for a box and all that follows from it, as measured: where most cells are proven (damping 0.6), and
# where few are (damping 0.59 to 0.61). An estimate is the upper one, and no more than a busy machine explains.
EASY_BOX, HARD_BOX = 2.8e-6, 14e-6


@pytest.mark.parametrize("tolerances", [{}, {"damping": (0.59, 0.61)}])
@pytest.mark.parametrize("cores", [1, 2, 16])
def test_a_proof_takes_what_its_boxes_were_measured_to_take_shared_by_all_cores(tolerances, cores):
    plain, proven = (
        estimate(BasinJob.from_request({"grid": {"time": {"cells": 100}}, "prove": prove}), cores)
        for prove in (False, {"tolerances": tolerances})
    )
    boxes = (proven.bytes - plain.bytes) / _BYTES_OF_A_BOX
    # Eight columns for each of a thousand cells, so many rows at least, in one lattice or some that are coarser.
    assert 4096**2 <= boxes <= 2 * 8192**2
    assert EASY_BOX < (proven.seconds - plain.seconds) * cores / boxes < 2 * HARD_BOX


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_the_boxes_of_a_proof_are_counted_within_a_factor(tmp_path):
    job = BasinJob.from_request({"grid": {"time": {"cells": 16}, "velocity": {"cells": 16}}, "prove": {"levels": 0}})
    assert run_watched(job, tmp_path / "proven.zarr", Watch())
    with xr.open_zarr(tmp_path / "proven.zarr", group="proof") as proof:
        counted = max(array.size for array in proof.data_vars.values())
    plain = BasinJob.from_request({"grid": {"time": {"cells": 16}, "velocity": {"cells": 16}}})
    assert counted <= (estimate(job).bytes - estimate(plain).bytes) / _BYTES_OF_A_BOX <= 4 * counted


def test_an_estimate_counts_the_boxes_of_a_proof():
    small = CellGrid(time_cells=64, velocity_cells=64)
    plain, proven = (estimate(BasinJob(grid=small, prove=prove)) for prove in (False, True))
    assert proven.seconds > plain.seconds and proven.bytes > plain.bytes
    larger = estimate(BasinJob(grid=CellGrid(time_cells=256, velocity_cells=64), prove=True))
    # Eight columns for each cell, and rows in proportion.
    assert larger.bytes - proven.bytes == pytest.approx(15 * (proven.bytes - plain.bytes), rel=0.05)

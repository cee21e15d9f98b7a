"""Samples in place of grids: the same points for the same seed, shares those of the grid within their error."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from scipy.stats import beta

from rattle_kernels import CellGrid
from tests.worker.basins.test_pipeline import content, run
from worker.errors import InvalidJob
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.sample import Sample
from worker.jobs.swept_parameter import SweptParameter
from worker.results.opening import open_basin
from worker.results.panel import Basins, Panel
from worker.stores.solution_table import share_error

WINDOW = CellGrid(0.2, 1.2, 1, 0.0, 6.0, 1)


def test_the_shares_0_and_1_have_errors_too():
    assert share_error(np.array([[0, 1000]]), 1000) == pytest.approx(1e-3, rel=3e-3)


def test_points_lie_in_the_window_and_follow_from_the_seed():
    t, v = Sample(5000, 3).departures(WINDOW, 0, 5000)
    assert t.size == v.size == 5000
    assert t.min() >= 0.2 and t.max() < 1.2 and v.min() > 0.0 and v.max() < 6.0
    assert abs(t.mean() - 0.7) < 1e-3 and abs(v.mean() - 3.0) < 1e-2
    assert (Sample(5000, 3).departures(WINDOW, 0, 5000)[0] == t).all()
    assert (Sample(5000, 4).departures(WINDOW, 0, 5000)[0] != t).any()


def test_a_part_of_the_points_is_that_part_of_them():
    whole = Sample(3000, 1).departures(WINDOW, 0, 3000)
    part = Sample(3000, 1).departures(WINDOW, 1024, 2500)
    np.testing.assert_array_equal(part, np.array(whole)[:, 1024:2500])


@pytest.mark.parametrize("points", [0, 1 << 31])
def test_an_impossible_number_of_points_is_refused(points):
    with pytest.raises(InvalidJob, match="1 to 1073741824 points"):
        Sample(points)


def test_a_sample_of_a_basin_has_its_shares_within_their_error(client, tmp_path):
    summary = run(BasinJob(sample=Sample(6000, 1)), tmp_path / "sample.zarr", client)
    shares = {solution.name: solution.share for solution in summary.solutions}
    # Of 1000 x 1000 cells: 71.92 %, 24.84 %, 3.24 %.
    for name, share in (("permanent contact", 0.7192), ("chaotic", 0.2484), ("P(1,1,0)", 0.0324)):
        assert abs(shares[name] - share) < 4.0 * np.sqrt(share * (1.0 - share) / 6000)
    with xr.open_zarr(tmp_path / "sample.zarr") as sample:
        assert "image_cell" not in sample and "group" not in sample
        assert sample.solution.dims == sample.landing_time.dims == ("sample",) and sample.sizes["sample"] == 6000
        counted = [float((sample.solution == number).mean()) for number in range(3)]
        np.testing.assert_allclose(sample.share, counted)
        # Laplace's rule of succession, by its distribution.
        there = 6000 * np.array(counted)
        np.testing.assert_allclose(sample.share_error, beta(there + 1.0, 6000 - there + 1.0).std())
        t, v = Sample(6000, 1).departures(CellGrid(), 0, 6000)
        np.testing.assert_array_equal(sample.time, t)
        np.testing.assert_array_equal(sample.velocity, v)
        captured = (sample.landing == -2).values
        assert np.isnan(sample.landing_time.values[captured]).all() and (sample.solution.values[captured] == 0).all()


def test_points_of_a_large_sample_are_drawn_all_over_the_window(client, tmp_path):
    # Every second point of a Sobol sequence lies in one half of the window.
    location = str(tmp_path / "sample.zarr")
    run(BasinJob(iterations=1, sample=Sample(4000, 1)), location, client)
    axes = Figure().subplots()
    with open_basin(location) as basin:
        Panel(Basins(basin), 0).draw_solutions(axes)
    t, v = axes.collections[0].get_offsets().T
    quarters = np.histogram2d(t, v, bins=2, range=[[0.0, 1.0], [0.0, 7.0]])[0]
    np.testing.assert_allclose(quarters, 1000, atol=10)


def test_a_sweep_of_samples_is_the_same_twice(client, tmp_path):
    vary = (SweptParameter("damping", (0.6, 0.65)),)
    job = SweepJob(iterations=211, vary=vary, sample=Sample(400, 1))
    first = run(job, tmp_path / "one.zarr", client)
    run(job, tmp_path / "two.zarr", client)
    assert content(tmp_path / "one.zarr") == content(tmp_path / "two.zarr")
    assert all(each.standard_error is not None for basin in first.basins for each in basin.shares)
    with xr.open_zarr(tmp_path / "one.zarr") as sample:
        assert sample.solution.dims == ("damping", "sample") and sample.tile_state.dims == ("damping", "tile")

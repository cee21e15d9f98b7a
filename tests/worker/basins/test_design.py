"""A sweep over a list of machines: each basin as if computed alone; over one parameter, as that parameter swept."""

import json

import numpy as np
import pytest
import xarray as xr

from rattle_kernels import CellGrid, Oscillator
from tests.worker.basins.test_pipeline import run
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.swept_parameter import SweptParameter
from worker.pictures.figure_file import new_figure
from worker.results.opening import basin_of, job_of, open_store
from worker.results.shares import draw_shares
from worker.results.tables import table_of
from worker.stores.checking.damage import check_store

GRID = CellGrid(time_cells=24, velocity_cells=20)
DAMPINGS = 0.7, 0.5, 0.6
PARAMETERS = {"damping": DAMPINGS, "eccentricity": (0.11, 0.09, 0.1), "half_backlash": (0.6, 0.6, 0.5)}
DESIGN = {"name": "speed", "units": "rpm", "values": (800.0, 1000.0, 1200.0), "parameters": PARAMETERS}
JOB = SweepJob(grid=GRID, iterations=499, design=DESIGN)


@pytest.fixture(scope="module")
def designed(client, tmp_path_factory):
    location = tmp_path_factory.mktemp("design") / "design.zarr"
    return location, run(JOB, location, client)


def test_its_coordinate_is_the_leading_dimension_with_its_units_and_the_numbers_of_the_machines(designed):
    with open_store(str(designed[0])) as sweep:
        assert sweep.solution.dims == ("speed", "velocity", "time")
        assert sweep.speed.values.tolist() == [800.0, 1000.0, 1200.0] and sweep.speed.attrs["units"] == "rpm"
        for name, values in PARAMETERS.items():
            assert sweep[name].dims == ("speed",) and tuple(sweep[name].values) == values
        assert sweep.attrs["model"] == "impacting" and not sweep.attrs.keys() & PARAMETERS.keys()
        assert job_of(sweep) == JOB
        table = table_of(sweep, "speed")
        assert table.speed.tolist() == [800.0, 1000.0, 1200.0] and "expected_impact_power" in table


@pytest.mark.parametrize("number", range(3))
def test_each_basin_is_the_one_computed_alone(client, designed, tmp_path, number):
    machine = Oscillator(*(values[number] for values in PARAMETERS.values()))
    alone = BasinJob(oscillator=machine, grid=GRID, iterations=499)
    assert JOB.oscillator_of(number) == machine
    run(alone, tmp_path / "alone.zarr", client)
    with open_store(str(tmp_path / "alone.zarr")) as one, open_store(str(designed[0])) as many:
        same = basin_of(many, speed=DESIGN["values"][number])
        assert job_of(same).digest == alone.digest
        for name in ("image_cell", "landing_time", "landing_velocity", "group", "period", "step", "grazing_velocity"):
            np.testing.assert_array_equal(one[name].values, same[name].values)
        names = one.name.values[one.solution.values], many.name.values[same.solution.values]
        np.testing.assert_array_equal(*names)


@pytest.mark.slow
def test_of_one_parameter_it_gives_the_numbers_of_a_swept_parameter(client, tmp_path):
    """Only the name of the axis and what the request says of it differ."""
    values = (0.5, 0.6, 0.7)
    given = {"name": "level", "values": values, "parameters": {"damping": values}}
    swept = SweepJob(grid=GRID, iterations=499, vary=[SweptParameter("damping", values)])
    run(SweepJob(grid=GRID, iterations=499, design=given), tmp_path / "design.zarr", client)
    run(swept, tmp_path / "vary.zarr", client)
    with xr.open_zarr(tmp_path / "design.zarr") as design, xr.open_zarr(tmp_path / "vary.zarr") as vary:
        renamed = design.rename(level="damping")
        changed = {"change_parameter", "damping"}
        assert set(design.change_parameter.values) == {"level"} and vary.change_parameter.size
        assert renamed.data_vars.keys() == vary.data_vars.keys()
        for name in vary.variables.keys() - changed:
            assert renamed[name].dims == vary[name].dims
            np.testing.assert_array_equal(renamed[name].values, vary[name].values)


def test_its_summary_says_where_on_the_coordinate_each_basin_lies(designed):
    _, summary = designed
    assert [basin.parameters for basin in summary.basins] == [{"speed": value} for value in DESIGN["values"]]
    assert {change.parameter for change in summary.changes} <= {"speed"}
    json.dumps(summary.model_dump(mode="json"))


def test_its_chart_is_over_the_coordinate(designed):
    figure = new_figure()
    with open_store(str(designed[0])) as sweep:
        draw_shares(sweep, figure)
        gamma = sweep.assign(gamma=("speed", [0.2, 0.4, 0.6]))
        with_gamma = new_figure()
        draw_shares(gamma, with_gamma)
    assert figure.axes[-1].get_xlabel() == with_gamma.axes[-1].get_xlabel() == "speed (rpm)"
    assert len(with_gamma.axes) == len(figure.axes) + 1


def test_a_whole_store_is_whole(designed):
    assert check_store(str(designed[0])).damages == ()

"""Every kind of result can be written as netCDF: its attributes are numbers and text."""

import pytest
import xarray as xr
from matplotlib.figure import Figure

import rattle
from worker.errors import InvalidJob
from worker.results.figure import draw_basin

QUICK = {"progress": False, "workers": 1}
CELLS = {"cells": 8, "iterations": 101}
RESULTS = {
    "basin": lambda: rattle.basin(**CELLS, **QUICK),
    "basin of the piecewise linear model": lambda: rattle.basin(stiffness=1000.0, **CELLS, **QUICK),
    "sample": lambda: rattle.basin(sample=20, iterations=101, **QUICK),
    "sweep": lambda: rattle.sweep(damping=[0.6, 0.7], **CELLS, **QUICK),
    "bifurcation": lambda: rattle.bifurcation(damping=[0.55, 0.56], seeds=[(0.7641, 4.0002)], **QUICK),
    "orbits": lambda: rattle.orbits(longest=1, cells=8, **QUICK),
    "manifolds": lambda: rattle.manifolds(saddles=[(0.6017, 3.7699)], arclength=1.0, **QUICK),
    "grazing curve": lambda: rattle.grazing_curve(order=1, **QUICK),
    "trajectory": lambda: rattle.trajectory(velocity=4.0, periods=1.0),
}


@pytest.fixture(autouse=True)
def kept_here(monkeypatch, tmp_path):
    monkeypatch.setenv("RATTLE_CACHE", str(tmp_path / "cache"))


@pytest.mark.parametrize("result", RESULTS)
def test_a_result_of_any_kind_can_be_written_as_netcdf(tmp_path, result):
    found = RESULTS[result]()
    found.to_netcdf(tmp_path / "result.nc")
    with xr.open_dataset(tmp_path / "result.nc") as read:
        assert set(read.variables) == set(found.variables)
        assert read.attrs["request"] == found.attrs["request"]


def test_parameters_are_attributes_and_names_a_coordinate_and_a_sweep_is_not_drawn_as_a_basin():
    basin, sweep = RESULTS["basin"](), RESULTS["sweep"]()
    assert (basin.attrs["damping"], basin.attrs["eccentricity"], basin.attrs["half_backlash"]) == (0.6, 0.1, 0.6)
    assert "name" in basin.coords and "name" in sweep.coords
    with pytest.raises(InvalidJob, match="this is a sweep over damping: choose a basin by basin_of"):
        draw_basin(sweep, Figure().subplots())

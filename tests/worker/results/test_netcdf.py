"""A result as one file of netCDF."""

import io

import pytest
import xarray as xr

from worker.errors import InvalidJob
from worker.results import netcdf
from worker.results.opening import open_basin


def test_a_file_has_all_that_the_result_has(store):
    with open_basin(store.location) as basin:
        read = xr.open_dataset(io.BytesIO(netcdf.netcdf_of(basin, "there")))
        assert set(read.variables) == set(basin.variables)
        assert (read.solution == basin.solution).all() and read.attrs["request"] == basin.attrs["request"]


def test_one_that_would_not_fit_in_memory_says_where_it_is_read(store, monkeypatch):
    monkeypatch.setattr(netcdf, "MOST_BYTES", 1000)
    with open_basin(store.location) as basin, pytest.raises(InvalidJob, match="read the Zarr store at there"):
        netcdf.netcdf_of(basin, "there")

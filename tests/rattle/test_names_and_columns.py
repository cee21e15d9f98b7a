"""Motions are selected by name, swept parameters label axes, and tables begin with what is asked for first."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import rattle


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    store = tmp_path_factory.mktemp("named") / "sweep.zarr"
    machines = {"damping": [0.58, 0.6], "eccentricity": [0.09, 0.1, 0.11]}
    return rattle.sweep(**machines, cells=12, iterations=61, store=store, progress=False)


def test_a_map_of_shares_is_labelled_by_its_parameters(sweep):
    axes = sweep.share.sel(attractor="permanent contact").plot().axes
    assert (axes.get_ylabel(), axes.get_xlabel()) == ("damping δ", "eccentricity ε")
    plt.close("all")


def test_motions_are_selected_by_name(sweep):
    names = sweep.name.values.tolist()
    for number, name in enumerate(names):
        if names.count(name) == 1:
            np.testing.assert_array_equal(sweep.share.sel(attractor=name), sweep.share.isel(attractor=number))
    one = sweep.rattle.basin(damping=0.6, eccentricity=0.11)
    assert float(one.share.sel(attractor="permanent contact")) == float(sweep.share.values[1, 2, 0])
    heard = sweep.rattle.loudness()
    assert (heard.impact_power.sel(attractor="permanent contact") == 0.0).all()


def test_names_survive_netcdf_and_reopening(sweep, tmp_path):
    import xarray as xr

    sweep.to_netcdf(tmp_path / "sweep.nc")
    again = xr.open_dataset(tmp_path / "sweep.nc")
    np.testing.assert_array_equal(again.share.sel(attractor="P(1,1,0)"), sweep.share.sel(attractor="P(1,1,0)"))


@pytest.mark.parametrize("table", ["attractor", "share"])
def test_tables_begin_with_the_name_and_the_share_and_end_in_errors(sweep, table):
    columns = list(sweep.rattle.to_table(table).columns)
    swept = [name for name in ("damping", "eccentricity", "attractor") if table == "share"]
    leading = ["name", "share"] if table == "share" else ["name", "kind"]
    assert columns[: len(swept) + 2] == [*swept, *leading]
    ends = [column.endswith("_error") for column in columns]
    assert ends == sorted(ends), columns
    alone = list(sweep.rattle.basin(damping=0.6, eccentricity=0.1).rattle.to_table().columns)
    assert alone[:3] == ["name", "share", "kind"] and alone[-1].endswith("_error")

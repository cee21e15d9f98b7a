"""Stores written by another version of Zarr, or in an older layout, are read and gone on with."""

import shutil
import threading

import pytest
import xarray as xr

from tests.worker.stores.zarr_stores.write import GRAZING, HERE, SWEEP, write_stores
from worker.cluster.driver import Driver
from worker.kinds import KINDS
from worker.results.opening import open_basin
from worker.results.summary import summarise
from worker.rounding import FUSED
from worker.run import run_job


@pytest.fixture(scope="module")
def here(client, tmp_path_factory):
    """Stores of the Zarr that is installed."""
    folder = tmp_path_factory.mktemp("here")
    write_stores(folder, client)
    return folder


@pytest.fixture(scope="module", params=sorted(HERE.glob("*.zip")), ids=lambda archive: archive.stem)
def there(request, tmp_path_factory):
    """Stores of another Zarr, or of the same; those of layout 3, and of layout 4."""
    folder = tmp_path_factory.mktemp("there")
    shutil.unpack_archive(request.param, folder)
    return folder


def assert_same(there, here):
    """All arrays: kinds of numbers, dimensions and values; the last digits may be another processor's."""
    with xr.open_zarr(there) as theirs, xr.open_zarr(here) as ours:
        # Those of layout 3 were written before stores said what chaotic transients end in.
        ours = ours.drop_vars({"transient_ends"} & (ours.variables.keys() - theirs.variables.keys()))
        assert {name: array.dtype for name, array in theirs.variables.items()} == {
            name: array.dtype for name, array in ours.variables.items()
        }
        xr.testing.assert_allclose(theirs.drop_attrs(deep=False), ours.drop_attrs(deep=False), rtol=1e-9)
        # The archives were written before stores said how their processor rounds, and where they come from.
        later = {FUSED, "source", "creator", "license", "references", "history"}
        assert theirs.attrs.keys() | later == ours.attrs.keys() and theirs.attrs["request"] == ours.attrs["request"]


@pytest.mark.parametrize("name", ["sweep", "grazing"])
def test_a_store_of_another_zarr_holds_what_is_computed_here(there, here, name):
    assert_same(there / name, here / name)


def test_a_store_of_another_zarr_is_summed_up(there, here):
    names = [[each.name for each in summarise(str(folder / "sweep")).solutions] for folder in (there, here)]
    assert names[0] == names[1] != []
    assert KINDS[GRAZING.kind].summarise(str(there / "grazing")).complete


def test_a_job_begun_with_another_zarr_goes_on_in_its_store(client, there, here):
    begun = str(there / "begun")
    with open_basin(begun) as basin:
        assert not basin.attrs["complete"]
    run_job(SWEEP, begun, Driver(client), report=lambda _: None, cancel=threading.Event())
    assert summarise(begun).complete
    assert_same(begun, here / "sweep")

"""Libraries are loaded without looking for garbage, and nothing of the user's is changed by it."""

import gc
import subprocess
import sys
import weakref

import pytest

from rattle.loading import without_collections


class Cycle:
    """Garbage that only a look for garbage finds."""

    def __init__(self):
        self.itself = self


@pytest.fixture(autouse=True)
def nothing_frozen():
    """A service that other tests run in this process freezes what it has loaded."""
    gc.unfreeze()


def test_nothing_is_collected_meanwhile_and_everything_afterwards():
    with without_collections():
        assert not gc.isenabled()
        lost = weakref.ref(Cycle())
    assert gc.isenabled() and gc.get_freeze_count() == 0 and lost() is not None
    gc.collect()
    assert lost() is None


def test_an_error_and_a_collector_that_is_off_leave_it_as_it_was():
    gc.disable()
    try:
        with pytest.raises(ImportError), without_collections():
            raise ImportError
        assert not gc.isenabled()
    finally:
        gc.enable()


def test_what_the_user_has_frozen_stays_frozen():
    gc.freeze()
    try:
        frozen = gc.get_freeze_count()
        with without_collections():
            pass
        # Those that nobody refers to any more have gone.
        assert gc.get_freeze_count() > 0.9 * frozen
    finally:
        gc.unfreeze()


def test_a_small_basin_loads_no_dask_arrays(tmp_path):
    script = (
        "import sys, rattle\n"
        "basin = rattle.basin(cells=10, iterations=101, progress=False, store=sys.argv[1])\n"
        "basin.rattle.to_table(), basin.solution.values\n"
        "print('dask.array' in sys.modules)"
    )
    told = subprocess.run(
        [sys.executable, "-c", script, tmp_path / "small.zarr"],
        capture_output=True, text=True, check=True, timeout=300,
    )  # fmt: skip
    assert told.stdout.strip() == "False"

"""What an error says of a store that somebody removes while it is open."""

import pytest

from worker.errors import StoreFailed
from worker.jobs.basin_job import BasinJob
from worker.stores.basin_store import BasinStore


def test_a_root_that_is_gone_at_the_end_is_told_with_what_to_do(tmp_path):
    job = BasinJob.from_request({"grid": {"time": {"cells": 4}, "velocity": {"cells": 4}}, "iterations": 1})
    store = BasinStore.create_or_resume(str(tmp_path / "basin.zarr"), job)
    (tmp_path / "basin.zarr" / "zarr.json").unlink()
    with pytest.raises(StoreFailed, match="a part of it is gone; the same request computes it anew"):
        store.finish({})

"""A driver that loses its lease in mid-work writes nothing more of what only it writes, whatever the job's kind."""

import re
import threading

import pytest

from tests.analysis_requests import CHART, DIAGRAM, GRAZING, MANIFOLD, ORBITS, REPORT
from tests.object_store import BUCKET
from worker.cluster.driver import Driver
from worker.errors import LeaseLost
from worker.jobs.bifurcation_job import BifurcationJob
from worker.kinds import KINDS
from worker.progress import Stage
from worker.run import run_job
from worker.storage.location import read_file_of_store, storage_at
from worker.stores.analysis_store import AnalysisStore
from worker.stores.basin_store import BasinStore

CELLS = {"grid": {"time": {"cells": 24}, "velocity": {"cells": 20}}, "iterations": 7}
REQUESTS = {
    "basin": CELLS,
    "sweep": CELLS | {"vary": [{"parameter": "damping", "values": [0.6, 0.65, 0.7]}]},
    "bifurcation": DIAGRAM,
    "orbits": ORBITS | {"continuation": None},
    "manifold": MANIFOLD,
    "grazing_curve": GRAZING,
    "report": REPORT,
    "chart": CHART,
}


class Fence:
    """A fence that a test closes."""

    def __init__(self):
        self.lost = False

    def __call__(self):
        if self.lost:
            raise LeaseLost("another's")


@pytest.fixture(params=["folder", pytest.param("s3", marks=pytest.mark.slow)])
def root(request, tmp_path):
    """Where stores are."""
    if request.param == "folder":
        return str(tmp_path)
    server = request.getfixturevalue("object_store")
    for name, value in server.variables.items():
        request.getfixturevalue("monkeypatch").setenv(name, value)
    return f"s3://{BUCKET}/lost-leases-{re.sub(r'[^a-z0-9]', '-', request.node.name)}"


def written_by_drivers(location):
    """Every file of a store but those that tasks write: parts, tiles, and temporary files."""
    paths = [
        path for path in storage_at(location).paths() if path.endswith("zarr.json") and not path.startswith("parts/")
    ]
    return {path: read_file_of_store(location, path).content for path in paths}


@pytest.mark.parametrize("kind", KINDS)
def test_a_job_that_loses_its_lease_in_mid_work_ends_there(client, root, kind):
    job, location, fence = KINDS[kind].job_class.from_request(REQUESTS[kind]), f"{root}/{kind}.zarr", Fence()
    at_the_loss = {}

    def lose(progress):
        assert progress.stage is not Stage.DONE, "the driver went on to the end"
        if not fence.lost and progress.tiles_done >= (1 if kind in ("basin", "sweep") else 0):
            at_the_loss.update(written_by_drivers(location))
            fence.lost = True

    def run():
        driver = Driver(client)
        run_job(job, location, driver, report=lose, cancel=threading.Event(), fence=fence)

    with pytest.raises(LeaseLost):
        run()
    assert fence.lost and "zarr.json" in at_the_loss
    assert written_by_drivers(location) == at_the_loss
    store = (BasinStore if kind in ("basin", "sweep") else AnalysisStore)(location)
    assert not store.complete


def test_a_driver_of_an_analysis_that_has_lost_its_lease_writes_nothing(root):
    job, location, fence = BifurcationJob.from_request(DIAGRAM), f"{root}/diagram.zarr", Fence()
    AnalysisStore.create_or_resume(location, "a diagram", job)
    store = AnalysisStore(location, fence)
    store.write_part("seeds", {"time": [0.5]})
    before = storage_at(location).paths(), written_by_drivers(location)
    fence.lost = True
    for write in (
        lambda: store.publish((), {}),
        lambda: store.finish({}),
        store.invalidate,
        store.remove_parts,
        lambda: AnalysisStore.create_or_resume(f"{root}/new.zarr", "a diagram", job, fence),
    ):
        with pytest.raises(LeaseLost):
            write()
    assert (storage_at(location).paths(), written_by_drivers(location)) == before
    assert storage_at(f"{root}/new.zarr").paths() == [] and not store.complete

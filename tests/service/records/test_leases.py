"""Leases as a replica sees them, and what a driver does that has lost its own."""

import time

import pytest

from rattle_kernels import CellGrid
from service.records.engine import open_database
from service.records.job_record import JobState
from service.records.jobs import Jobs
from service.records.lease import Lease
from service.settings import Quotas
from tests.store_content import content
from worker.errors import LeaseLost
from worker.jobs.basin_job import BasinJob
from worker.stores.basin_store import BasinStore


@pytest.fixture
def claimed(tmp_path):
    engine, sessions = open_database(f"sqlite:///{tmp_path / 'jobs.sqlite'}")
    jobs = Jobs(sessions, Quotas(queued=10, queued_each=10, places_each=10**6))
    jobs.submit(BasinJob(grid=CellGrid(time_cells=10, velocity_cells=10), iterations=1), "local")
    yield jobs, jobs.claim("mine")
    engine.dispose()


def test_a_lease_runs_out_here_before_the_database_gives_the_job_to_another(claimed, monkeypatch):
    jobs, record = claimed
    monkeypatch.setattr("service.records.lease._MARGIN_SECONDS", 19.8)
    asked = time.monotonic()
    lease = Lease(record, asked)
    lease.check()
    time.sleep(0.25)
    assert lease.lost
    with pytest.raises(LeaseLost, match=record.id):
        lease.check()
    assert jobs.claim("another") is None


def test_a_renewed_lease_holds_and_a_lost_one_stops_the_driver(claimed, monkeypatch):
    _, record = claimed
    monkeypatch.setattr("service.records.lease._MARGIN_SECONDS", 19.5)
    lease = Lease(record, time.monotonic())
    time.sleep(0.3)
    lease.renewed(time.monotonic(), JobState.RUNNING)
    time.sleep(0.3)
    assert not lease.lost and not lease.cancel.is_set()
    lease.renewed(time.monotonic(), JobState.CANCELLING)
    assert lease.cancel.is_set()
    lease.lose()
    assert lease.lost


def test_a_driver_that_has_lost_its_lease_writes_nothing(tmp_path):
    job = BasinJob(grid=CellGrid(time_cells=10, velocity_cells=10), iterations=1)
    place = str(tmp_path / "basin.zarr")
    BasinStore.create_or_resume(place, job)

    def fence():
        raise LeaseLost("another's")

    store = BasinStore(place, fence)
    table, before = store.read_solutions(), content(place)
    (tmp_path / "basin.zarr" / "other.partial").write_text("of the driver that has the job now")
    for write in (
        lambda: store.write_ledger(store.read_ledger()),
        lambda: store.write_image_counts(store.read_image_counts()),
        lambda: store.make_room(table, 1),
        lambda: store.write_solutions(table),
        lambda: store.write_changes(()),
        lambda: store.sweep_orphans(),
        lambda: store.finish({}),
        lambda: BasinStore.create_or_resume(str(tmp_path / "new.zarr"), job, fence),
    ):
        with pytest.raises(LeaseLost):
            write()
    assert content(place) == before | {"other.partial": content(place)["other.partial"]}
    assert not store.complete and not (tmp_path / "new.zarr").exists()

"""Leases as a replica sees them, and what a driver does that has lost its own."""

import contextlib
import sqlite3
import time
from types import SimpleNamespace

import pytest

from rattle_kernels import CellGrid
from service.records.engine import open_database
from service.records.job_record import JobState
from service.records.jobs import LEASE_SECONDS, Jobs
from service.records.lease import _MARGIN_SECONDS, Lease
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


@pytest.fixture
def clock(monkeypatch):
    """This machine's clock as leases read it, set by hand."""
    clock = SimpleNamespace(now=time.monotonic())
    monkeypatch.setattr("service.records.lease.time", SimpleNamespace(monotonic=lambda: clock.now))
    return clock


def test_a_lease_runs_out_here_before_the_database_gives_the_job_to_another(claimed, clock):
    jobs, record = claimed
    lease = Lease(record, clock.now)
    clock.now += LEASE_SECONDS - _MARGIN_SECONDS - 0.1
    lease.check()
    clock.now += 0.2
    assert lease.lost
    with pytest.raises(LeaseLost, match=record.id):
        lease.check()
    assert jobs.claim("another") is None


def test_a_job_is_another_replicas_once_its_lease_has_run_out(claimed, tmp_path):
    jobs, record = claimed
    with contextlib.closing(sqlite3.connect(tmp_path / "jobs.sqlite")) as database:

        def left():
            return database.execute(
                "SELECT lease_until - (julianday('now') - 2440587.5) * 86400.0 FROM jobs"
            ).fetchone()[0]

        assert 0.0 < left() < LEASE_SECONDS + 0.01 and jobs.claim("another") is None
        assert jobs.renew([record.lease_owner])
        assert 0.0 < left() < LEASE_SECONDS + 0.01 and jobs.claim("another") is None
        with database:
            database.execute("UPDATE jobs SET lease_until = lease_until - ?", (LEASE_SECONDS,))
    assert jobs.claim("another").id == record.id


def test_a_renewed_lease_holds_and_a_lost_one_stops_the_driver(claimed, clock):
    _, record = claimed
    lease = Lease(record, clock.now)
    for _ in range(2):
        clock.now += 0.6 * (LEASE_SECONDS - _MARGIN_SECONDS)
        assert not lease.lost and not lease.cancel.is_set()
        lease.renewed(clock.now, JobState.RUNNING)
    lease.renewed(clock.now, JobState.CANCELLING)
    assert lease.cancel.is_set()
    lease.release()
    assert lease.lost


def test_a_driver_that_has_lost_its_lease_writes_nothing(tmp_path):
    job = BasinJob(grid=CellGrid(time_cells=10, velocity_cells=10), iterations=1)
    place = str(tmp_path / "basin.zarr")
    BasinStore.create_or_resume(place, job)

    def fence():
        raise LeaseLost("another's")

    store = BasinStore(place, fence)
    table, before = store.solutions.read(), content(place)
    (tmp_path / "basin.zarr" / "other.partial").write_text("of the driver that has the job now")
    for write in (
        lambda: store.write_ledger(store.read_ledger()),
        lambda: store.write_image_counts(store.read_image_counts()),
        lambda: store.solutions.make_room(table, 1),
        lambda: store.solutions.write(table),
        lambda: store.solutions.write_changes(()),
        lambda: store.sweep_orphans(),
        lambda: store.finish({}),
        lambda: BasinStore.create_or_resume(str(tmp_path / "new.zarr"), job, fence),
    ):
        with pytest.raises(LeaseLost):
            write()
    assert content(place) == before | {"other.partial": content(place)["other.partial"]}
    assert not store.complete and not (tmp_path / "new.zarr").exists()

"""Migrations, up and down, on each kind of database."""

import threading

import pytest
import sqlalchemy as sa
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext

from rattle_kernels import CellGrid
from service.records.engine import connect_database, migrate, open_database
from service.records.job_record import Base
from service.records.jobs import Jobs
from service.settings import Quotas
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.swept_parameter import SweptParameter

ROOM = Quotas(queued=10, queued_each=10, places_each=1000)
BASIN = BasinJob(grid=CellGrid(time_cells=10, velocity_cells=10), iterations=1)
SWEEP = SweepJob(grid=BASIN.grid, iterations=1, vary=(SweptParameter("damping", (0.5, 0.6)),))


@pytest.fixture
def engine(database_url):
    engine = connect_database(database_url)
    yield engine
    engine.dispose()


def rows(engine):
    """What the first schema knows of each job."""
    with engine.connect() as connection:
        return connection.execute(sa.text("SELECT number, id, digest, state, created FROM jobs ORDER BY number")).all()


def test_they_make_exactly_the_tables_that_the_code_expects(engine):
    migrate(engine)
    with engine.connect() as connection:
        assert compare_metadata(MigrationContext.configure(connection), Base.metadata) == []


def test_jobs_live_through_the_way_down_and_up(database_url, engine):
    opened, sessions = open_database(database_url)
    submitted = [Jobs(sessions, ROOM).submit(job, "local")[0] for job in (BASIN, SWEEP)]
    opened.dispose()
    before = rows(engine)
    migrate(engine, command.downgrade, "0001")
    assert rows(engine) == before
    migrate(engine)
    assert rows(engine) == before
    opened, sessions = open_database(database_url)
    jobs = Jobs(sessions, ROOM)
    assert [jobs.get(record.id).kind for record in submitted] == ["basin", "sweep"]
    assert jobs.get(submitted[1].id).request == submitted[1].request
    assert jobs.submit(SWEEP, "local")[0].id == submitted[1].id
    assert jobs.claim("replica").id == submitted[0].id
    opened.dispose()


def test_the_way_down_leaves_an_empty_database_and_the_way_up_works_again(engine):
    migrate(engine)
    migrate(engine, command.downgrade, "base")
    assert set(sa.inspect(engine).get_table_names()) <= {"alembic_version"}
    migrate(engine)
    assert rows(engine) == []


def test_replicas_that_start_together_migrate_once(database_url):
    failures, barrier = [], threading.Barrier(4)

    def start():
        barrier.wait()
        try:
            engine, sessions = open_database(database_url)
            assert Jobs(sessions, ROOM).answers()
            engine.dispose()
        except Exception as error:  # shown below
            failures.append(error)

    threads = [threading.Thread(target=start) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failures == []

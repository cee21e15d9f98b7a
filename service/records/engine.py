"""The database: its engine, its migration, its errors. Nothing here knows what a job is."""

import os
import sqlite3
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from alembic import command
from alembic.config import Config
from sqlalchemy import Engine, Float, create_engine, event, text
from sqlalchemy.engine import make_url
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.orm import Session, sessionmaker
from sqlalchemy.sql.functions import FunctionElement

DatabaseError = SQLAlchemyError
"""Any error of the database."""

_BUSY_SECONDS = 30
# PostgreSQL: seconds to wait for a server that is down; times in UTC, as in SQLite. The number
# (any would do) names the lock that makes replicas migrate one at a time if they start together.
_POSTGRESQL = {"connect_timeout": 5, "options": "-c timezone=UTC", "application_name": "gear-rattle"}
_MIGRATION_LOCK = 0x72617474
# As many connections as threads: opening and configuring one costs more than a query.
_SQLITE_CONNECTIONS = {"pool_size": 16, "max_overflow": 32}


_ONLY_READS = "rattle_only_reads"


class DatabaseGone(SQLAlchemyError):
    """The file of the database is gone, or another has taken its place: what is written would be lost."""


def to_read(session: Session) -> Session:
    """Mark a new session as read-only, so that it does not wait for writers in SQLite either.

    In SQLite each of its statements then sees the database as it is at that moment.
    """
    session.connection(execution_options={_ONLY_READS: True})
    return session


def _tune_sqlite(engine: Engine) -> None:
    """Use write-ahead logging, transactions that take the write lock at once, and only the file that was opened first.

    With SQLite's defaults, four processes that read, changed and wrote lost 226 of 256 commits without an error. And
    SQLite goes on writing to a file that was removed.
    """
    path, opened = engine.url.database, set[int]()

    @event.listens_for(engine, "connect")
    def _connected(connection: Any, _: object) -> None:
        connection.isolation_level = None
        if not opened and (number := _number_of(path)):
            opened.add(number)
        connection.execute(f"PRAGMA busy_timeout={_BUSY_SECONDS * 1000}")
        _write_ahead(connection)
        connection.execute("PRAGMA synchronous=NORMAL")

    @event.listens_for(engine, "begin")
    def _begun(connection: Any) -> None:
        if opened and _number_of(path) not in opened:
            raise DatabaseGone(
                f"the database file {Path(str(path)).name} was removed or replaced while the service ran: stop the "
                "service, put the file back from a backup, and start it again"
            )
        if not connection.get_execution_options().get(_ONLY_READS, False):
            connection.exec_driver_sql("BEGIN IMMEDIATE")


def _number_of(path: str | None) -> int | None:
    """Number of a file in its file system; None if there is none, as for a database in memory."""
    try:
        return os.stat(path).st_ino if path else None
    except OSError:
        return None


def _write_ahead(connection: Any) -> None:
    """Switch to WAL. SQLite refuses this statement at once, whatever the timeout, while another connection runs it."""
    deadline = time.monotonic() + _BUSY_SECONDS
    while True:
        try:
            connection.execute("PRAGMA journal_mode=WAL")
            return
        except sqlite3.OperationalError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.02)


def open_database(url: str) -> tuple[Engine, Callable[[], Session]]:
    """Open the database at a SQLAlchemy URL, and bring it to the newest schema.

    Parameters
    ----------
    url : str
        URL of SQLite or PostgreSQL.

    Returns
    -------
    (Engine, callable)
        The callable makes sessions.

    Raises
    ------
    DatabaseError
    """
    engine = connect_database(url)
    migrate(engine)
    return engine, sessionmaker(engine, expire_on_commit=False)


def connect_database(url: str) -> Engine:
    """Engine of the database at a SQLAlchemy URL, whatever the version of its schema."""
    parsed = make_url(url)
    if parsed.get_backend_name() == "postgresql":
        # A connection that the server has closed, for example in a restart, is replaced before use.
        return create_engine(parsed, pool_pre_ping=True, connect_args=_POSTGRESQL)
    if parsed.get_backend_name() == "sqlite" and parsed.database:
        Path(parsed.database).parent.mkdir(parents=True, exist_ok=True)
    engine = create_engine(parsed, **_SQLITE_CONNECTIONS)
    if engine.dialect.name == "sqlite":
        _tune_sqlite(engine)
    return engine


def migrate(engine: Engine, change: Callable[[Config, str], None] = command.upgrade, revision: str = "head") -> None:
    """Bring a database to a revision of its schema, in one transaction.

    Parameters
    ----------
    engine : Engine
    change : callable
        Alembic's ``upgrade`` or ``downgrade``.
    revision : str
        Number of a migration, ``head`` for the newest, or ``base`` for an empty database.
    """
    config = Config()
    config.set_main_option("script_location", str(Path(__file__).parent / "migrations"))
    with engine.begin() as connection:
        if connection.dialect.name == "postgresql":
            connection.execute(text("SELECT pg_advisory_xact_lock(:key)"), {"key": _MIGRATION_LOCK})
        config.attributes["connection"] = connection
        change(config, revision)


class database_time(FunctionElement[float]):  # noqa: N801 - named like an SQL function
    """Seconds since 1970 when the statement is executed, by the one clock that all replicas share."""

    type = Float()
    inherit_cache = True


@compiles(database_time, "sqlite")
def _sqlite(element: Any, compiler: Any, **options: Any) -> str:
    return "((julianday('now') - 2440587.5) * 86400.0)"


@compiles(database_time, "postgresql")
def _postgresql(element: Any, compiler: Any, **options: Any) -> str:
    return "EXTRACT(EPOCH FROM clock_timestamp())::double precision"

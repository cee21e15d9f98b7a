"""A PostgreSQL server of this machine's own binaries, in a folder of its own, that ends with the tests."""

import contextlib
import itertools
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import psycopg
import pytest

from tests.ports import free_port

_names = itertools.count()


def postgresql_binaries():
    """Folder of ``initdb`` and ``postgres``, or none."""
    beside_path = [Path(found).resolve().parent for found in [shutil.which("initdb")] if found]
    debian = sorted(Path("/usr/lib/postgresql").glob("*/bin"), reverse=True)
    return next((folder for folder in beside_path + debian if (folder / "postgres").exists()), None)


def demand_postgresql():
    """Folder of its binaries; skips the test where there is none, or fails it where backends must be tested."""
    folder = postgresql_binaries()
    if folder is None:
        told = "no PostgreSQL is installed (postgres and initdb, of Debian's package postgresql)"
        (pytest.fail if os.environ.get("RATTLE_TEST_BACKENDS") else pytest.skip)(told)
    return folder


class PostgreSQL:
    """A server that runs."""

    def __init__(self, host, port):
        self.host, self.port = host, port

    def url(self, database):
        """SQLAlchemy URL of a database."""
        return f"postgresql+psycopg://postgres@/{database}?host={self.host}&port={self.port}"

    def new_database(self, name=None):
        """SQLAlchemy URL of an empty database, or of the one that already has the name."""
        name = name or f"test_{os.getpid()}_{next(_names)}"
        with psycopg.connect(host=self.host, port=self.port, user="postgres", autocommit=True) as connection:
            if not connection.execute("SELECT 1 FROM pg_database WHERE datname = %s", [name]).fetchone():
                connection.execute(f'CREATE DATABASE "{name}"')
        return self.url(name)

    def new_role_with_database(self, name, password):
        """Make a role and a database of that name, which is the role's."""
        with psycopg.connect(host=self.host, port=self.port, user="postgres", autocommit=True) as connection:
            connection.execute(f"CREATE ROLE {name} LOGIN PASSWORD '{password}'")
            connection.execute(f"CREATE DATABASE {name} OWNER {name}")


@contextlib.contextmanager
def running_postgresql(listen="", port=None, on=list):
    """Run a server that listens on a socket of its own folder, and on an address where one is given.

    `on` makes a command one that is run on another host.
    """
    binaries = demand_postgresql()
    folder = Path(tempfile.mkdtemp(prefix="rattle-pg-"))  # short: a socket's path has 107 characters at the most
    data, port = folder / "data", port or free_port()
    as_postgres = []
    if os.geteuid() == 0:  # PostgreSQL does not run as root
        shutil.chown(folder, "postgres")
        as_postgres = ["runuser", "-u", "postgres", "--"]

    def call(program, *arguments):
        command = on([*as_postgres, binaries / program, *arguments])
        subprocess.run(
            command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=folder, timeout=180
        )

    try:
        call("initdb", "-D", data, "-U", "postgres", "--auth-local=trust", "--no-sync", "--encoding=UTF8")
        if listen:
            with (data / "pg_hba.conf").open("a") as rules:
                rules.write("host all all all scram-sha-256\n")
        options = f"-k {folder} -p {port} -c listen_addresses='{listen}' -c fsync=off -c timezone=Asia/Kolkata"
        call("pg_ctl", "-D", data, "-w", "-l", folder / "log", "-o", options, "start")
        try:
            yield PostgreSQL(str(folder), port)
        finally:
            call("pg_ctl", "-D", data, "-m", "immediate", "stop")
    finally:
        shutil.rmtree(folder, ignore_errors=True)

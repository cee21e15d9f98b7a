"""The one door from these tests to the code: all that a reorganisation has to adapt is here.

The rest of the folder speaks HTTP, reads files, and knows no module of the project.
"""

import contextlib
import sqlite3
from pathlib import Path

import pytest
import typer

from rattle.cli import app
from tests.running_service import running_service
from tests.service.idle_service import idle_service

DATABASE = "jobs.sqlite"


@contextlib.contextmanager
def idle(data):
    """A service that takes requests and runs none, with its data in a folder."""
    with pytest.MonkeyPatch.context() as patch, idle_service(patch, data) as service:
        yield service


def running(data):
    """A service that runs jobs, with its data in a folder."""
    return running_service(data)


def stored(data, job_id):
    """Kind, request as text, and digest of a job, as the database has them."""
    query = "SELECT kind, request, digest FROM jobs WHERE id = ?"
    with contextlib.closing(sqlite3.connect(Path(data) / DATABASE)) as database:
        kind, request, digest = database.execute(query, (job_id,)).fetchone()
    return {"kind": kind, "request": request, "digest": digest}


def store_folder(service, job):
    """Folder of a job's store."""
    return Path(service.store_of(job))


def command_line():
    """All of ``rattle`` as Click has it."""
    return typer.main.get_command(app)

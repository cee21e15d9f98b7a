"""What all tests share."""

import contextlib
import os
import subprocess
import sys

import matplotlib.pyplot as plt
import pytest
from hypothesis import settings

from rattle.cli.console import announced_compiling
from rattle_kernels import warm_up
from tests.object_store import running_object_store
from tests.postgresql import running_postgresql
from tests.running_service import BACKENDS, running_service
from tests.waiting import ended
from worker.cluster.connection import local_cluster

# Tables of commands are as wide in every terminal; asked once, when the first command is imported.
os.environ["COLUMNS"] = "200"
_COMPILE_THE_REST = "import rattle_kernels as kernels; kernels.warm_up_curves(); kernels.warm_up_analyses()"
# The first call of a kernel compiles it; the limit per test is pytest-timeout's.
settings.register_profile("rattle", deadline=None, derandomize=True)
settings.load_profile("rattle")


def pytest_configure(config):
    """Compile kernels once, before two processes and all their services would do so each for itself."""
    if getattr(config.option, "numprocesses", None) and not hasattr(config, "workerinput"):
        with announced_compiling():
            # On two cores: what analyses and curves need besides is compiled by another process meanwhile.
            rest = subprocess.Popen([sys.executable, "-c", _COMPILE_THE_REST])
            warm_up()
            assert rest.wait(600) == 0


def pytest_collection_modifyitems(items):
    """A slow test may take ten minutes, unless it says how long itself."""
    for item in items:
        if item.get_closest_marker("slow") and not item.get_closest_marker("timeout"):
            item.add_marker(pytest.mark.timeout(600))


@pytest.fixture(autouse=True, scope="session")
def kept(tmp_path_factory):
    """Folder in which results are kept, in place of the user's."""
    folder = tmp_path_factory.mktemp("kept")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RATTLE_CACHE", str(folder))
        yield folder


@pytest.fixture(autouse=True)
def closed():
    """No figure is left open."""
    yield
    plt.close("all")


@pytest.fixture(scope="session", autouse=True)
def backends():
    """With RATTLE_TEST_BACKENDS, all services of the tests keep their jobs in PostgreSQL and their results in S3."""
    with contextlib.ExitStack() as stack:
        if os.environ.get("RATTLE_TEST_BACKENDS"):
            BACKENDS.postgresql = stack.enter_context(running_postgresql())
            BACKENDS.object_store = stack.enter_context(running_object_store())
        yield BACKENDS


@pytest.fixture(scope="session")
def postgresql(backends):
    """A PostgreSQL server, shared: tests use databases of their own."""
    with contextlib.nullcontext(backends.postgresql) if backends.postgresql else running_postgresql() as server:
        yield server


@pytest.fixture(scope="session")
def object_store(backends):
    """An S3 server, shared: tests use prefixes of their own."""
    with contextlib.nullcontext(backends.object_store) if backends.object_store else running_object_store() as server:
        yield server


@pytest.fixture(scope="session")
def client(object_store):
    """Client of a cluster of two workers that find the S3 server, shared."""
    with local_cluster(workers=2) as client:
        yield client


@pytest.fixture(params=["sqlite", "postgresql"])
def database_url(request, tmp_path):
    """An empty database of each kind."""
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'jobs.sqlite'}"
    return request.getfixturevalue("postgresql").new_database()


@pytest.fixture(scope="session")
def shared_service(tmp_path_factory):
    """A running service, shared."""
    with running_service(tmp_path_factory.mktemp("service")) as service:
        yield service


@pytest.fixture(scope="module")
def service(shared_service):
    """A running service: tests submit requests of their own, and leave no job that others would wait behind."""
    yield shared_service
    for job in shared_service.request("GET", "/v1/jobs?size=200").json()["jobs"]:
        if not ended(job):
            shared_service.request("POST", job["links"]["cancel"])
            shared_service.wait(job["id"])

"""A cluster shared by the worker's tests."""

import pytest

from worker.cluster import local_cluster


@pytest.fixture(scope="session")
def client():
    with local_cluster(workers=2) as client:
        yield client

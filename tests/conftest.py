"""What all tests share."""

import pytest
from hypothesis import settings

from tests.running_service import running_service

# The first call of a kernel compiles it; the limit per test is pytest-timeout's.
settings.register_profile("rattle", deadline=None, derandomize=True)
settings.load_profile("rattle")


@pytest.fixture(scope="session")
def service(tmp_path_factory):
    """A running service, shared: tests submit requests of their own."""
    with running_service(tmp_path_factory.mktemp("service")) as service:
        yield service

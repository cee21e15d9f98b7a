"""What the benchmarks share: departures of the suite, v even in (0, 7)."""

import pytest

from benchmarks.suite.workloads import WORKLOADS, Departures
from rattle_kernels import warm_up


@pytest.fixture(scope="session", autouse=True)
def warm():
    """No benchmark times a compilation."""
    warm_up()


@pytest.fixture
def departures():
    """The first 20,000 departures of the suite, even in (0, 1) x (0, 7)."""
    return Departures(*(array[:20_000] for array in WORKLOADS["applications"].inputs))

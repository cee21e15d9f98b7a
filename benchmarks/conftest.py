"""What the benchmarks share: the initial conditions of NUMERICS, v uniform in (0, 7)."""

import numpy as np
import pytest

from rattle_kernels import warm_up


@pytest.fixture(scope="session", autouse=True)
def warm():
    """No benchmark times a compilation."""
    warm_up()


@pytest.fixture
def departures():
    """20,000 departures, uniform in (0, 1) x (0, 7)."""
    rng = np.random.default_rng(0)
    return rng.random(20_000), 7.0 * rng.random(20_000)

"""Results that tests of the front door share."""

import pytest

import rattle


@pytest.fixture(scope="session")
def basin(kept):
    """A small basin of Fig. 7."""
    return rattle.basin(cells=40, progress=False)


@pytest.fixture(scope="session")
def sweep(kept):
    """Three basins over the damping."""
    return rattle.sweep(damping=[0.55, 0.6, 0.7], cells=16, iterations=101, progress=False)

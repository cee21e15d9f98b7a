"""Results are kept in a folder of the tests, and figures are closed."""

import matplotlib.pyplot as plt
import pytest

import rattle


@pytest.fixture(autouse=True, scope="session")
def kept(tmp_path_factory):
    """Folder in which results are kept."""
    folder = tmp_path_factory.mktemp("kept")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RATTLE_CACHE", str(folder))
        yield folder


@pytest.fixture(autouse=True)
def closed():
    """No figure is left open."""
    yield
    plt.close("all")


@pytest.fixture(scope="session")
def basin(kept):
    """A small basin of Fig. 7."""
    return rattle.basin(cells=40, progress=False)


@pytest.fixture(scope="session")
def sweep(kept):
    """Three basins over the damping."""
    return rattle.sweep(damping=[0.55, 0.6, 0.7], cells=16, iterations=101, progress=False)

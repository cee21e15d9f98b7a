"""A basin of 1e10 cells over HTTP: what the page asks for, and what xarray reads, takes few chunks of its store."""

import io

import matplotlib.image
import numpy as np
import pytest
import xarray as xr

from rattle.cli.plot import figure_at_address
from service.answers.byte_range import range_of_file
from service.routes import results
from tests.large_store import LARGE, ChunksRead, label, large_store
from tests.service.idle_service import idle_service
from tests.service.routes.problems import assert_problem
from worker.results.panel import Look
from worker.storage.location import result_location
from worker.stores.pyramid import LABELS

# Labels, ledger, and one chunk of each array in the table of motions, with their points.
MOST_CHUNKS = 20
NAMES = tuple(each.name for each in LABELS)


@pytest.fixture
def service(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path, max_places_each=LARGE.cell_count) as service:
        yield service


@pytest.fixture
def address(service):
    job = service.jobs.submit(LARGE, "local")[0]
    large_store(result_location(service.results, job.id))
    return f"/v1/jobs/{job.id}"


@pytest.mark.slow
def test_the_page_and_xarray_open_1e10_cells(service, address, monkeypatch):
    read = ChunksRead(monkeypatch)
    outline = service.request("GET", f"{address}/outline").json()
    assert [level["every"] for level in outline["levels"]] == [2, 4, 8, 16, 32, 64, 128]
    last = outline["levels"][-1]
    assert (last["down"], last["across"], last["first"]) == (1, 1, 0)
    tile = service.request("GET", f"{address}/tiles/{last['first']}?level={last['level']}")
    assert tile.headers["rattle-shape"] == "782 782"
    numbers = np.arange(0, 100_000, 128)
    solution = np.frombuffer(tile.content[12 * 782**2 :], "<i2").reshape(782, 782)
    np.testing.assert_array_equal(solution, label("solution", numbers, numbers))
    assert len(read.arrays) <= MOST_CHUNKS

    picture = service.request("GET", f"{address}/picture.png")
    assert matplotlib.image.imread(io.BytesIO(picture.content)).std() > 0.1
    assert read.of_cells == 4 + 2  # the tile's four arrays, and the picture's two of the level before

    url = f"{service.url}{address}/result.zarr"
    with xr.open_zarr(url, group="pyramid/7") as level:
        np.testing.assert_array_equal(level.step, label("step", numbers, numbers))
        np.testing.assert_array_equal(level.time, LARGE.grid.time_centres()[::128])

    asked = []
    monkeypatch.setattr(results, "range_of_file", lambda *of: asked.append(of[1]) or range_of_file(*of))
    shown = figure_at_address(url, None, Look(overlays=()), shares=False).axes[0].images[0].get_array()
    assert shown.shape[:2] == (782, 782)
    of_cells = {path for path in asked if path.count("/c/") and path.split("/c/")[0].endswith(NAMES)}
    assert of_cells == {"pyramid/7/solution/c/0/0", "pyramid/7/group/c/0/0"}


def test_a_level_that_is_not_there_is_refused_with_those_that_are(service, address):
    assert_problem(service.request("GET", f"{address}/tiles/0?level=8"), 422, "levels up to 7")
    assert_problem(service.request("GET", f"{address}/tiles/5?level=7"), 404, "none of this number")

"""A motion that comes to rest has its star wherever a store's motions are listed."""

import json

import matplotlib.pyplot as plt
import numpy as np
import pytest

import rattle
from rattle_kernels import CellGrid, Oscillator
from service.models.results import OutlineView
from tests.worker.basins.made_up import QUIET, RATTLE
from worker.jobs.basin_job import BasinJob
from worker.results.summary import summarise
from worker.results.viewer import outline_basin
from worker.stores.basin_store import BasinStore
from worker.stores.layout import LABELLED, SOLUTION, TileState
from worker.stores.solution_table import SolutionTable, motion_of

NEVER_RESTS, RESTS = RATTLE._replace(lyapunov_exponent=-0.1), RATTLE._replace(lyapunov_exponent=-np.inf)
MOTIONS = QUIET, NEVER_RESTS, RESTS
NAMES = ["permanent contact", "P(1,1,0)", "P(1,1,0)*"]


@pytest.fixture
def store(tmp_path):
    """Made-up basin of a loose gear: two motions that only a rest tells apart."""
    job = BasinJob(
        oscillator=Oscillator(0.6, 0.22, 0.6, restitution=0.7), grid=CellGrid(time_cells=10, velocity_cells=10)
    )
    store = BasinStore.create_or_resume(str(tmp_path / "basin.zarr"), job)
    solution = np.full(job.grid.shape, 2, np.int16)
    store.tiles.write((*LABELLED, SOLUTION), store.tiling.tile(0), (solution,) * 4)
    table = SolutionTable.empty(job)
    numbers = [table.append(motion_of(each)) for each in MOTIONS]
    table.enter(0, numbers, MOTIONS, np.array([0.0, 0.0, 1.0]))
    store.solutions.make_room(table, 1)
    store.solutions.write_points(0, numbers, MOTIONS)
    return store, table


def test_a_star_is_seen_in_tables_summaries_pictures_and_on_the_page(store):
    store, table = store
    store.solutions.write(table)
    store.write_ledger(np.full(store.tiling.tiles, TileState.ASSEMBLED))
    store.finish({})
    assert [each.name for each in store.solutions.read().motions] == NAMES
    told = json.loads(summarise(store.location).model_dump_json())["solutions"]
    assert [each["name"] for each in told] == NAMES and told[2]["lyapunov_exponent"] is None
    page = OutlineView.from_outline(outline_basin(store.location, 0)).solutions
    assert [each.name for each in page] == NAMES
    basin = rattle.open(store.location)
    assert basin.name.values.tolist() == basin.rattle.to_table()["name"].tolist() == NAMES
    assert [each.name for each in basin.rattle.catalogue()] == NAMES
    assert (basin.rattle.cell_names() == NAMES[2]).all()
    texts = [text.get_text().split("   ")[0] for text in basin.rattle.plot().get_legend().get_texts()]
    plt.close("all")
    assert set(NAMES) <= set(texts)


def test_no_motion_has_a_star_before_its_exponent_is_known(store):
    table = store[0].solutions.read()
    listed = store[0].solutions.read_catalogue(0, table, range(3))
    assert [each.name for each in table.motions] == [each.name for each in listed] == [*NAMES[:2], NAMES[1]]

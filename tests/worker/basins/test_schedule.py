"""What a schedule does as the solutions of a basin become known."""

import numpy as np

from rattle_kernels import CellGrid
from rattle_kernels.attractors.attractor import UNDECIDED_ATTRACTOR
from tests.worker.basins.made_up import QUIET, RATTLE
from worker.basins.ledger import Ledger
from worker.basins.schedule import Schedule
from worker.basins.tasks import assemble_basin, label_tile, map_tile, write_points
from worker.cluster.calls import Task
from worker.jobs.basin_job import BasinJob
from worker.stores.basin_store import BasinStore
from worker.stores.layout import TileState

NOTHING = Task(map_tile, 0)


def drained(schedule):
    return list(iter(schedule.next_task, None))


def test_attractors_that_the_first_basin_finds_late_have_numbers_and_shares(tmp_path):
    job = BasinJob(grid=CellGrid(time_cells=128, velocity_cells=128), iterations=1)
    store = BasinStore.create_or_resume(str(tmp_path / "basin.zarr"), job)
    ledger = Ledger(store)
    schedule = Schedule(store, ledger, 4)
    assert {task.function for task in drained(schedule)} == {map_tile}
    (basin,) = schedule.basins.values()
    writes = []
    for attractors in ((QUIET, RATTLE), (QUIET, RATTLE, UNDECIDED_ATTRACTOR)):
        basin.attractors = attractors
        schedule.take(NOTHING, None)
        writes += drained(schedule)
    assert [task.function for task in writes] == [write_points] * 2 and ledger.basins == 0
    basin.counts, basin.solved = np.array([[128 * 64, 128 * 32, 128 * 32]]), True
    for task in writes:
        schedule.take(task, None)
    assert not drained(schedule)
    assert ledger.basins == 1 and schedule.basins == {}
    assert ledger.table.share.tolist() == [[0.5, 0.25, 0.25]]
    assert (ledger.states == TileState.ASSEMBLED).all()


def test_tasks_that_a_receipt_makes_possible_do_not_wait_for_numbers(tmp_path):
    job = BasinJob(grid=CellGrid(time_cells=128, velocity_cells=128), iterations=1)
    store = BasinStore.create_or_resume(str(tmp_path / "basin.zarr"), job)
    ledger = Ledger(store)
    schedule = Schedule(store, ledger, 4)
    drained(schedule)
    (basin,) = schedule.basins.values()
    label = Task(label_tile, 0)

    def take_catalogue(number, receipt):
        basin.attractors = receipt
        return [label]

    schedule.take(Task(assemble_basin, 0, then=take_catalogue), (QUIET, RATTLE))
    assert schedule.next_task() is label and not ledger.table.motions
    schedule.take(label, None)
    assert len(ledger.table.motions) == 2
    assert [task.function for task in drained(schedule)] == [write_points]

"""One basin under way: takes the receipts of its tasks and says which come next.

    map tiles -> assemble -> label tiles -> ... -> its solutions are known
                                 ^       |
                                 +-------+ the catalogue is extended by landing points that arrived at none of it

Nothing here depends on other basins, nor on the order in which receipts come.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from rattle_kernels import Attractor, AttractorKind
from rattle_kernels.attractors.attractor import UNDECIDED_ATTRACTOR
from rattle_kernels.attractors.seeds import Seeds, gather_seeds
from worker.basins.tasks import (
    CatalogueReceipt,
    LabelReceipt,
    MapReceipt,
    assemble_basin,
    extend_catalogue,
    label_tile,
    map_tile,
    survey_tile,
)
from worker.cluster.task import Task
from worker.progress import Stage
from worker.stores.basin_store import BasinStore
from worker.stores.layout import TileState

# How often the catalogue is extended by landing points that arrived at none of its attractors, before they are called
# undecided.
_CATALOGUE_ROUNDS = 3


class BasinRun:
    """A basin under way.

    Parameters
    ----------
    store : BasinStore
    number : int
    states : ndarray of uint8, or dict
        States of its tiles, by their numbers; what has been computed is surveyed, not computed again.
    numbered : bool
        Whether the panel's own catalogue has the numbers that all basins share, as that of the first basin has.
    """

    def __init__(
        self, store: BasinStore, number: int, states: np.ndarray | dict[int, TileState], *, numbered: bool
    ) -> None:
        self.store, self.number, self.numbered = store, number, numbered
        self.attractors: tuple[Attractor, ...] = ()
        self.counts = np.zeros(0, np.int64)
        self.reserved = np.zeros(3, np.int64)
        self.solved = False
        self._tiles = store.tiling.numbers_of(number)
        self._states = states
        self._words = np.zeros(-(-store.job.grid.cells // 64), np.uint64)
        self._seeds: dict[int, Seeds] = {}
        self._labels: dict[int, LabelReceipt] = {}
        self._round = 0
        self._assembling = False

    def begin(self) -> list[Task]:
        """Map what is missing, survey what is there."""
        # From the top: low departures are captured soon, so that the last tiles are light and the workers end together.
        return [
            Task(map_tile if self._states[tile] < TileState.COMPUTED else survey_tile, tile, self.number)
            for tile in reversed(self._tiles)
        ]

    def adopt(self, attractors: tuple[Attractor, ...], counts: np.ndarray, reserved: np.ndarray) -> None:
        """Take over what the basin is found to be where one task has done all of it."""
        self.attractors, self.counts, self.reserved, self.solved = attractors, counts, reserved, True

    @property
    def stage(self) -> Stage:
        """What it does at the moment."""
        if self.attractors or self.solved:
            return Stage.LABELLING
        return Stage.ASSEMBLING if self._assembling else Stage.MAPPING

    @property
    def tiles_done(self) -> int:
        """Tiles that have passed that stage."""
        if self.solved:
            return len(self._tiles)
        return len(self._labels) if self.attractors else len(self._seeds)

    def take(self, task: Task, receipt: Any) -> list[Task]:
        """Tasks that can be done now that one has been."""
        taken_by: dict[Callable[..., Any], Callable[[int, Any], list[Task]]] = {
            map_tile: self._mapped,
            survey_tile: self._mapped,
            assemble_basin: self._catalogued,
            extend_catalogue: self._extended,
            label_tile: self._labelled,
        }
        return taken_by[task.function](task.number, receipt)

    def _mapped(self, tile: int, receipt: MapReceipt) -> list[Task]:
        self._words[receipt.image_set.number] |= receipt.image_set.word
        self._seeds[tile] = receipt.seeds
        self.reserved += receipt.reserved
        if len(self._seeds) < len(self._tiles):
            return []
        if self.store.job.sample is None:
            self.store.write_image_words(self.number, self._words)
        # In the order of tiles, so that nothing depends on timing.
        seeds = gather_seeds([self._seeds[tile] for tile in self._tiles])
        self._seeds.clear()
        self._assembling = True
        return [Task(assemble_basin, self.number, self.number, (seeds,))]

    def _catalogued(self, _: int, receipt: CatalogueReceipt) -> list[Task]:
        undecided = self.reserved[2] > 0
        return self._label(_with_undecided(receipt.attractors) if undecided else receipt.attractors)

    def _label(self, attractors: tuple[Attractor, ...]) -> list[Task]:
        """Label every tile anew: labels of an earlier catalogue are void."""
        self.attractors = attractors
        self._labels.clear()
        arguments = attractors, self.numbered
        return [Task(label_tile, tile, self.number, arguments) for tile in reversed(self._tiles)]

    def _labelled(self, tile: int, receipt: LabelReceipt) -> list[Task]:
        self._labels[tile] = receipt
        if len(self._labels) < len(self._tiles):
            return []
        self.counts = np.sum([label.counts for label in self._labels.values()], axis=0)
        unassigned = gather_seeds([self._labels[tile].unassigned for tile in self._tiles])
        self._round += 1
        if unassigned.box.size and self._round < _CATALOGUE_ROUNDS:
            return [Task(extend_catalogue, self.number, self.number, (self.attractors, unassigned))]
        return self._relabel(_with_undecided(self.attractors) if unassigned.box.size else self.attractors)

    def _extended(self, _: int, receipt: CatalogueReceipt) -> list[Task]:
        more = len(receipt.attractors) > len(self.attractors)
        return self._relabel(receipt.attractors if more else _with_undecided(self.attractors))

    def _relabel(self, attractors: tuple[Attractor, ...]) -> list[Task]:
        self.solved = len(attractors) == len(self.attractors)
        return [] if self.solved else self._label(attractors)


def _with_undecided(attractors: tuple[Attractor, ...]) -> tuple[Attractor, ...]:
    known = any(attractor.kind == AttractorKind.UNDECIDED for attractor in attractors)
    return attractors if known else (*attractors, UNDECIDED_ATTRACTOR)

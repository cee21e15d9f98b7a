"""One basin in progress: it takes the receipts of its tasks and returns the tasks that come next.

    (weigh ->) map tiles -> assemble -> label tiles -> ... -> its solutions are known
                                          ^       |
                                          +-------+ extended by landing points that reached no attractor

Nothing here depends on other basins, or on the order in which receipts arrive.
"""

from collections import defaultdict
from collections.abc import Callable, Container
from functools import partial

import numpy as np

from rattle_kernels import Attractor
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
    weigh_tiles,
)
from worker.basins.weights import worth_weighing
from worker.cluster.calls import Task
from worker.progress import Stage
from worker.stores.basin_store import BasinStore
from worker.stores.layout import TileState


class BasinRun:
    """A basin in progress.

    Parameters
    ----------
    store : BasinStore
    number : int
    mapped : container of int
        Tiles whose images are in the store. They are surveyed, not computed again.
    numbered : bool
        Whether the numbers of the basin's own catalogue are those that all basins share. True of the first basin.
    set_state : callable
        ``set_state(tile, state)`` is called when a tile reaches a state.

    Attributes
    ----------
    attractors : tuple of Attractor
        The basin's own catalogue, empty until it is known.
    counts : ndarray of int, shape (sets, attractors)
        Number of cells, or points of each set of a sample, that end in each attractor.
    reserved : ndarray of int, shape (3,)
        Number of cells with the images -1, -2 and -3.
    solved : bool
        Whether all tiles have their final labels.
    seconds : dict of str to float
        Time spent in kernels.
    """

    def __init__(
        self, store: BasinStore, number: int, mapped: Container[int], *, numbered: bool,
        set_state: Callable[[int, TileState], None] = lambda tile, state: None,
    ) -> None:  # fmt: skip
        self.store, self.number, self.numbered = store, number, numbered
        self.attractors: tuple[Attractor, ...] = ()
        self.counts = np.zeros((1, 0), np.int64)
        self.reserved = np.zeros(3, np.int64)
        self.solved = False
        self._tiles = store.tiling.numbers_of(number)
        self._mapped, self._set_state = mapped, set_state
        self.seconds: dict[str, float] = defaultdict(float)
        self._task = partial(Task, priority=number)
        self._words = np.zeros(-(-store.job.grid.cells // 64), np.uint64)
        self._seeds: dict[int, Seeds] = {}
        self._labels: dict[int, LabelReceipt] = {}
        self._rounds = 0
        self._assembling = False

    def begin(self) -> list[Task]:
        """Tasks that map the missing tiles, and survey those in the store."""
        # From the top. Low departures are captured early, so the last tiles are quick and all workers end together.
        from_the_top = list(reversed(self._tiles))
        # Workers have the uppermost tiles until the others have been weighed.
        later = [tile for tile in from_the_top[self.store.tiling.shape[1] :] if tile not in self._mapped]
        if not worth_weighing(self.store.job, len(later)):
            return self._map(from_the_top)
        weighing = self._task(weigh_tiles, self.number, (later,), partial(self._take_weights, later))
        return [weighing, *self._map([tile for tile in from_the_top if tile not in later])]

    def _map(self, tiles: list[int]) -> list[Task]:
        return [
            self._task(survey_tile if tile in self._mapped else map_tile, tile, then=self._take_images)
            for tile in tiles
        ]

    def _take_weights(self, tiles: list[int], _: int, weights: list[int]) -> list[Task]:
        weight_of = dict(zip(tiles, weights, strict=True))
        return self._map(sorted(tiles, key=weight_of.__getitem__, reverse=True))

    def take_over(
        self, attractors: tuple[Attractor, ...], counts: np.ndarray, reserved: np.ndarray, seconds: dict[str, float]
    ) -> None:
        """Take over the results of a basin that a single task has solved."""
        self.attractors, self.counts, self.reserved, self.seconds = attractors, counts, reserved, seconds
        self.solved = True

    @property
    def stage(self) -> Stage:
        """Current stage."""
        if self.attractors or self.solved:
            return Stage.LABELLING
        return Stage.ASSEMBLING if self._assembling else Stage.MAPPING

    @property
    def tiles_done(self) -> int:
        """Number of tiles that have passed the current stage."""
        if self.solved:
            return len(self._tiles)
        return len(self._labels) if self.attractors else len(self._seeds)

    def _take_images(self, tile: int, receipt: MapReceipt) -> list[Task]:
        self.seconds["map_kernels"] += receipt.seconds
        self._set_state(tile, TileState.COMPUTED)
        self._words[receipt.survey.image_set.number] |= receipt.survey.image_set.word
        self._seeds[tile] = receipt.survey.seeds
        self.reserved += receipt.survey.reserved
        if len(self._seeds) < len(self._tiles):
            return []
        if self.store.job.sample is None:
            self.store.write_image_words(self.number, self._words)
        # In the order of tiles, so that the result does not depend on timing.
        seeds = gather_seeds([self._seeds[tile] for tile in self._tiles])
        self._seeds.clear()
        self._assembling = True
        return [self._task(assemble_basin, self.number, (seeds, bool(self.reserved[2])), self._take_catalogue)]

    def _take_catalogue(self, _: int, receipt: CatalogueReceipt) -> list[Task]:
        self.seconds["assemble_kernels"] += receipt.seconds
        self.solved = len(receipt.attractors) == len(self.attractors)
        return [] if self.solved else self._label(receipt.attractors)

    def _label(self, attractors: tuple[Attractor, ...]) -> list[Task]:
        """Label every tile, again after each extension of the catalogue."""
        self.attractors = attractors
        self._labels.clear()
        arguments = attractors, self.numbered
        return [self._task(label_tile, tile, arguments, self._take_labels) for tile in reversed(self._tiles)]

    def _take_labels(self, tile: int, receipt: LabelReceipt) -> list[Task]:
        self.seconds["label_kernels"] += receipt.seconds
        if self.numbered:
            self._set_state(tile, TileState.ASSEMBLED)
        self._labels[tile] = receipt
        if len(self._labels) < len(self._tiles):
            return []
        self.counts = np.sum([label.counts for label in self._labels.values()], axis=0)
        unassigned = gather_seeds([self._labels[tile].unassigned for tile in self._tiles])
        self._rounds += 1
        self.solved = not unassigned.box.size
        arguments = self.attractors, unassigned, self._rounds
        return [] if self.solved else [self._task(extend_catalogue, self.number, arguments, self._take_catalogue)]

"""Recompute one figure into a folder: its basins as stores (resumed, shared between figures), a PNG, its numbers."""

import json
import math
import threading
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from distributed import Client
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from rattle.paper.figure import PaperFigure, Report, Sheet
from rattle_kernels import CellGrid
from worker.basins.pipeline import run_basin
from worker.cluster.driver import Driver
from worker.errors import JobCancelled
from worker.jobs.basin_job import BasinJob
from worker.progress import Progress
from worker.stores.basin_store import BasinStore

_DIGITS = 12


@dataclass(frozen=True)
class Produced:
    """Files of a figure in its folder."""

    picture: Path
    numbers: Path
    stores: tuple[Path, ...]


def store_name(job: BasinJob) -> str:
    """File name of a job's store. It is readable, and the same in all figures, so that they share the store."""
    damping, eccentricity, half_backlash, stiffness, _ = job.oscillator
    contact = "impacting" if math.isinf(stiffness) else f"kappa{stiffness:g}"
    cells = f"{job.grid.time_cells}x{job.grid.velocity_cells}"
    swept = "".join(f"-over-{each.parameter}" for each in job.vary)
    return f"{contact}-d{damping:g}-e{eccentricity:g}-b{half_backlash:g}{swept}-{cells}-{job.digest[:8]}.zarr"


def produce(
    figure: PaperFigure,
    folder: Path,
    grid: CellGrid,
    connect: Callable[[], AbstractContextManager[Client]],
    *,
    report: Report,
    cancel: threading.Event,
) -> Produced:
    """Recompute a figure.

    Parameters
    ----------
    figure : PaperFigure
    folder : path
        Created if it is missing. Complete stores are used as they are, and unfinished ones are resumed.
    grid : CellGrid
        Grid of its basins.
    connect : callable
        Opens a cluster. Called only if a basin is missing.
    report : callable
        Called with the current step, how much of it is done, and the total.
    cancel : threading.Event
        Set it to stop. Stores stay as they are, and the next call resumes them.

    Raises
    ------
    InvalidJob, JobCancelled, StoreConflict, StoreFailed, TileFailed, ClusterFailed, UnlikeWorkers
    OSError
        If the folder cannot be written.
    """

    def report_or_stop(what: str, done: int, total: int) -> None:
        if cancel.is_set():
            raise JobCancelled("cancelled on request")
        report(what, done, total)

    jobs = figure.basins(grid)
    folder.mkdir(parents=True, exist_ok=True)
    stores = {name: BasinStore.create_or_resume(str(folder / store_name(job)), job) for name, job in jobs.items()}
    _complete({name: store for name, store in stores.items() if not store.complete}, connect, report_or_stop, cancel)
    sheet = figure.make({name: store.location for name, store in stores.items()}, report_or_stop)
    return _write(figure, sheet, folder, tuple(Path(store.location) for store in stores.values()))


def _complete(
    stores: dict[str, BasinStore],
    connect: Callable[[], AbstractContextManager[Client]],
    report: Report,
    cancel: threading.Event,
) -> None:
    """Compute the missing basins, one after another."""
    if not stores:
        return
    with connect() as client:
        driver = Driver(client)
        for number, (name, store) in enumerate(stores.items(), 1):
            before = f"basin {number} of {len(stores)}, {name}: " if len(stores) > 1 else ""

            def report_tiles(progress: Progress, before: str = before) -> None:
                report(f"{before}{progress.stage}", progress.tiles_done, progress.tiles_total)

            run_basin(store.job, store.location, driver, report=report_tiles, cancel=cancel)


def _write(figure: PaperFigure, sheet: Sheet, folder: Path, stores: tuple[Path, ...]) -> Produced:
    picture, numbers = folder / f"{figure.name}.png", folder / f"{figure.name}.json"
    _paint(sheet.drawing).save(picture, format="png", optimize=True)
    content = {"figure": figure.name, "shows": figure.shows} | sheet.numbers
    numbers.write_text(json.dumps(_plain(content), indent=1, allow_nan=False) + "\n")
    return Produced(picture, numbers, stores)


def _paint(drawing: Figure) -> Image.Image:
    """Pixels of a drawing in 256 colours, a third of the bytes. Speckled basins are hard to compress."""
    canvas = FigureCanvasAgg(drawing)
    canvas.draw()
    pixels = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    return pixels.quantize(256, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)


def _plain(value: Any) -> Any:
    """Value as JSON can hold it: without NaN and infinity, and to 12 digits, on which processors agree."""
    if isinstance(value, dict):
        return {key: _plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    if isinstance(value, float):
        return float(f"{value:.{_DIGITS}g}") if math.isfinite(value) else None
    return value

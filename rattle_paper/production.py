"""Recompute one figure into a folder: its basins as stores (resumed, shared between figures), a PNG, its numbers."""

import io
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from rattle import BasinJob, Progress, compute
from rattle_kernels import CellGrid
from rattle_paper.figure import Job, PaperFigure, Report, Results, Sheet

_DIGITS = 12


@dataclass(frozen=True)
class Produced:
    """Files of a figure in its folder, and what the paper prints beside what was found."""

    picture: Path
    numbers: Path
    printed: list[dict[str, Any]]


def store_name(job: Job) -> str:
    """File name of a job's store. It is readable, and the same in all figures, so that they share the store."""
    if not isinstance(job, BasinJob):
        return f"{job.kind}-{job.digest[:8]}.zarr"
    damping, eccentricity, half_backlash, stiffness, *_ = job.oscillator
    contact = "impacting" if math.isinf(stiffness) else f"kappa{stiffness:g}"
    cells = f"{job.grid.time_cells}x{job.grid.velocity_cells}"
    swept = "".join(f"-over-{axis.name}" for axis in job.axes)
    return f"{contact}-d{damping:g}-e{eccentricity:g}-b{half_backlash:g}{swept}-{cells}-{job.digest[:8]}.zarr"


def produce(
    figure: PaperFigure, folder: Path, grid: CellGrid, *, report: Report, workers: int, scheduler: str | None = None
) -> Produced:
    """Recompute a figure.

    Parameters
    ----------
    figure : PaperFigure
    folder : path
        Created if it is missing. Complete stores are used as they are, and unfinished ones are resumed.
    grid : CellGrid
        Grid of its basins.
    report : callable
        Called with the current step, how much of it is done, and the total. An exception that it raises stops the work.
    workers : int
        Threads that compute basins.
    scheduler : str, optional
        Address of a Dask scheduler, in place of threads.

    Raises
    ------
    InvalidJob, JobCancelled, StoreConflict, StoreFailed, TileFailed, ClusterFailed, UnlikeWorkers
    OSError
        If the folder cannot be written.
    """
    jobs = figure.jobs(grid)
    folder.mkdir(parents=True, exist_ok=True)
    sheet = figure.make(_computed(jobs, folder, report, workers, scheduler), report)
    return _write(figure, sheet, folder)


def _computed(jobs: Mapping[str, Job], folder: Path, report: Report, workers: int, scheduler: str | None) -> Results:
    """Results of the jobs, one computed after another."""
    results = {}
    for number, (name, job) in enumerate(jobs.items(), 1):
        before = f"{job.kind} {number} of {len(jobs)}, {name}: " if len(jobs) > 1 else ""

        def report_tiles(progress: Progress, before: str = before) -> None:
            report(f"{before}{progress.stage}", progress.tiles_done, progress.tiles_total)

        results[name] = compute(
            job, store=folder / store_name(job), workers=workers, scheduler=scheduler, progress=report_tiles
        )
    return results


def _write(figure: PaperFigure, sheet: Sheet, folder: Path) -> Produced:
    picture, numbers = folder / f"{figure.name}.png", folder / f"{figure.name}.json"
    encoded = io.BytesIO()
    _paint(sheet.drawing).save(encoded, format="png", optimize=True)
    printed = [each.beside(sheet.numbers) for each in figure.printed]
    content = {"figure": figure.name, "shows": figure.shows} | sheet.numbers | ({"printed": printed} if printed else {})
    text = json.dumps(_plain(content), indent=1, allow_nan=False) + "\n"
    picture.write_bytes(encoded.getvalue())
    numbers.write_text(text)
    return Produced(picture, numbers, printed)


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

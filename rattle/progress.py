"""Progress of long work: a bar on a terminal and in a notebook, plain lines where a command's output goes elsewhere."""

import importlib.util
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from worker.progress import Progress, Stage

# Plain lines come ever more seldom, from every few seconds on to one a minute.
_PLAIN_LINE_SECONDS = 5.0
_SELDOM_SECONDS = 60.0
# In a notebook a bar is drawn as it is told of progress. A thread that draws it would catch what is printed meanwhile.
_REDRAWN_SECONDS = 0.1


def say_compiling(console: Console) -> None:
    """Say why nothing happens for a while."""
    console.print("compiling the kernels, the first time only: a minute or so", highlight=False)


class ProgressLine:
    """Shows the stages of a job as they pass.

    Parameters
    ----------
    console : rich.console.Console
    bar : rich.progress.Progress or None
        None for plain lines.
    unit : str
        What is counted.
    """

    def __init__(self, console: Console, bar: Bar | None, unit: str) -> None:
        self.console, self.bar, self.unit = console, bar, unit
        self.task = bar.add_task("waiting", total=None, unit=unit, pace="") if bar else None
        self.stage, self.said, self.pause = "", 0.0, _PLAIN_LINE_SECONDS
        self._said_compiling = False

    def compiling(self, done: int, total: int) -> None:
        """Show how many kernels are compiled, of how many."""
        self._say_compiling_once()
        self.show("compiling", (done, total), unit="kernels")

    def _say_compiling_once(self) -> None:
        if not self._said_compiling:
            say_compiling(self.console)
        self._said_compiling = True

    def report(self, progress: Progress) -> None:
        """Show the progress of a job."""
        if progress.stage is Stage.COMPILING:
            self._say_compiling_once()
            return
        tiles, basins = (progress.tiles_done, progress.tiles_total), (progress.basins_done, progress.basins_total)
        self.show(progress.stage, tiles, basins, progress.cells_per_second)

    def show(
        self,
        stage: str,
        done: tuple[int, int],
        basins: tuple[int, int] = (1, 1),
        cells_per_second: float = 0.0,
        unit: str | None = None,
    ) -> None:
        """Show the progress of a stage: units and basins that are done, and their totals."""
        unit = self.unit if unit is None else unit
        pace = f"{cells_per_second:,.0f} cells/s" if cells_per_second else ""
        if basins[1] > 1:
            pace = f"{basins[0]} of {basins[1]} basins {pace}"
        if self.bar is not None and self.task is not None:
            if stage != self.stage:
                self.bar.reset(self.task)  # or the time left would be reckoned by the pace of another stage
            self.bar.update(self.task, description=stage, completed=done[0], total=done[1], unit=unit, pace=pace)
            self._redraw(stage)
        elif self._plain_line_is_due(stage):
            self.console.print(" ".join(f"{stage}: {done[0]} of {done[1]} {unit} {pace}".split()), highlight=False)
        self.stage = stage

    def _redraw(self, stage: str) -> None:
        if self.bar is None or self.bar.live.auto_refresh:
            return
        now = time.monotonic()
        if stage != self.stage or now - self.said > _REDRAWN_SECONDS:
            self.said = now
            self.bar.refresh()

    def _plain_line_is_due(self, stage: str) -> bool:
        now = time.monotonic()
        if stage != self.stage:
            self.said, self.pause = now, _PLAIN_LINE_SECONDS
            return True
        if now - self.said <= self.pause:
            return False
        self.said, self.pause = now, min(2.0 * self.pause, _SELDOM_SECONDS)
        return True


def shows_bars(console: Console) -> bool:
    """Whether a console can show a bar: a terminal, or a notebook that has ipywidgets."""
    if console.is_jupyter:
        return importlib.util.find_spec("ipywidgets") is not None
    return console.is_terminal


def console_for(progress: bool) -> Console:
    """Where progress is shown: nowhere, if it is not wanted or no bar can be."""
    console = Console(stderr=True)
    return console if progress and shows_bars(console) else Console(quiet=True)


@contextmanager
def progress_line(console: Console, unit: str = "tiles") -> Iterator[ProgressLine]:
    """Progress bar where a console can show one, a plain line now and then elsewhere; `unit` names what is counted."""
    if not shows_bars(console):
        yield ProgressLine(console, None, unit)
        return
    columns = (
        TextColumn("{task.description:<11}"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[unit]}"),
        TimeRemainingColumn(), TextColumn("{task.fields[pace]}"),
    )  # fmt: skip
    notebook = console.is_jupyter
    if notebook:
        # What was printed a moment ago is still on its way, and the bar's place would catch it.
        sys.stdout.flush()
        sys.stderr.flush()
    with Bar(*columns, console=console, transient=notebook, auto_refresh=not notebook) as bar:
        yield ProgressLine(console, bar, unit)

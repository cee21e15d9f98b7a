"""How much of the basins of Figs. 7 (bottom), 8 and 9 is proven: what is not is hatched."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from rattle import BasinJob, SweepJob
from rattle.pictures import SYMBOLS
from rattle_kernels import CellGrid
from rattle_paper.figure import PaperFigure, Report, Results, Sheet
from rattle_paper.figures.fig8_fig9 import FIG8, FIG9

_ROWS, _COLUMNS = 3, 6


def _basins(grid: CellGrid) -> dict[str, BasinJob]:
    """Each of the basins once: Fig. 7 (bottom) is the last of Fig. 8 and the middle one of Fig. 9."""
    jobs = {}
    for figure, left_out in ((FIG8, 0.1), (FIG9, None)):
        (sweep,) = figure.jobs(grid).values()
        assert isinstance(sweep, SweepJob)
        (swept,) = sweep.vary
        for number, value in enumerate(swept.values):
            if value != left_out:
                oscillator = sweep.oscillator_of(number)
                job = BasinJob(oscillator=oscillator, grid=grid, iterations=sweep.iterations, prove=True)
                jobs[f"{swept.parameter} {value:g}"] = job
    return jobs


def _make(results: Results, report: Report) -> Sheet:
    drawing = Figure(figsize=(20.0, 11.0), dpi=80, layout="constrained")
    places = drawing.subplots(_ROWS, _COLUMNS, sharex=True, sharey=True)
    for number, (axes, (name, basin)) in enumerate(zip(places.flat, results.items(), strict=False)):
        report("drawing", number, len(results))
        basin.rattle.plot(axes, overlays=["proven"])
        legend = axes.get_legend()
        if legend is not None:
            legend.remove()
        parameter, value = name.split()
        axes.label_outer()
        quiet_or_not = _quiet_or_not(basin)
        title = f"{SYMBOLS[parameter]} = {value}: {_proven(basin):.2%} proven, quiet or not {quiet_or_not:.2%}"
        axes.set_title(title, fontsize="small")
    for axes in places.flat[len(results) :]:
        axes.remove()
    return Sheet(drawing, {"panels": {name: _summary(basin) for name, basin in results.items()}})


def _proven(basin: xr.Dataset) -> float:
    return float(np.sum(basin.share_proven.values))


def _quiet_or_not(basin: xr.Dataset) -> float:
    """Share of the plane of which it is proven that it falls quiet, or that it never does."""
    certificate = basin.rattle.certificate
    quiet = certificate["quiet"]
    falls = 0.0 if quiet is None else certificate["shares"][quiet["motion"]]
    return float(falls + certificate["never_quiet"])


def _summary(basin: xr.Dataset) -> dict[str, Any]:
    certificate = basin.rattle.certificate
    counts = certificate["counts"]
    return {
        "proven": _proven(basin),
        "quiet_or_not": _quiet_or_not(basin),
        "whole": counts["whole"] / counts["cells"],
        "not_whole": dict(zip(_REASONS, counts["reasons"][1:], strict=True)),
        "quiet_level": certificate["quiet"] and certificate["quiet"]["level"],
        "discs": len(certificate["discs"]),
        "rattles_for_ever": certificate["rattling"] is not None,
        "solutions": [
            {"name": name, "share": float(share), "proven": float(least), "at_most": float(most)}
            for name, share, least, most in zip(
                *(basin[each].values for each in ("name", "share", "share_proven", "share_at_most")), strict=True
            )
        ],
    }


_REASONS = ("arrives nowhere", "spreads", "straddles grazing", "a part ends otherwise", "the rest never falls quiet")
PROVEN = PaperFigure("proven", "basins of Figs. 7 (bottom), 8 and 9, with what of them is proven", _make, _basins)

"""A panel of basins on which only those motions are marked that a caption names, and histories of these."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from rattle_kernels import Attractor, Oscillator, PeriodicOrbit, TimeHistory, time_history
from worker.paper.basin_panel import draw_panel, legend_of
from worker.paper.basin_view import BasinView
from worker.pictures.overlay import Marks


def draw_marked(axes: Axes, label: str, view: BasinView, marks: Sequence[Marks]) -> None:
    """Draw basins, marks over them, and shares below."""
    draw_panel(axes, view, marks)
    axes.set_title(f"({label}) δ = {view.oscillator.damping:g}", fontsize="medium")
    axes.legend(handles=legend_of(view), loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=2, fontsize="small")


def history_of(oscillator: Oscillator, motion: Attractor | PeriodicOrbit, periods: float) -> TimeHistory:
    """History that begins with the fastest departure of a periodic motion, or with one of a chaotic one."""
    t, v = (motion.t, motion.v) if isinstance(motion, PeriodicOrbit) else (motion.time, motion.velocity)
    fastest = int(np.argmax(v))
    return time_history(oscillator, float(t[fastest]), oscillator.half_backlash, -float(v[fastest]), periods=periods)

"""Fig. 9: basins of the impacting model as damping grows: rattling solutions die one by one, until none is left."""

from worker.paper.sweep_sheet import sweep_figure

FIG9 = sweep_figure("fig9", "damping", 0.5, 0.7)

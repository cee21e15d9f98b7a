"""Fig. 8: basins of the impacting model as eccentricity grows: rattle is born at 0.0596 and becomes complex."""

from worker.paper.sweep_sheet import sweep_figure

FIG8 = sweep_figure("fig8", "eccentricity", 0.056, 0.1)

"""Parts of pictures, for figures of your own: cells in colours, curves and marks over them, time histories, files.

>>> from matplotlib.figure import Figure
>>> import rattle
>>> from rattle import pictures
>>> basin = rattle.basin(damping=0.6, eccentricity=0.1, half_backlash=0.6, cells=40, progress=False)
>>> figure = Figure()
>>> axes = basin.rattle.plot(figure.subplots(), overlays=(), legend=False)
>>> marks = pictures.attractor_marks(basin.rattle.catalogue())
>>> for overlay in (pictures.grazing_line(basin.rattle.oscillator), *marks):
...     overlay.draw(axes)
>>> pictures.save_figure(figure, "basin.pdf")

Axes of basins show the (t, v) plane: phases of departure in forcing periods, and nondimensional speeds.
"""

from worker.pictures.colours import Palette, colours_of, paint_cells
from worker.pictures.figure_file import save_figure
from worker.pictures.history import draw_boundaries, draw_history_panel
from worker.pictures.overlay import (
    Lines,
    Marks,
    Overlay,
    attractor_marks,
    grazing_line,
    manifold_lines,
    preimage_lines,
    saddle_marks,
)
from worker.pictures.printing import Printing
from worker.pictures.symbols import SYMBOLS, oscillator_text
from worker.results.panel import frame

__all__ = [
    "Lines",
    "Marks",
    "Overlay",
    "Palette",
    "Printing",
    "SYMBOLS",
    "attractor_marks",
    "colours_of",
    "draw_boundaries",
    "draw_history_panel",
    "frame",
    "grazing_line",
    "manifold_lines",
    "oscillator_text",
    "paint_cells",
    "preimage_lines",
    "saddle_marks",
    "save_figure",
]

"""A picture for paper and screen: its size, resolution and letters, whether its text stays text, and its caption."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
from matplotlib.axis import Tick
from matplotlib.figure import Figure
from matplotlib.text import Text

from worker.errors import InvalidJob

SIDE_MM = (20.0, 1200.0)
"""Least and largest width and height, in mm."""
DPI = (30, 1200)
"""Least and largest dots per inch."""
FONT_POINTS = (4.0, 36.0)
"""Least and largest size of letters, in points."""
MOST_PIXELS = 40_000_000
"""Of a picture: A4 at 600 dpi has 35 million. Each takes some ten bytes while the picture is made."""
_MM_PER_INCH = 25.4
# Of fonts in Matplotlib's own style, whose other sizes are relative to it.
_USUAL_POINTS = 10.0


@dataclass(frozen=True)
class Printing:
    """How a picture is printed. What is None stays as the picture is drawn.

    Parameters
    ----------
    width, height : float, optional
        In mm. Of one alone the other follows.
    dpi : int, optional
        Dots per inch: of a PNG, and of the cells in an SVG or a PDF.
    font_size : float, optional
        Of ordinary letters, in points. Titles and small print keep their ratio to it.
    editable : bool
        Whether text of an SVG or a PDF stays text. Its letters are then those of whoever looks at an SVG.

    Raises
    ------
    InvalidJob
        If one of them is too small or too large.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> figure = Figure(figsize=(10.0, 5.0))
    >>> Printing(width=127.0).apply(figure)
    >>> figure.get_size_inches().tolist()
    [5.0, 2.5]
    """

    width: float | None = None
    height: float | None = None
    dpi: int | None = None
    font_size: float | None = None
    editable: bool = False

    def __post_init__(self) -> None:
        for what, value, (least, most), unit in (
            ("width", self.width, SIDE_MM, " mm"),
            ("height", self.height, SIDE_MM, " mm"),
            ("resolution", self.dpi, DPI, " dpi"),
            ("font size", self.font_size, FONT_POINTS, " points"),
        ):
            if value is not None and not least <= value <= most:
                raise InvalidJob(f"the {what} of a picture is {least:g} to {most:g}{unit}, not {value:g}")

    def apply(self, figure: Figure) -> None:
        """Give a figure that is drawn this size and these letters.

        Raises
        ------
        InvalidJob
            If it had more pixels than fit in memory.
        """
        wide, high = figure.get_size_inches()
        if self.width is not None:
            wide, high = self.width / _MM_PER_INCH, high * self.width / _MM_PER_INCH / wide
        if self.height is not None:
            wide, high = (wide if self.width else wide * self.height / _MM_PER_INCH / high), self.height / _MM_PER_INCH
        dpi = self.dpi or figure.dpi
        if wide * dpi * high * dpi > MOST_PIXELS:
            raise InvalidJob(
                f"a picture has at most {MOST_PIXELS // 1_000_000} million pixels, not {wide * dpi:.0f} x "
                f"{high * dpi:.0f}: take fewer dpi, or a smaller size"
            )
        figure.set_size_inches(wide, high)
        if self.font_size is not None:
            _scale_letters(figure, self.font_size / _USUAL_POINTS)

    @contextmanager
    def style(self) -> Iterator[None]:
        """How text is written meanwhile. It holds for all threads: one of them saves at a time."""
        own: dict[str, Any] = {"svg.fonttype": "none", "pdf.fonttype": 42} if self.editable else {}
        with mpl.rc_context(own):
            yield


AS_DRAWN = Printing()


def _scale_letters(figure: Figure, factor: float) -> None:
    # Ticks that come with another size of the figure have it as well.
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            for tick in axis.get_major_ticks()[:1]:
                axis.set_tick_params(labelsize=factor * float(tick.label1.get_fontsize()))
    of_ticks = {label for tick in figure.findobj(Tick) for label in (tick.label1, tick.label2)}
    for text in figure.findobj(Text):
        if text not in of_ticks:
            text.set_fontsize(factor * float(text.get_fontsize()))

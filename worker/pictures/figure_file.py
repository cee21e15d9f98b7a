"""A figure as a file: PNG, SVG or PDF. The same figure gives the same bytes."""

import threading
import warnings
from enum import StrEnum
from pathlib import Path
from typing import IO

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from worker.errors import InvalidJob
from worker.pictures.printing import AS_DRAWN, Printing

_DPI = 110
# Neither a date nor a random identifier is written.
_UNDATED = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}
# Where a format keeps a caption.
_CAPTION = {"png": "Description", "svg": "Description", "pdf": "Subject"}
# What Matplotlib says of a picture that is too small for its letters.
_NO_ROOM = "constrained_layout not applied"
_SAVING = threading.Lock()


class PictureFormat(StrEnum):
    """Format of a picture's file."""

    PNG = "png"
    SVG = "svg"
    PDF = "pdf"

    @property
    def media_type(self) -> str:
        """As in the header Content-Type."""
        return {"png": "image/png", "svg": "image/svg+xml", "pdf": "application/pdf"}[self]

    @classmethod
    def of_file(cls, path: str | Path) -> "PictureFormat":
        """Format that a file's name asks for.

        Parameters
        ----------
        path : str or path

        Returns
        -------
        PictureFormat

        Raises
        ------
        InvalidJob
            If its name ends otherwise.
        """
        suffix = Path(path).suffix.removeprefix(".").lower()
        if suffix not in list(cls):
            endings = ", ".join(f".{each}" for each in cls)
            raise InvalidJob(f"the name of a picture ends in one of {endings}, not as {str(path)!r} does")
        return cls(suffix)


def new_figure(width: float = 10.0, height: float = 6.5) -> Figure:
    """Empty figure of a size in inches."""
    figure = Figure(figsize=(width, height), dpi=_DPI, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save_figure(
    figure: Figure, target: str | Path | IO[bytes], picture_format: PictureFormat | None = None,
    printing: Printing = AS_DRAWN, caption: str | None = None,
) -> None:  # fmt: skip
    """Write a figure to a file.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    target : path or binary file
    picture_format : PictureFormat, optional
        By default the one that the file's name asks for; needed for an open file.
    printing : Printing
        Size, resolution, letters. The figure keeps its size and letters.
    caption : str, optional
        A text that the file carries along: its description in a PNG and an SVG, its subject in a PDF.

    Raises
    ------
    InvalidJob
        If the file's name asks for no such format, or the picture had too many pixels, or no room beside its letters.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> save_figure(Figure(), "picture.svg", printing=Printing(width=86.0), caption="Nothing yet.")
    >>> "Nothing yet." in Path("picture.svg").read_text()
    True
    """
    if picture_format is None:
        assert isinstance(target, str | Path)
        picture_format = PictureFormat.of_file(target)
    printing.apply(figure)
    metadata = _UNDATED[picture_format] | ({_CAPTION[picture_format]: caption} if caption else {})
    with _SAVING, printing.style(), warnings.catch_warnings():
        warnings.filterwarnings("error", _NO_ROOM, UserWarning)
        if picture_format == PictureFormat.SVG:
            mpl.rcParams["svg.hashsalt"] = "gear-rattle"  # identifiers in the file are random without it
        try:
            figure.savefig(target, format=picture_format.value, metadata=metadata, dpi=printing.dpi or "figure")
        except UserWarning as warning:
            message = "letters leave no room for the picture: take a larger one, or smaller letters"
            raise InvalidJob(message) from warning

"""Annotations of a picture: pinned points with labels, and lines, which say a label or the distance of their ends."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.patheffects import Stroke, withStroke

from worker.errors import InvalidJob

MOST = 20
"""Most points, and most lines, of a picture."""
MOST_LETTERS = 60
"""Most letters of a label."""
_HALO = [withStroke(linewidth=2.5, foreground="black")]
# Letters with a halo would be drawn as outlines, and be no text any more.
_GROUND = {"boxstyle": "round,pad=0.25", "facecolor": (0.0, 0.0, 0.0, 0.55), "linewidth": 0.0}


class Note(NamedTuple):
    """A pinned point with a label.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> axes = Figure().subplots()
    >>> Note(0.3, 4.1, "here").draw(axes)
    >>> axes.texts[0].get_text()
    'here'
    """

    t: float
    v: float
    label: str

    def draw(self, axes: Axes, time_start: float = 0.0) -> None:
        """Draw it on axes that show one period from ``time_start`` on."""
        t = time_start + (self.t - time_start) % 1.0
        # Its name begins with an underscore, so that no legend lists it.
        axes.plot(t, self.v, "o", color="white", markersize=6.0, fillstyle="none", path_effects=_HALO, label="_note")
        axes.annotate(
            self.label, (t, self.v), (9.0, 0.0), textcoords="offset points", color="white", va="center",
            bbox=_GROUND, annotation_clip=True,
        )  # fmt: skip


class Measure(NamedTuple):
    """A line with its label, or with the distance between its ends.

    Parameters
    ----------
    t0, v0, t1, v1 : float
        Its ends.
    label : str or None
        The distance where it is None; nothing where it is empty.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> axes = Figure().subplots()
    >>> Measure(0.1, 1.0, 0.3, 2.5).draw(axes)
    >>> axes.texts[0].get_text()
    'Δt = 0.2, Δv = 1.5'
    """

    t0: float
    v0: float
    t1: float
    v1: float
    label: str | None = None

    def draw(self, axes: Axes, time_start: float = 0.0) -> None:
        """Draw it on axes that show one period from ``time_start`` on: so its first end."""
        t0 = time_start + (self.t0 - time_start) % 1.0
        t1 = t0 + self.t1 - self.t0
        axes.plot(
            [t0, t1], [self.v0, self.v1], "-", color="white", linewidth=1.2, label="_measure",
            path_effects=[Stroke(linewidth=3.0, foreground="black"), *_HALO],
        )  # fmt: skip
        distance = f"Δt = {self.t1 - self.t0:.3g}, Δv = {self.v1 - self.v0:.3g}".replace("-", "−")
        text = distance if self.label is None else self.label
        if not text:
            return
        axes.annotate(
            text, ((t0 + t1) / 2, (self.v0 + self.v1) / 2), (6.0, 6.0), textcoords="offset points", color="white",
            bbox=_GROUND, annotation_clip=True,
        )  # fmt: skip


Annotation = Note | Measure
"""What a reader has written on a basin."""


def parse_annotations(notes: Sequence[str], measures: Sequence[str]) -> tuple[Annotation, ...]:
    """Annotations from texts as ``0.3,4.1,a label`` and ``0.3,4.1,0.5,4.4``, as addresses of the page have them.

    A line has a label after a further comma, if need be an empty one.

    Raises
    ------
    InvalidJob
        If one of them is none, or there are too many.

    Examples
    --------
    >>> parse_annotations(["0.3,4.1,here, and there"], [])
    (Note(t=0.3, v=4.1, label='here, and there'),)
    >>> parse_annotations([], ["0.3,4.1,0.5,4.4,"])
    (Measure(t0=0.3, v0=4.1, t1=0.5, v1=4.4, label=''),)
    """
    if max(len(notes), len(measures)) > MOST:
        raise InvalidJob(f"a picture has at most {MOST} notes and {MOST} measures")
    return (*map(_note, notes), *map(_measure, measures))


def _note(text: str) -> Note:
    numbers, label = text.split(",", 2)[:2], ",".join(text.split(",")[2:])
    t, v = _numbers(numbers, 2, f"a note is a time, a speed and a label: 0.3,4.1,here, not {text}")
    return Note(t, v, _short(label, "note"))


def _measure(text: str) -> Measure:
    numbers, label = text.split(",", 4)[:4], text.split(",", 4)[4:]
    refusal = f"a measure is two points, and if need be a label: 0.3,4.1,0.5,4.4, not {text}"
    t0, v0, t1, v1 = _numbers(numbers, 4, refusal)
    return Measure(t0, v0, t1, v1, _short(label[0], "measure") if label else None)


def _short(label: str, what: str) -> str:
    if len(label) > MOST_LETTERS:
        raise InvalidJob(f"the label of a {what} has at most {MOST_LETTERS} letters")
    return label


def _numbers(parts: list[str], count: int, refusal: str) -> list[float]:
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise InvalidJob(refusal)
    return numbers

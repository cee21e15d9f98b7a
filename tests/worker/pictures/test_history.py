"""The picture of a time history shows what it should, and the same history gives the same bytes."""

import io

import numpy as np
import pytest
from matplotlib.image import imread

from rattle_kernels import Oscillator, time_history
from worker.pictures.figure_file import PictureFormat, save_figure
from worker.pictures.history import history_figure


def drawn(oscillator, **options):
    history = time_history(oscillator, 0.3, 0.6, -4.0, **options)
    buffer = io.BytesIO()
    save_figure(history_figure(oscillator, history), buffer, PictureFormat.PNG)
    return buffer.getvalue()


def reddish(png):
    pixels = imread(io.BytesIO(png))[..., :3]
    return ((pixels[..., 0] > 0.7) & (pixels[..., 1] < 0.3)).sum()


@pytest.mark.parametrize("stiffness", [100.0, np.inf])
def test_contacts_are_marked(stiffness):
    oscillator = Oscillator(stiffness=stiffness)
    assert reddish(drawn(oscillator, periods=6.0)) > reddish(drawn(oscillator, periods=0.5)) == 0


def test_the_same_history_gives_the_same_bytes():
    assert drawn(Oscillator(), periods=3.0) == drawn(Oscillator(), periods=3.0)


def test_a_history_of_one_sample_and_a_truncated_one_are_drawn():
    assert drawn(Oscillator(), periods=0.0).startswith(b"\x89PNG")
    assert drawn(Oscillator(), periods=20.0, most_contacts=2).startswith(b"\x89PNG")


@pytest.mark.slow
def test_a_history_of_very_many_contacts_is_drawn():
    """Agg's rasteriser overflows at as many points as these; the extremes of each stretch are as high."""
    fast = Oscillator(half_backlash=0.6)
    history = time_history(fast, 0.0, 0.6, -1e6, periods=20.0, samples_per_period=200, most_contacts=100_000)
    assert history.time.size > 100_000
    figure = history_figure(fast, history)
    figure.savefig(io.BytesIO(), format="png")
    drawn = max((line.get_ydata() for line in figure.axes[0].get_lines()), key=len)
    assert len(drawn) < history.time.size / 2
    assert drawn.max() == history.displacement.max() and drawn.min() == history.displacement.min()

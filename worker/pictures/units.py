"""Axes in the units of a machine beside those of the model."""

from typing import Any

from matplotlib.axes import Axes

_PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))

# Past the numbers of the right axis, as a part of the width.
_BESIDE = 1.12


def draw_units(axes: Axes, *, time: float, speed: float) -> None:
    """Draw times in seconds above the axes of a basin, and speeds in m/s on their right.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Of a basin, with its limits.
    time, speed : float
        One unit of the model, s and m/s.
    """
    size, prefix = _prefix(time)
    axes.secondary_xaxis("top", functions=_scaled(time / size)).set_xlabel(f"{prefix}s")
    size, prefix = _prefix(speed * abs(axes.get_ylim()[1]))
    axes.secondary_yaxis("right", functions=_scaled(speed / size)).set_ylabel(f"{prefix}m/s")
    legend = axes.get_legend()
    if legend is not None:  # it stands beside the axes
        legend.set_bbox_to_anchor((_BESIDE, 1.0))
    axes.title.set_fontsize("medium")  # the axes are narrower than without


def _prefix(value: float) -> tuple[float, str]:
    """The prefix that makes a value 1 or more."""
    return next((each for each in _PREFIXES if value >= each[0]), _PREFIXES[-1])


def _scaled(factor: float) -> Any:
    return (lambda value: value * factor), (lambda value: value / factor)

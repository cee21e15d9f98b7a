"""Names of an oscillator's parameters in pictures."""

import numpy as np

from rattle_kernels import Oscillator
from worker.jobs.design import SweepAxis
from worker.jobs.swept_parameter import SweptParameter

SYMBOLS = {
    "damping": "δ", "eccentricity": "ε", "half_backlash": "β", "stiffness": "κ", "restitution": "r",
    "contact_damping": "ζ",
}  # fmt: skip
"""Symbol of each parameter of an oscillator in pictures."""

_OF_HARMONICS = {"amplitude": "ε", "phase": "φ"}
_BELOW = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
# Not worth a word where they are what the paper has.
_USUAL = {"stiffness": np.inf, "restitution": 1.0, "contact_damping": 0.0}


def symbol_of(parameter: str) -> str:
    """Symbol of one of `Oscillator.parameters`.

    Parameters
    ----------
    parameter : str

    Returns
    -------
    str

    Examples
    --------
    >>> symbol_of("damping"), symbol_of("phase_2")
    ('δ', 'φ₂')
    """
    if parameter in SYMBOLS:
        return SYMBOLS[parameter]
    part, _, order = parameter.partition("_")
    return _OF_HARMONICS[part] + order.translate(_BELOW)


def in_words(parameter: str) -> str:
    """Parameter in words, and its symbol."""
    return f"{parameter.replace('_', ' ')} {symbol_of(parameter)}"


def axis_in_words(axis: SweepAxis) -> str:
    """What a sweep steps along: a parameter in words and its symbol, or a coordinate and its units.

    Parameters
    ----------
    axis : SweptParameter or Design

    Returns
    -------
    str
    """
    if isinstance(axis, SweptParameter):
        return in_words(axis.parameter)
    name = axis.name.replace("_", " ")
    return name if axis.units is None else f"{name} ({axis.units})"


def value_in_words(axis: SweepAxis, at: int) -> str:
    """A value along what a sweep steps along, as in ``δ = 0.6`` and ``speed = 1200 rpm``."""
    if isinstance(axis, SweptParameter):
        return f"{symbol_of(axis.parameter)} = {axis.values[at]:g}"
    return f"{axis.name.replace('_', ' ')} = {axis.values[at]:g} {axis.units or ''}".rstrip()


def oscillator_text(oscillator: Oscillator, without: tuple[str, ...] = ()) -> str:
    """Model and parameters in one line.

    Parameters
    ----------
    oscillator : Oscillator
    without : tuple of str
        Parameters to leave out.

    Returns
    -------
    str

    Examples
    --------
    >>> oscillator_text(Oscillator(), without=("damping",))
    'impacting model, ε = 0.1, β = 0.6'
    """
    values = {name: oscillator.value_of(name) for name in oscillator.parameters if name not in without}
    terms = [f"{symbol_of(name)} = {value:g}" for name, value in values.items() if value != _USUAL.get(name)]
    model = "impacting model" if np.isinf(oscillator.stiffness) else "piecewise linear model"
    return ", ".join([model, *terms])

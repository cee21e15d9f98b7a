"""Names of an oscillator's parameters in pictures."""

import numpy as np

from rattle_kernels import Oscillator

SYMBOLS = {"damping": "δ", "eccentricity": "ε", "half_backlash": "β", "stiffness": "κ"}


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
    fields = {name: value for name, value in oscillator._asdict().items() if name in SYMBOLS and name not in without}
    told = [f"{SYMBOLS[name]} = {value:g}" for name, value in fields.items() if np.isfinite(value)]
    model = "impacting model" if np.isinf(oscillator.stiffness) else "piecewise linear model"
    return ", ".join([model, *told])

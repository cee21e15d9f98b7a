"""The oscillator of a request, as JSON."""

import math
from typing import Any, Literal

from rattle_kernels import Oscillator

IMPACTING: Literal["impacting"] = "impacting"
PIECEWISE_LINEAR: Literal["piecewise_linear"] = "piecewise_linear"


def oscillator_request(oscillator: Oscillator, *, quiet: bool) -> dict[str, Any]:
    """Oscillator as requests have it.

    Parameters
    ----------
    oscillator : Oscillator
    quiet : bool
        Whether it has a quiet solution (Eq. 3); where it has none, the request says that this is allowed.

    Returns
    -------
    dict
    """
    damping, eccentricity, half_backlash, stiffness, permanent_after = oscillator
    asked: dict[str, Any] = {
        "model": IMPACTING if math.isinf(stiffness) else PIECEWISE_LINEAR,
        "damping": damping,
        "eccentricity": eccentricity,
        "half_backlash": half_backlash,
    }
    if not math.isinf(stiffness):
        rule = "envelope" if math.isinf(permanent_after) else "one_rotation"
        asked |= {"stiffness": stiffness, "permanent_contact": rule}
        if not quiet:
            asked["allow_no_quiet_solution"] = True
    return asked


def oscillator_from(request: dict[str, Any]) -> Oscillator:
    """Oscillator that a request in the shape of `oscillator_request` describes."""
    fields = {name: value for name, value in request.items() if name in Oscillator._fields}
    if request.get("permanent_contact") == "one_rotation":
        fields["permanent_after"] = 1.0
    return Oscillator(**fields)

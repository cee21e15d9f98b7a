"""Departures from +beta as users give them: checks that name the value at fault, its place, and what would be right."""

import numpy as np

_PHASE = "finite, a time in forcing periods"
_SPEED = "finite and above 0, the speed of leaving +beta"


def check_phases(t: np.typing.ArrayLike, name: str = "t") -> np.ndarray:
    """Return phases as float64, or raise if one is not finite.

    Parameters
    ----------
    t : array_like
        Phases, forcing periods.
    name : str
        What the caller's argument is called.

    Returns
    -------
    ndarray of float64, shape of ``t``

    Raises
    ------
    ValueError
        Naming the first that is not finite.
    """
    phases = _writable(t)
    _demand(np.isfinite(phases), phases, name, _PHASE)
    return phases


def check_departures(
    t: np.typing.ArrayLike, v: np.typing.ArrayLike, *, ended: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Return departures as float64, or raise if one is none.

    Parameters
    ----------
    t, v : array_like
        Phases and speeds, broadcast together.
    ended : bool
        Whether a point may be NaN in both, as a motion is that has come to rest: results are arguments again.

    Returns
    -------
    (ndarray, ndarray) of float64, shapes of ``t`` and ``v``

    Raises
    ------
    ValueError
        Naming the first phase that is not finite, or the first speed that is not finite and positive.
    """
    speeds, phases = _writable(v), _writable(t)
    rest = np.isnan(phases) & np.isnan(speeds) if ended else np.False_
    _demand(np.isfinite(phases) | rest, phases, "t", _PHASE)
    _demand((np.isfinite(speeds) & (speeds > 0.0)) | rest, speeds, "v", _SPEED)
    return phases, speeds


def _writable(values: np.typing.ArrayLike) -> np.ndarray:
    # A read-only array, as a coordinate of xarray is, is another type to Numba: kernels would be compiled once more.
    return np.require(values, np.float64, "W")


def _demand(right: np.ndarray, values: np.ndarray, name: str, what: str) -> None:
    if not right.all():
        shown = np.atleast_1d(np.broadcast_to(values, right.shape))
        place = tuple(int(each[0]) for each in np.nonzero(~np.atleast_1d(right)))
        at = f"{name}[{', '.join(map(str, place))}]" if values.ndim else name
        raise ValueError(f"{at} must be {what}, not {shown[place]}")

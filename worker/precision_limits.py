"""What double precision, and the impacts that are followed, can decide. Requests beyond are refused with the bound.

Decision 33 derives the bounds. Each one is generous: what it refuses could only end as undecided.
"""

import math

from rattle_kernels import CellGrid, Oscillator, OutsideDomain, largest_grazing_speed
from worker.errors import FieldPath, InvalidJob

SHORTEST_FLIGHT = 2.0**-40
"""Phases are stored to 2^-53 of a period. A flight of 2^-40 is then known to four digits."""
# Capture is looked for from the grazing speed, 2 beta delta, down to 3.5e-7 (0.8^(200/3)) of it.
_LARGEST_DRAG = 2.0**18
# Below it the speed of capture falls like the square of the damping.
_STRONG = 0.6
FOLLOWED = 130_000
"""Impacts after which a motion that has not settled is undecided."""


def check_decidable(oscillator: Oscillator) -> Oscillator:
    """Return an oscillator, or raise if double precision cannot resolve its shortest bounces.

    Parameters
    ----------
    oscillator : Oscillator
        Inside the domain of the map.

    Returns
    -------
    Oscillator

    Raises
    ------
    OutsideDomain
        Naming the parameter, the bound and its value.
    """
    damping, half_backlash = oscillator.damping, oscillator.half_backlash
    if damping > 1.0 / SHORTEST_FLIGHT:
        why = "a bounce lasts 1/damping, and double precision does not resolve a shorter one"
        raise _outside("damping", damping, "resolution", 1.0 / SHORTEST_FLIGHT, "at most 2^40", why)
    least = 4.0 * math.pi * damping * SHORTEST_FLIGHT**2
    most = _LARGEST_DRAG * min(1.0, (damping / _STRONG) ** 2) / damping
    if half_backlash < least:
        why = "double precision does not resolve the flight from wall to wall of a narrower backlash"
        raise _outside("half_backlash", half_backlash, "resolution", least, "at least 4 pi damping 2^-80", why)
    if half_backlash > most:
        why = "the bounces by which motions fall quiet are too low beside a wider backlash to be told apart"
        raise _outside(
            "half_backlash", half_backlash, "capture", most, "at most 2^18 min(1, (damping/0.6)^2)/damping", why
        )
    return oscillator


def _outside(parameter: str, value: float, bound: str, limit: float, where: str, why: str) -> OutsideDomain:
    message = f"{parameter} must be {where} = {limit:.6g}, not {value:g}: {why}"
    return OutsideDomain(parameter, value, bound, limit, message)


def fastest_resolved(oscillator: Oscillator) -> float:
    """Speed above which flights from wall to wall are too short for double precision.

    Parameters
    ----------
    oscillator : Oscillator

    Returns
    -------
    float
    """
    return 2.0 * oscillator.half_backlash / SHORTEST_FLIGHT


def fastest_decided(oscillator: Oscillator, impacts: int) -> float:
    """Speed above which a motion is still fast after so many impacts, and so ends undecided.

    Damping takes delta from the speed for each unit of length, so 4 beta delta between two impacts at +beta.

    Parameters
    ----------
    oscillator : Oscillator
    impacts : int

    Returns
    -------
    float
    """
    return min(4.0 * oscillator.half_backlash * oscillator.damping * impacts, fastest_resolved(oscillator))


def fastest_of(oscillator: Oscillator) -> float:
    """Velocity up to which a window reaches that follows the machine: well above where it rattles.

    It is 12 times the damping, or 1.3 times the greatest grazing speed.

    Parameters
    ----------
    oscillator : Oscillator

    Returns
    -------
    float

    Raises
    ------
    OutsideDomain
    """
    return float(f"{max(12.0 * oscillator.damping, 1.3 * largest_grazing_speed(oscillator)):.3g}")


def check_window(oscillator: Oscillator, grid: CellGrid, iterations: int) -> Oscillator:
    """Return an oscillator, or raise if motions that begin in a window can only end undecided.

    Parameters
    ----------
    oscillator : Oscillator
        Inside the domain of the map.
    grid : CellGrid
        The window.
    iterations : int
        k: applications of P to each cell.

    Returns
    -------
    Oscillator

    Raises
    ------
    OutsideDomain, InvalidJob
        Naming the bound and its value.
    """
    limit = fastest_decided(check_decidable(oscillator), iterations + FOLLOWED)
    why = (
        f"at damping {oscillator.damping:g} and half backlash {oscillator.half_backlash:g} a faster motion is not "
        f"decided within k = {iterations} and {FOLLOWED} more impacts. The machine rattles well below "
        f"{fastest_of(oscillator):g} (12 damping, or 1.3 times the greatest grazing speed)"
    )
    check_fastest(grid.velocity_stop, limit, why, ("grid", "velocity", "stop"))
    return oscillator


def check_fastest(speed: float, limit: float, why: str, place: FieldPath = ()) -> None:
    """Refuse a request that reaches up to a speed beyond a limit.

    Parameters
    ----------
    speed, limit : float
    why : str
        What is not possible above the limit.
    place : tuple of str and int
        Where the speed stands in the request.

    Raises
    ------
    InvalidJob
    """
    if speed > limit:
        raise InvalidJob(f"speeds must be at most {limit:.6g}, not {speed:g}: {why}", place)

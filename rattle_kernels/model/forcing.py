"""Forcings of machines: a pair of eccentric gears, torque ripple, and any sum of orders as the model takes it.

The model's first harmonic is the eccentricity, whose phase is 0: it says where time begins. So a sum of orders is
shifted in time until that is so.
"""

import cmath
import math
from collections import defaultdict
from collections.abc import Iterable
from typing import NamedTuple, TypedDict

from rattle_kernels.model.harmonics import Harmonic

TWO_PI = 2.0 * math.pi
# Equal forcings get equal numbers, so equal digests: rounding comes from the processor, and from the unit of an angle.
_DIGITS = 12
_ROUNDING = 1e-15


class Forcing(TypedDict):
    """The forcing of an `Oscillator`: its fields of these names."""

    eccentricity: float
    harmonics: tuple[Harmonic, ...]


class ShiftedForcing(NamedTuple):
    """A forcing, and the time of its components that it calls t = 0, in [0, 1) forcing periods."""

    forcing: Forcing
    shift: float


def shifted_forcing(components: Iterable[Harmonic]) -> ShiftedForcing:
    """Forcing that some harmonics add up to, of any orders from 1 on.

    Parameters
    ----------
    components : iterable of Harmonic
        Orders may be there twice: those are added as vectors. Amplitudes may be negative. What cancels out is left out.

    Returns
    -------
    ShiftedForcing
        Amplitudes have 12 digits, phases 12 decimals. Without a first order the shift is 0.
    """
    vectors: dict[float, complex] = defaultdict(complex)
    largest = 0.0
    for order, amplitude, phase in components:
        vectors[float(order)] += amplitude * cmath.exp(1j * TWO_PI * math.remainder(phase, 1.0))
        largest = max(largest, abs(amplitude))
    # Opposite vectors leave rounding, whose direction says nothing.
    vectors = {order: vector for order, vector in vectors.items() if abs(vector) > _ROUNDING * largest}
    first = vectors.pop(1.0, 0j)
    shift = -cmath.phase(first) / TWO_PI % 1.0 % 1.0 if first else 0.0
    harmonics = (_harmonic(order, vectors[order], shift) for order in sorted(vectors))
    eccentricity = float(f"{abs(first):.{_DIGITS}g}")
    return ShiftedForcing({"eccentricity": eccentricity, "harmonics": tuple(harmonics)}, shift)


def _harmonic(order: float, vector: complex, shift: float) -> Harmonic:
    phase = round((cmath.phase(vector) / TWO_PI + order * shift) % 1.0, _DIGITS)
    return Harmonic(order, float(f"{abs(vector):.{_DIGITS}g}"), phase % 1.0)


def eccentric_gears(p: int, q: int, first: float, second: float, assembly: float = 0.0) -> Forcing:
    """Forcing of two eccentric gears of which the first turns p times while the second turns q times.

    The forcing period is the time in which both come back, so the gears are the orders p and q. Where p = q = 1 they
    add up to one eccentricity, and the assembly decides how large it is. The model's units go with that period: against
    those of one turn of the first gear damping is p times as large, and lengths (backlash, eccentricities) are divided
    by p, because in freeplay the gears part at 4 pi lengths a period.

    Parameters
    ----------
    p, q : int
        Without a common divisor, 1 or more.
    first, second : float
        Their eccentricities.
    assembly : float
        Turns of the second gear by which its eccentricity leads that of the first, where that points along the line
        of action. It is the phase of the second gear's order.

    Returns
    -------
    Forcing
        For `Oscillator`, or any verb.

    Raises
    ------
    ValueError
        If p and q are no such numbers.

    Examples
    --------
    >>> eccentric_gears(1, 2, 0.1, 0.01, assembly=0.375)
    {'eccentricity': 0.1, 'harmonics': (Harmonic(order=2.0, amplitude=0.01, phase=0.375),)}
    >>> round(eccentric_gears(1, 1, 0.1, 0.05, assembly=0.5)["eccentricity"], 3)
    0.05
    """
    if not (p == int(p) and q == int(q) and p >= 1 and q >= 1 and math.gcd(int(p), int(q)) == 1):
        raise ValueError(f"gears turn p and q times, whole numbers from 1 on without a common divisor, not {p} and {q}")
    return shifted_forcing((Harmonic(p, first), Harmonic(q, second, assembly))).forcing


def torque_ripple(order: int, torque: float, phase: float, damping: float) -> Harmonic:
    """Harmonic that forces as a torque ``torque cos(2 pi (order t + phase))`` on the right side of Eq. (1).

    With w = 2 pi order, a transmission error ``eps cos`` stands there as ``eps (-w^2 + i w delta)``. So the amplitude
    is ``torque/|-w^2 + i w delta|``. This holds in freeplay and in contact: the right side is the same.

    Parameters
    ----------
    order : int
        Times a forcing period, 1 or more. The first is the eccentricity's: `eccentric_gears` adds two such up.
    torque : float
        In the units of the mean torque, which is ``4 pi delta``.
    phase : float
        In periods of the ripple.
    damping : float
        delta.

    Returns
    -------
    Harmonic

    Raises
    ------
    ValueError
        If the order is not 1 or more, or a whole number.

    Examples
    --------
    >>> ripple = torque_ripple(2, torque=1.0, phase=0.0, damping=0.6)
    >>> round(ripple.amplitude, 6), round(ripple.phase, 6)
    (0.006325, 0.507593)
    """
    if not (order == int(order) and order >= 1):
        raise ValueError(f"orders of torque ripple are whole numbers from 1 on, not {order}")
    rate = TWO_PI * order
    error = torque / complex(-rate * rate, rate * damping)
    return _harmonic(float(order), error * cmath.exp(1j * TWO_PI * phase), 0.0)

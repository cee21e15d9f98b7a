"""P(m, 1, 0) in closed form: one impact on +beta every m forcing periods, none on -beta (the family behind Eq. 41).

A flight leaves +beta with speed v and returns after a time m. The forcing terms are then the same again, s = s0 and c =
c0, so the velocity is -v + 4 pi delta m. An elastic impact requires it to be v, hence ``v = 2 pi delta m`` for all eps
and beta. With x = delta m, y(m) = 0 then reads phi1 (2 pi eps s0 - v) + 4 pi x phi2 = 0, that is

    eps sin(2 pi t0) = 2 - x coth(x/2) = -(x^2/6 - x^4/360 + ...).

So the two orbits of each m are born together, at t0 = 3/4 and at the exact bound eps = x coth(x/2) - 2, whose series is
Eq. (41). Then they move apart. With S = (1 - e^{-x})/delta and a the acceleration at rest at t0, the trace of DP is

    -1 - e^{-x} + 2 a S/v = 1 + e^{-x} - 8 pi^2 eps cos(2 pi t0) S/v.

Below epsilon_crit2, a is positive and the trace exceeds -1 - e^{-x}, so neither orbit ever doubles its period. The
orbit with cos(2 pi t0) > 0 attracts wherever it exists; the other is a saddle. Both exist while they stay clear of
-beta, at ``v <= v*(t0)``. Beyond that the flight would meet -beta.
"""

import math
from typing import NamedTuple

from rattle_kernels.model.domain import check_impacting
from rattle_kernels.model.flight import FOUR_PI, TWO_PI, second_phi, second_phi_slope
from rattle_kernels.model.grazing_curve import grazing_velocity
from rattle_kernels.model.oscillator import Oscillator


class SingleContactOrbit(NamedTuple):
    """One of the two orbits P(m, 1, 0).

    ``t``, ``v`` are the departure. ``trace`` is the trace of DP, whose determinant is e^{-delta m}. ``grazing_margin``
    is v - v*(t), negative while the orbit exists.
    """

    forcing_periods: int
    t: float
    v: float
    trace: float
    grazing_margin: float

    @property
    def exists(self) -> bool:
        """Whether the flight stays clear of -beta."""
        return self.grazing_margin <= 0.0


def eccentricity_bound_single_contact(damping: float, forcing_periods: int = 1) -> float:
    """Eccentricity at which the two orbits P(m, 1, 0) are born: the exact form of Eq. (41).

    Parameters
    ----------
    damping : float
        delta > 0.
    forcing_periods : int
        m > 0.

    Returns
    -------
    float
        ``x coth(x/2) - 2`` with x = delta m, accurate to rounding even where it is tiny.
    """
    x = damping * forcing_periods
    # x coth(x/2) - 2 = x (2 phi2 - phi1)/phi1, and phi1 - 2 phi2 = x phi2': nothing cancels.
    return -x * x * float(second_phi_slope(x)) / (1.0 - x * float(second_phi(x)))


def single_contact_orbits(oscillator: Oscillator, forcing_periods: int = 1) -> tuple[SingleContactOrbit, ...]:
    """Both orbits P(m, 1, 0) of the impacting model, or none below the bound of Eq. (41).

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model.
    forcing_periods : int
        m > 0.

    Returns
    -------
    tuple of SingleContactOrbit
        The attracting orbit first, then the saddle. `exists` says whether an orbit stays clear of -beta.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.

    References
    ----------
    Sec. 5.2, Eq. (41), given there as a series without derivation (Halse et al., 2007; Mason et al., 2007).
    """
    checked = check_impacting(oscillator)
    bound = eccentricity_bound_single_contact(checked.damping, forcing_periods)
    if not checked.eccentricity > bound:
        return ()
    turn = math.asin(bound / checked.eccentricity) / TWO_PI
    return tuple(_at_phase(checked, forcing_periods, t) for t in (1.0 - turn, 0.5 + turn))


def _at_phase(oscillator: Oscillator, forcing_periods: int, t: float) -> SingleContactOrbit:
    x = oscillator.damping * forcing_periods
    v = 0.5 * FOUR_PI * x
    stretch = -math.expm1(-x) / oscillator.damping
    fall = TWO_PI * TWO_PI * oscillator.eccentricity * math.cos(TWO_PI * t)
    trace = 1.0 + math.exp(-x) - 2.0 * fall * stretch / v
    return SingleContactOrbit(forcing_periods, t, v, trace, v - float(grazing_velocity(oscillator, t)))

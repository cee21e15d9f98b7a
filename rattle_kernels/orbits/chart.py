"""Unknowns in which a branch of orbits is smooth.

In the impacting model a branch keeps the flights that meet -beta, and (t, v, p) with the first departure (t, v) serve
as unknowns all along. With finite stiffness it passes grazes, next to which P turns within 1/kappa. There

- a flight that misses -beta passes over it in the equations, which are the same and smooth beyond the graze;
- a flight that meets -beta gently is followed from its touch (`touching_orbit`).

So the graze is the end of either side, and neither side has an equation that is not smooth there.
"""

from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.grazing_distance import grazing_distances
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.pseudo_arclength import System
from rattle_kernels.orbits.closure import OrbitShape, closure, departures_from
from rattle_kernels.orbits.orbit_equations import Unknowns, closing_system
from rattle_kernels.orbits.touching_orbit import touching_orbit

# A touch of -beta with less than this part of the speed of a fall through the backlash is gentle.
GENTLE = 0.05


class SeenOrbit(NamedTuple):
    """An orbit at a point of a chart: its departures, their derivatives by the unknowns, and DP^p.

    ``moves`` has shape (n, 2, unknowns). ``jacobian`` is DP^p or, seen from touches, a matrix of its multipliers.
    """

    oscillator: Oscillator
    t: np.ndarray
    v: np.ndarray
    margin: np.ndarray
    lower_speed: np.ndarray
    moves: np.ndarray
    jacobian: np.ndarray


class Chart(NamedTuple):
    """Unknowns (t, v, p), or (tau, u) of each gentle touch and p.

    ``shape.over`` has the bits of the flights that miss -beta. ``lower``, in the impacting model, is how often it
    must be met on each way from +beta to +beta.
    """

    space: Unknowns
    shape: OrbitShape
    gentle: tuple[int, ...] = ()
    lower: tuple[int, ...] | None = None

    @property
    def parameter(self) -> str:
        """Name of the parameter that varies."""
        return self.space.parameters[0]

    def system(self) -> System:
        """The equations of the orbit."""
        if not self.gentle:
            return closing_system(self.space, self.shape, self.lower)
        rows = np.tile([1.0, self.space.scales[1]], len(self.gentle))

        def system(z: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
            read = self.space.read(z)
            seen = None
            if read is not None:
                seen = touching_orbit(read[0], self.parameter, self.shape, self.gentle, self.touches(z))
            return None if seen is None else (seen.gap / rows, seen.slopes * self.space.scales / rows[:, None])

        return system

    def touches(self, z: np.ndarray) -> np.ndarray:
        """Phases and speeds of the gentle touches, shape (k, 2)."""
        return (z * self.space.scales)[:-1].reshape(-1, 2)

    def is_like(self, other: "Chart") -> bool:
        """Whether another chart of the branch has the same unknowns and equations."""
        return (self.shape, self.gentle) == (other.shape, other.gentle)

    def is_missing(self, flight: int) -> bool:
        """Whether a flight passes over -beta in the equations."""
        return bool(self.shape.over >> flight & 1)

    def orbit_at(self, z: np.ndarray) -> SeenOrbit | None:
        """The orbit at a point, None where its equations are not defined."""
        read = self.space.read(z)
        if read is None:
            return None
        oscillator = read[0]
        if self.gentle:
            seen = touching_orbit(oscillator, self.parameter, self.shape, self.gentle, self.touches(z))
            if seen is None:
                return None
            t, v, moves, jacobian = seen.t, seen.v, seen.moves * self.space.scales, seen.jacobian
        else:
            closed = closure(oscillator, self.parameter, self.shape, read[1], read[2])
            if closed is None:
                return None
            orbit = departures_from(oscillator, self.parameter, self.shape, read[1], read[2])
            t, v, jacobian = orbit.t, orbit.v, closed.jacobian
            moves = np.concatenate([orbit.jacobian, orbit.sensitivity[:, :, None]], axis=2) * self.space.scales
        margin, lower_speed = grazing_distances(oscillator, t, v)
        if self.gentle:
            # Margins are like u^2, and rounding may hide them.
            here = list(self.gentle)
            margin[here] = np.maximum(margin[here], np.finfo(float).tiny)
            lower_speed[here] = self.touches(z)[:, 1]
        return SeenOrbit(oscillator, t, v, margin, lower_speed, moves, jacobian)


def chart_of(space: Unknowns, shape: OrbitShape, gentle: tuple[int, ...], missing: int) -> Chart:
    """Chart of an orbit of finite stiffness.

    Parameters
    ----------
    space : Unknowns
        (t, v, p) of the branch.
    shape : OrbitShape
    gentle : tuple of int
        Flights that are followed from their touches, in order.
    missing : int
        Bits of the flights that miss -beta.

    Returns
    -------
    Chart
    """
    if gentle:
        scales = np.append(np.tile(space.scales[:2], len(gentle)), space.scales[2])
        space = space._replace(scales=scales)
    return Chart(space, shape._replace(over=missing), gentle)

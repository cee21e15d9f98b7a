"""The backlash oscillator, Eqs. (1, 2), and its impacting limit (4, 5): its parameters."""

import math
from typing import Any, NamedTuple

from rattle_kernels.model.arcs import Arcs, arcs_of
from rattle_kernels.model.harmonics import MOST_IN_A_TUPLE, Harmonic, records_of


class Oscillator(NamedTuple):
    """Parameters of the gear pair; everything is nondimensional and time counts forcing periods.

    Parameters
    ----------
    damping : float
        delta > 0.
    eccentricity : float
        epsilon, amplitude of the order-one forcing, at least 0; from ``epsilon_crit2`` on (Eq. 8) gears are loose.
    half_backlash : float
        beta > 0.
    stiffness : float
        kappa; infinite for the impacting model.
    permanent_after : float
        A contact beyond +beta that lasts longer than this many forcing periods counts as permanent. Infinity stands
        for the exact rule (the ringing's envelope), 1.0 for the paper's rule, one gross rotation. The impacting model
        does not use it.
    restitution : float
        r, by which an impact multiplies the speed, ``0 < r <= 1``; 1 is elastic. Only the impacting model has impacts.
    contact_damping : float
        zeta, damping of the ringing in contact as a part of the critical one, which adds ``2 zeta sqrt(2 kappa) Phi'``
        there. Only the piecewise linear model has contacts; those that are short leave with ``r = exp(-pi zeta/sqrt(1 -
        zeta^2))`` of their speed.
    harmonics : tuple of Harmonic
        Harmonics of the forcing beside the first: ``(order, amplitude, phase)``.

    Examples
    --------
    >>> Oscillator(damping=0.6, eccentricity=0.1, half_backlash=0.6).at(stiffness=1e4).stiffness
    10000.0
    >>> Oscillator(harmonics=((2, 0.01, 0.25),)).at(phase_2=0.5).value_of("phase_2")
    0.5
    """

    damping: float = 0.6
    eccentricity: float = 0.1
    half_backlash: float = 0.6
    stiffness: float = math.inf
    permanent_after: float = math.inf
    restitution: float = 1.0
    contact_damping: float = 0.0
    harmonics: tuple[Harmonic, ...] = ()

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of what a study may vary: those of PARAMETERS, and amplitude and phase of each harmonic by order."""
        orders = [harmonic[0] for harmonic in self.harmonics]
        return (*PARAMETERS, *(f"{part}_{order:g}" for order in orders for part in ("amplitude", "phase")))

    @property
    def all_harmonics(self) -> tuple[Harmonic, ...]:
        """All harmonics of the forcing; the first is the eccentricity, of phase 0."""
        return (Harmonic(1.0, self.eccentricity, 0.0), *self.harmonics)

    @property
    def is_loose(self) -> bool:
        """Whether inertia torque exceeds drag torque at some phases: the bound of Eq. (8) is exceeded."""
        return arcs_of(self) is not None

    @property
    def in_kernels(self) -> "Oscillator | LooseOscillator":
        """The oscillator as kernels take it: more than two harmonics are an array of records; a loose one has arcs."""
        few = len(self.harmonics) <= MOST_IN_A_TUPLE
        inside = self if few else self._replace(harmonics=records_of(self.harmonics))
        arcs = arcs_of(self)
        return inside if arcs is None else LooseOscillator(*inside, arcs)

    def value_of(self, parameter: str) -> float:
        """Value of one of `parameters`.

        Raises
        ------
        ValueError
            If it is none of them.
        """
        if parameter in PARAMETERS:
            return float(getattr(self, parameter))
        place, part = self._place_of(parameter)
        return float(self.harmonics[place][part])

    def at(self, **values: float) -> "Oscillator":
        """The oscillator with other values of some of its `parameters`."""
        changed = self
        for parameter, value in values.items():
            if parameter in PARAMETERS:
                only: dict[str, Any] = {parameter: value}
                changed = changed._replace(**only)
                continue
            place, part = changed._place_of(parameter)
            harmonics = [list(harmonic) for harmonic in changed.harmonics]
            harmonics[place][part] = value
            changed = changed._replace(harmonics=tuple(Harmonic(*harmonic) for harmonic in harmonics))
        return changed

    def _place_of(self, parameter: str) -> tuple[int, int]:
        names = self.parameters[len(PARAMETERS) :]
        if parameter not in names:
            raise ValueError(f"parameter must be one of {', '.join(self.parameters)}, not {parameter!r}")
        place, part = divmod(names.index(parameter), 2)
        return place, 1 + part


class LooseOscillator(NamedTuple):
    """A loose oscillator in kernels: its type alone chooses the flights from arc to arc. Fields as in `Oscillator`."""

    damping: float
    eccentricity: float
    half_backlash: float
    stiffness: float
    permanent_after: float
    restitution: float
    contact_damping: float
    harmonics: tuple[Harmonic, ...]
    arcs: Arcs


# The numbers that a study may vary, beside those of harmonics. `permanent_after` is a rule, not a property.
PARAMETERS = ("damping", "eccentricity", "half_backlash", "stiffness", "restitution", "contact_damping")

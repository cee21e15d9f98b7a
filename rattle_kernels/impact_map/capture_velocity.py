"""The speed below which quiet is certain: the upper edge of the region in which ever lower bounces capture a motion."""

import numpy as np

from rattle_kernels.impact_map.adiabatic_invariant import capture_bound
from rattle_kernels.impact_map.chatter import fastest_below
from rattle_kernels.model.departures import check_phases
from rattle_kernels.model.domain import check_domain
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import kernel


@kernel
def _fastest_of_all(oscillator, bound, phase, velocity):
    for i in range(phase.size):
        velocity[i] = fastest_below(oscillator, bound, phase[i])


def capture_velocity(oscillator: Oscillator, t: np.typing.ArrayLike) -> np.ndarray:
    """Speed below which every departure falls quiet for certain: ever lower bounces capture it.

    Faster departures may fall quiet as well, but that is not certain.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    t : array_like
        Phases of departure from +beta, forcing periods, any finite value.

    Returns
    -------
    ndarray of float64, shape of ``t``
        0 where nothing is certain.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    ValueError
        If a phase is not finite.

    Examples
    --------
    >>> speeds = capture_velocity(Oscillator(damping=0.6, eccentricity=0.1, half_backlash=0.6), [0.0, 0.5])
    >>> bool((speeds < grazing_velocity(Oscillator(), [0.0, 0.5])).all())
    True
    """
    checked, phase = check_domain(oscillator), check_phases(t)
    velocity = np.empty(phase.size)
    _fastest_of_all(checked, capture_bound(checked), phase.ravel(), velocity)
    return velocity.reshape(phase.shape)

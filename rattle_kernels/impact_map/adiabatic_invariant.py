"""The action of a low bounce, corrected, and how far up it falls at every application of P.

The slow change of a(t) conserves the action J of `chatter` only to first order in the duration of a bounce. At a
damping of delta it is seen to fall only where a bounce takes less than some six delta of a period. The invariant proper
is a series

    L = ln J + u^2 f_1(t) + u^4 f_2(t) + ...,   u = (1.5 J/g^2)^(1/3),  g = 4 pi delta,

where u is about half the duration of a bounce. Only even powers and even f_j occur, since without damping a bounce
backwards in time is a bounce. The coefficients need no algebra. That P lowers L by delta T is linear in them, so they
are fitted to P itself by least squares. Such a series diverges, and nothing is won beyond u^6. At a damping of 6e-4 it
is worth an order of magnitude in u: it reaches up to where bounces resonate with the forcing and periodic orbits
attract.

A fit shows nothing. What counts is the descent test of `chatter`, applied to L: q = (change of L)/(delta T) is at most
-1/2 at every node of a mesh and differs by less than 1/4 between neighbours.
"""

import math
from functools import lru_cache

import numpy as np

from rattle_kernels.impact_map.apply import next_impact
from rattle_kernels.impact_map.chatter import (
    bounce_level,
    descends_everywhere,
    descent_bound,
    fastest_below,
    ringing_radian,
)
from rattle_kernels.impact_map.sticking import sticking_bound
from rattle_kernels.model.flight import FOUR_PI, range_at_rest, rest_acceleration
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_PERMANENT_CONTACT, OUTCOME_RETURNED
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.numerics.least_squares import least_squares

_POWERS = (2, 4, 6)
_HARMONICS = 20
_FIT_PHASES, _FIT_SIZES = 80, 16
_TEST_PHASES, _TEST_SIZES = 320, 32
# Of the length of a column: below it is rounding.
_LEAST = 1e-12
# Bounces of a twelfth of a period are in resonance at every damping for which this is used.
_LARGEST_SIZE = 0.04
_SHRINK = 0.92
_ROUNDS = 10
# If fewer impacts lead from one bound to the other, the half second of the fits does not pay.
_LEAST_GAIN = 20_000.0
# Swing of the acceleration at rest in units of its mean, beyond which 20 harmonics are too few.
_LARGEST_SWING = 0.95
# Distance in ln J kept from the edge of the region tested.
_MARGIN = 0.05


@kernel
def _bounce_all(oscillator, sizes, phases, next_size, next_phase, elapsed):
    """Apply P to a bounce of each size at each phase. Nothing is written where there is no bounce or no next one.

    Returns whether every bounce is low: P is found, and -beta is not met. The first that is not ends the work.
    """
    gravity = FOUR_PI * oscillator.damping
    radian = ringing_radian(oscillator)
    for i in range(sizes.size):
        for j in range(phases.size):
            speed = fastest_below(oscillator, gravity * gravity * sizes[i] ** 3, phases[j])
            if not speed > 0.0:
                continue
            impact = next_impact(oscillator, phases[j], speed)
            if impact.outcome == OUTCOME_PERMANENT_CONTACT:
                continue
            if impact.outcome != OUTCOME_RETURNED or impact.lower_impacts > 0:
                return False
            acceleration = rest_acceleration(oscillator, impact.t)
            level = bounce_level(radian, acceleration, impact.v)
            next_size[i, j] = (level / (acceleration * gravity * gravity)) ** (1.0 / 3.0)
            next_phase[i, j], elapsed[i, j] = impact.t, impact.duration
    return True


def _powers(size: np.ndarray) -> np.ndarray:
    return np.stack([size**power for power in _POWERS], axis=-1)


def _waves(phase: np.ndarray) -> np.ndarray:
    return np.cos(2.0 * np.pi * np.arange(_HARMONICS + 1) * phase[..., None])


def _terms(size: np.ndarray, phase: np.ndarray) -> np.ndarray:
    return _powers(size)[..., :, None] * _waves(phase)[..., None, :]


def _correction(size: np.ndarray, phase: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
    """Sum of all terms, L - ln J: over the waves first, which may be fewer than the sizes."""
    by_power = np.einsum("...w,pw->...p", _waves(phase), coefficients)
    corrected: np.ndarray = (_powers(size) * by_power).sum(axis=-1)
    return corrected


class _Bounces:
    """Bounces of some sizes (rows) at some phases (columns), and the bounces after them."""

    def __init__(self, oscillator: Oscillator, sizes: np.ndarray, phases: np.ndarray) -> None:
        self.size, self.phase = sizes[:, None], phases
        self.later, self.when, elapsed = np.full((3, sizes.size, phases.size), math.nan)
        self.low = bool(_bounce_all(oscillator, sizes, phases, self.later, self.when, elapsed))
        with np.errstate(divide="ignore"):
            self.growth = 3.0 * np.log(self.later / self.size)
        self.known = np.isfinite(self.growth)
        self.decay = oscillator.damping * elapsed

    def fit(self) -> np.ndarray:
        """Coefficients, shape (powers, waves), with which L falls most nearly by delta T."""
        known, weight = self.known, 1.0 / self.decay[self.known]
        size, phase = (each[known] for each in np.broadcast_arrays(self.size, self.phase))
        change = _terms(self.later[known], self.when[known]) - _terms(size, phase)
        system = change.reshape(weight.size, -1) * weight[:, None]
        return least_squares(system, -self.growth[known] * weight - 1.0, _LEAST).reshape(change.shape[1:])

    def correction(self, coefficients: np.ndarray) -> np.ndarray:
        return _correction(self.size, self.phase, coefficients)

    def descents(self, coefficients: np.ndarray) -> np.ndarray:
        """Change of L in units of delta T; -1 where no bounce follows."""
        change = _correction(self.later, self.when, coefficients) - self.correction(coefficients)
        return np.where(self.known, (self.growth + change) / self.decay, -1.0)


def _bound_below(oscillator: Oscillator, size: float) -> float:
    """Safe bound on ``1.5 J`` within the bounces of at most this size; 0 unless L falls at all of them."""
    nodes = 0.5 - 0.5 * np.cos(np.pi * (np.arange(_FIT_SIZES) + 0.5) / _FIT_SIZES)
    fitted = _Bounces(oscillator, size * nodes, (np.arange(_FIT_PHASES) + 0.5) / _FIT_PHASES)
    if not fitted.low or fitted.known.sum() < len(_POWERS) * (_HARMONICS + 1):
        return 0.0
    coefficients = fitted.fit()
    sizes = size * (np.arange(_TEST_SIZES) + 1) / _TEST_SIZES
    tested = _Bounces(oscillator, sizes, np.arange(_TEST_PHASES) / _TEST_PHASES)
    if not tested.low or not descends_everywhere(tested.descents(coefficients)):
        return 0.0
    correction = tested.correction(coefficients)
    # At every bounce below the bound, L is less than anywhere on the edge of the region tested. L falls, so J stays
    # inside; the margin is more than J changes in one bounce.
    if np.abs(tested.growth[tested.known]).max() > _MARGIN:
        return 0.0
    gravity = FOUR_PI * oscillator.damping
    return float(gravity**2 * size**3 * math.exp(correction.min() - correction.max() - _MARGIN))


def _raise_bound(oscillator: Oscillator, bound: float) -> float:
    """The larger of a safe bound by J and the one by L."""
    gravity = FOUR_PI * oscillator.damping
    least, greatest = range_at_rest(oscillator)
    # Without a region safe by J there is nothing below that of L.
    if bound == 0.0 or greatest - least > _LARGEST_SWING * (greatest + least):
        return bound
    reached, size = (bound / gravity**2) ** (1.0 / 3.0), _LARGEST_SIZE
    for _ in range(_ROUNDS):
        # A bounce of size u takes 2 u of a period, and u falls by delta/3 of itself in one.
        if 1.5 / oscillator.damping * (1.0 / reached - 1.0 / size) < _LEAST_GAIN:
            break
        raised = _bound_below(oscillator, size)
        if raised > bound:
            return raised
        size *= _SHRINK
    return bound


@lru_cache(maxsize=32)
def capture_bound(oscillator: Oscillator) -> float:
    """Largest known bound on ``1.5 J`` below which ever lower bounces capture a departure.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.

    Returns
    -------
    float
        0 where no region is safe: then nothing is ever captured. Nothing is beyond the bound of Eq. (8), where gears
        that lie on +beta are released; a soft contact that never ends is found as such.
    """
    if oscillator.is_loose:
        return 0.0
    # An impact that loses energy takes a departure to a lower one: what is safe without losses is safe with them.
    elastic = oscillator._replace(restitution=1.0)
    bound = _raise_bound(elastic, descent_bound(elastic, np.empty(12), np.empty(12)))
    return max(bound, sticking_bound(oscillator)) if oscillator.restitution < 1.0 else bound

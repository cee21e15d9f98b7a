"""A measured transmission error as a forcing: its Fourier coefficients, as few as explain a stated part of it.

Coefficients come from weighted least squares, each sample weighted by the angle that it stands for. With equally spaced
angles over whole revolutions that is the discrete Fourier transform. Orders are looked for as far as the widest gap
between angles allows, ``order < 1/(2 gap)``: up to there the equations are well conditioned (K. Groechenig,
Reconstruction algorithms in irregular sampling, Math. Comp. 59 (1992) 181-194).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rattle_kernels.model.arcs import rest_acceleration_over_phases
from rattle_kernels.model.forcing import Forcing, shifted_forcing
from rattle_kernels.model.harmonics import Harmonic
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.trigonometric_minimum import least_value

TWO_PI = 2.0 * math.pi
HIGHEST_ORDER = 200
"""Highest order that is looked for. What lies above counts as left out."""
_ROUNDING = 1e-12


class AngleUnit(StrEnum):
    """What angles are counted in."""

    TURNS = "turns"
    DEGREES = "degrees"
    RADIANS = "radians"


_PER_TURN = {AngleUnit.TURNS: 1.0, AngleUnit.DEGREES: 360.0, AngleUnit.RADIANS: TWO_PI}


class UnusableCurve(ValueError):
    """A measured curve has no usable Fourier coefficients.

    Attributes
    ----------
    sample : int or None
        The sample at fault, if it is one.
    """

    def __init__(self, message: str, sample: int | None = None) -> None:
        super().__init__(message)
        self.sample = sample

    def __reduce__(self) -> tuple[type, tuple[str, int | None]]:
        return type(self), (str(self), self.sample)


class LeftOut(NamedTuple):
    """What harmonics leave out of a curve: the largest order among it (None if none was found), and all of it."""

    order: int | None
    amplitude: float
    rms: float


@dataclass(frozen=True)
class TransmissionError:
    """A measured transmission error as a forcing; made by `transmission_error`.

    Attributes
    ----------
    eccentricity : float
        Amplitude of the first order, 0 if it is not kept.
    harmonics : tuple of Harmonic
        The other orders that are kept.
    shift : float
        Angle of the measurement at which t = 0, in turns: there the first order is largest.
    explained : float
        Part of the variance over a revolution that the kept orders explain.
    left_out : LeftOut
        Its amplitude and rms are in the model's units, as everything here.
    scale : float
        Model units in one unit of the measured error.
    highest : int
        Highest order that the samples can tell.

    Examples
    --------
    >>> import rattle
    >>> angle = [k / 64 for k in range(64)]
    >>> import math
    >>> error = rattle.transmission_error(angle, [0.1 * math.cos(2 * math.pi * (a - 0.25)) for a in angle])
    >>> isinstance(error, rattle.TransmissionError), error.eccentricity, error.harmonics
    (True, 0.1, ())
    """

    eccentricity: float
    harmonics: tuple[Harmonic, ...]
    shift: float
    explained: float
    left_out: LeftOut
    scale: float
    highest: int

    @property
    def forcing(self) -> Forcing:
        """Arguments of an `Oscillator`, or of a verb: ``rattle.basin(**error.forcing)``."""
        return {"eccentricity": self.eccentricity, "harmonics": self.harmonics}

    @property
    def orders(self) -> tuple[int, ...]:
        """Orders that are kept."""
        first = (1,) if self.eccentricity > 0.0 else ()
        return first + tuple(int(harmonic.order) for harmonic in self.harmonics)

    def least_acceleration(self, damping: float) -> tuple[float, float]:
        """Least acceleration at rest in freeplay, and its phase t. Eq. (8) holds where it is positive.

        Parameters
        ----------
        damping : float
            delta.

        Returns
        -------
        (float, float)
        """
        return least_value(rest_acceleration_over_phases(Oscillator(damping=damping, **self.forcing)))


def transmission_error(
    angle: ArrayLike, error: ArrayLike, *, unit: str = "turns", explained: float = 0.99, scale: float = 1.0
) -> TransmissionError:
    """Make a forcing of a measured transmission error.

    Parameters
    ----------
    angle, error : array_like
        Samples by increasing angle of the gear whose rotation is the forcing period; over one revolution or more,
        equally spaced or not. The mean of the error is removed.
    unit : {"turns", "degrees", "radians"}
        Of the angle.
    explained : float
        The kept orders are the fewest that explain this part of the variance.
    scale : float
        The model is nondimensional: errors are multiplied by this to be in the units of its half backlash.

    Returns
    -------
    TransmissionError

    Raises
    ------
    UnusableCurve
        Naming what is wrong.
    """
    if unit not in list(AngleUnit):
        raise UnusableCurve(f"unit must be one of {', '.join(AngleUnit)}, not {unit!r}")
    if not 0.0 < explained <= 1.0:
        raise UnusableCurve(f"explained must be above 0 and at most 1, not {explained:g}")
    if not (math.isfinite(scale) and scale != 0.0):
        raise UnusableCurve(f"scale must be finite and not 0, not {scale:g}")
    turns, values = _checked(angle, error)
    turns = turns / _PER_TURN[AngleUnit(unit)]
    highest = _highest_order(turns, unit)
    coefficients, residual = _fitted(turns, scale * values, highest)
    return _kept(coefficients, residual, explained, scale)


def _checked(angle: ArrayLike, error: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    angles, errors = np.asarray(angle, np.float64), np.asarray(error, np.float64)
    if not (angles.ndim == errors.ndim == 1 and angles.size == errors.size):
        raise UnusableCurve(f"angle and error must be lists as long as each other, not {angles.size} and {errors.size}")
    if angles.size < 3:
        raise UnusableCurve(f"a curve needs at least three samples, not {angles.size}")
    for name, values in (("angle", angles), ("error", errors)):
        astray = np.flatnonzero(~np.isfinite(values))
        if astray.size:
            raise UnusableCurve(f"{name} must be finite, not {values[astray[0]]}", int(astray[0]))
    back = np.flatnonzero(np.diff(angles) <= 0.0)
    if back.size:
        place = int(back[0]) + 1
        raise UnusableCurve(f"angle must increase: {angles[place]:g} follows {angles[place - 1]:g}", place)
    return angles, errors


def _highest_order(turns: np.ndarray, unit: str) -> int:
    """Highest order that the widest gap between angles allows, all revolutions laid over one another."""
    folded = np.sort(turns % 1.0)
    gaps = np.diff(folded, append=folded[0] + 1.0)
    widest = float(gaps.max())
    highest = math.ceil(0.5 / widest - 1e-6) - 1
    if highest < 1:
        where = float(folded[int(gaps.argmax())])
        raise UnusableCurve(
            f"angles must lie less than half a turn apart around a whole revolution; after {where:.4g} turns none "
            f"follows for {widest:.4g}. They are read as {unit}"
        )
    return min(highest, HIGHEST_ORDER)


def _weights(turns: np.ndarray) -> np.ndarray:
    """Part of all angles that each sample stands for: half the way to its neighbours, the ends' being each other's."""
    steps = np.diff(turns)
    # Nothing where the last sample is the first one again, a whole number of revolutions on.
    span = float(turns[-1] - turns[0])
    open_end = max(math.ceil(span - 1e-9) - span, 0.0)
    before = np.concatenate([[min(open_end, steps[0])], steps])
    after = np.concatenate([steps, [min(open_end, steps[-1])]])
    weights: np.ndarray = before + after
    return weights / weights.sum()


def _fitted(turns: np.ndarray, errors: np.ndarray, highest: int) -> tuple[np.ndarray, float]:
    """Complex amplitudes of orders 1 to the highest, and the mean square of what they do not fit."""
    weights = _weights(turns)
    centred = errors - weights @ errors
    mean_square = float(weights @ (centred * centred))
    if not mean_square > (_ROUNDING * float(abs(errors).max())) ** 2:
        raise UnusableCurve("the error is the same at every angle: there is nothing to force with")
    # The matrix of the normal equations depends on differences of orders alone.
    moments = np.array([weights @ wave for wave in _waves(turns, 2 * highest)])
    right = np.array([(weights * centred) @ wave for wave in _waves(turns, highest)])
    orders = np.arange(-highest, highest + 1)
    apart = orders[:, None] - orders
    matrix = np.where(apart >= 0, moments[abs(apart)], moments[abs(apart)].conj())
    solved = np.linalg.solve(matrix, np.concatenate([right[:0:-1].conj(), right]))[highest:]
    rest = centred - solved[0].real
    for coefficient, wave in zip(solved[1:], islice(_waves(turns, highest), 1, None), strict=True):
        rest -= 2.0 * (coefficient * wave.conj()).real
    return 2.0 * solved[1:], float(weights @ (rest * rest))


def _waves(turns: np.ndarray, highest: int) -> Iterator[np.ndarray]:
    """exp(-2 pi i n turns) of orders 0 to the highest. Each is the last one turned on: faster than sines."""
    turned = np.exp(-1j * TWO_PI * (turns % 1.0))
    wave = np.ones_like(turned)
    yield wave
    for _ in range(highest):
        wave = wave * turned
        yield wave


def _kept(vectors: np.ndarray, residual: float, explained: float, scale: float) -> TransmissionError:
    """The fewest orders that explain enough."""
    parts = 0.5 * abs(vectors) ** 2
    variance = float(parts.sum()) + residual
    largest_first = np.argsort(-parts, kind="stable")
    reached = np.cumsum(parts[largest_first]) / variance
    if not reached[-1] >= explained - _ROUNDING:
        raise UnusableCurve(
            f"orders up to {vectors.size}, the highest that these samples can tell, explain {reached[-1]:.6g} of the "
            f"variance, not {explained:g}: lower explained, or measure at more angles"
        )
    count = int(np.argmax(reached >= explained - _ROUNDING)) + 1
    kept, rest = np.sort(largest_first[:count]), largest_first[count:]
    components = [
        Harmonic(float(index + 1), float(abs(vectors[index])), float(np.angle(vectors[index])) / TWO_PI)
        for index in kept
    ]
    forcing, shift = shifted_forcing(components)
    rms = math.sqrt(float(parts[rest].sum()) + residual)
    left_out = LeftOut(int(rest[0]) + 1, float(abs(vectors[rest[0]])), rms) if rest.size else LeftOut(None, 0.0, rms)
    return TransmissionError(
        **forcing, shift=shift, explained=min(float(reached[count - 1]), 1.0), left_out=left_out, scale=scale,
        highest=vectors.size,
    )  # fmt: skip

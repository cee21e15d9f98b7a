"""What the lanes look up: a first guess for the duration of any flight, and a series for the grazing curve.

A lane takes one step of sixth order from the guess, so a coarse bilinear table is enough. Three kinds of flight, each
in a variable in which its duration is smooth up to the ends (the square root removes the singularity at grazing):

    kind           value tabulated       abscissa in [0, 1]      ends
    FALL_BACK      tau / v               v / v*                  2/a  ...  duration at graze / v*
    DROP           tau v                 sqrt(1 - v*/v)          graze  ...  2 beta
    RISE           tau (u + u_ref)       u / (u + u_ref)         from rest  ...  2 beta
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from rattle_kernels.capture import capture_bound
from rattle_kernels.flight import rest_acceleration
from rattle_kernels.grazing_curve import LEAVING, grazing_flight, grazing_velocity
from rattle_kernels.impact_map import LOWER, UPPER, next_contact
from rattle_kernels.jit import kernel
from rattle_kernels.oscillator import Oscillator

FALL_BACK, DROP, RISE = 0, 1, 2

# Intervals in phase and in the abscissa. Measured at the paper's parameters: with 192 x 64 one flight in 10,000 takes
# the careful path; with 96 x 64 it is one in 400 (low bounces near the phase of least acceleration), with 192 x 32 one
# in 17.
PHASES = 192
ABSCISSAE = 64
ROW = ABSCISSAE + 1
BLOCK = (PHASES + 1) * ROW

HARMONICS = 16
_SAMPLES = 512


class LaneTables(NamedTuple):
    """Everything the lanes need of one oscillator.

    Parameters
    ----------
    guess : ndarray of float64, shape (3 * BLOCK,)
        The tables of FALL_BACK, DROP and RISE, row by phase.
    grazing_cosine, grazing_sine : ndarray of float64, shape (HARMONICS + 1,)
        Fourier coefficients of v*(t).
    grazing_error : float
        Bound on the error of that series; closer to the curve a lane takes the careful path.
    speed_scale : float
        u_ref: the largest v*.
    capture_bound : float
        Safe bound on v^3/a (see `capture`).
    """

    guess: np.ndarray
    grazing_cosine: np.ndarray
    grazing_sine: np.ndarray
    grazing_error: float
    speed_scale: float
    capture_bound: float


@kernel
def _fill_guess(oscillator, speed_scale, guess):
    two_beta = 2.0 * oscillator.half_backlash
    for i in range(PHASES + 1):
        phase = (i % PHASES) / PHASES
        graze_speed, graze_duration, _ = grazing_flight(oscillator, phase, LEAVING)
        at = i * ROW
        guess[FALL_BACK * BLOCK + at] = 2.0 / rest_acceleration(oscillator, phase)
        guess[DROP * BLOCK + at] = graze_speed * graze_duration
        guess[RISE * BLOCK + at] = next_contact(oscillator, LOWER, phase, 0.0, 1.0).duration * speed_scale
        for j in range(1, ABSCISSAE + 1):
            abscissa = j / ABSCISSAE
            speed = graze_speed * abscissa
            guess[FALL_BACK * BLOCK + at + j] = next_contact(oscillator, UPPER, phase, -speed, 1.0).duration / speed
            if j == ABSCISSAE:
                break
            speed = graze_speed / (1.0 - abscissa * abscissa)
            guess[DROP * BLOCK + at + j] = next_contact(oscillator, UPPER, phase, -speed, 1.0).duration * speed
            speed = speed_scale * abscissa / (1.0 - abscissa)
            rise = next_contact(oscillator, LOWER, phase, speed, 1.0).duration
            guess[RISE * BLOCK + at + j] = rise * (speed + speed_scale)
        guess[DROP * BLOCK + at + ABSCISSAE] = two_beta
        guess[RISE * BLOCK + at + ABSCISSAE] = two_beta


def _grazing_series(oscillator: Oscillator) -> tuple[np.ndarray, np.ndarray, float, float]:
    phase = np.arange(_SAMPLES) / _SAMPLES
    speed = grazing_velocity(oscillator, phase)
    transform = np.fft.rfft(speed)[: HARMONICS + 1] / _SAMPLES
    cosine, sine = 2.0 * transform.real, -2.0 * transform.imag
    cosine[0] /= 2.0
    angles = 2.0 * np.pi * np.outer(phase, np.arange(HARMONICS + 1))
    residual = np.abs(np.cos(angles) @ cosine + np.sin(angles) @ sine - speed).max()
    # The residual is sampled 20 times a period of its leading harmonic; four times its maximum bounds it in between.
    return cosine, sine, float(4.0 * residual + 1e-14 * speed.max()), float(speed.max())


@lru_cache(maxsize=32)
def lane_tables(oscillator: Oscillator) -> LaneTables:
    """Tables of one oscillator, built in some 10 ms and kept for the last few oscillators.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.

    Returns
    -------
    LaneTables
    """
    cosine, sine, error, speed_scale = _grazing_series(oscillator)
    guess = np.empty(3 * BLOCK)
    _fill_guess(oscillator, speed_scale, guess)
    bound = capture_bound(oscillator, np.empty(12), np.empty(12))
    return LaneTables(guess, cosine, sine, error, speed_scale, bound)

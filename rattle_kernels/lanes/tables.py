"""What the lanes look up: first guesses for the durations of flights and contacts, and the grazing curve.

A lane takes one step of fifth order from the guess, so a coarse bilinear table is enough. There are three kinds of
flight and two of contact. Each is tabulated over a variable in which its duration is smooth up to the ends (the square
root removes the singularity at grazing):

    kind           value tabulated       abscissa in [0, 1]      ends
    FALL_BACK      tau / v               v / v*                  2/a  ...  duration at graze / v*
    DROP           tau v                 sqrt(1 - v*/v)          graze  ...  2 beta
    RISE           tau (u + u_ref)       u / (u + u_ref)         from rest  ...  2 beta
    CONTACT_ABOVE  tau                   u / (u + u_con)         half a swing at the upper end
    CONTACT_BELOW  tau (u + u_con)/u     u / (u + u_con)         from rest  ...  half a swing

Under several harmonics the abscissa of FALL_BACK is 3 v/(v* + 2 v), whose nodes crowd at speed 0 (`fall_divisor`).
Here u_ref is the largest v*, and u_con = 4 pi delta/sqrt(2 kappa). Only the piecewise linear model has contacts. One
above may last for several swings (`contact_swings`), or for ever, and its duration jumps. There the table holds NaN,
and ENDLESS where all of them last for ever.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.adiabatic_invariant import capture_bound
from rattle_kernels.impact_map.flights import LOWER, UPPER, leave_upper, next_contact
from rattle_kernels.lanes.harmonics import fall_speed
from rattle_kernels.model.contact import enter_contact
from rattle_kernels.model.contact_end import follow_contact
from rattle_kernels.model.contact_swings import ends_late_around, lasts_around
from rattle_kernels.model.flight import TWO_PI, acceleration_range, rest_acceleration
from rattle_kernels.model.grazing_curve import LEAVING, MESH, grazing_flight, grazing_speeds, largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_RETURNED
from rattle_kernels.numerics.jit import inlined, kernel
from rattle_kernels.numerics.phase import part_turn

FALL_BACK, DROP, RISE = 0, 1, 2
CONTACT_ABOVE, CONTACT_BELOW = 0, 1

# Intervals in phase and in the abscissa. Measured at the paper's parameters: with 192 x 96 one flight in 5,000 takes
# the careful path; with 192 x 48 it is one in 80, which doubles the time of a flight.
PHASES = 192
ABSCISSAE = 96
ROW = ABSCISSAE + 1
BLOCK = (PHASES + 1) * ROW

# Every fourth node each way is solved for. The others are interpolated, unless two orders of interpolation differ by
# this part: a tenth of the error of bilinear look-up. Solving for all of them took ten times as long.
_EVERY = 4
_DOUBT = 1e-5

# Intervals of the grazing curve's own table: every second node of the mesh shows how much it errs. It is interpolated
# linearly, and only flights within some 1e-5 of the curve are unsure.
GRAZES = MESH // 2

ENDLESS = 1e30
"""Duration of a contact that is permanent, as all those near it. Beside a finite one there is NaN, so what is
interpolated is this number or none of its size."""

# Distance of the abscissa from 1 at the upper end of contacts: speeds there are some 1e6 times u_con.
_FASTEST = 1e-6


class LaneTables(NamedTuple):
    """Everything that lanes need to know about one oscillator.

    Parameters
    ----------
    guess : ndarray of float64, shape (3 * BLOCK,)
        The tables of FALL_BACK, DROP and RISE, row by phase.
    graze_speed : ndarray of float64, shape (GRAZES + 1,)
        v*(t) on a mesh over the period, its end included.
    grazing_error : float
        Bound on the error of interpolating it. Closer to the curve a lane takes the careful path.
    largest_grazing_speed : float
        u_ref, the scale of speeds.
    contact : ndarray of float64, shape (2 * BLOCK,)
        The tables of CONTACT_ABOVE and CONTACT_BELOW, row by phase; NaN in the impacting model.
    contact_speed : float
        u_con: the speed with which contact at rest swings.
    capture_bound : float
        Bound on ``1.5 J`` of captured departures (`adiabatic_invariant.capture_bound`).
    """

    guess: np.ndarray
    graze_speed: np.ndarray
    grazing_error: float
    largest_grazing_speed: float
    contact: np.ndarray
    contact_speed: float
    capture_bound: float


class LooseTables(NamedTuple):
    """What lanes need to know about a loose oscillator: its flights have no tables.

    Parameters
    ----------
    largest_grazing_speed : float
        The scale of speeds.
    capture_bound : float
        0: no motion is captured for ever.
    upper_jumps_below, lower_jumps_below : float
        Speed of leaving a wall below which a motion that chatters to rest there departs next at its release.
    """

    largest_grazing_speed: float
    capture_bound: float
    upper_jumps_below: float = math.inf
    lower_jumps_below: float = math.inf


@inlined
def _grazes(oscillator, i):
    """The grazing flight from the phase of row i, and that from the same phase within half a turn of 0."""
    phase = (i % PHASES) / PHASES
    return grazing_flight(oscillator, phase, LEAVING), grazing_flight(oscillator, part_turn(phase), LEAVING)


@inlined
def _node(oscillator, largest_grazing_speed, grazes, kind, i, j):
    """The value tabulated at a node of row i."""
    phase, abscissa = (i % PHASES) / PHASES, j / ABSCISSAE
    graze_speed, graze_duration, _ = grazes[0]
    if kind == FALL_BACK:
        speed = fall_speed(oscillator.harmonics, graze_speed * abscissa, abscissa)
        if j == 0:
            return 2.0 / rest_acceleration(oscillator, phase)
        return leave_upper(oscillator, part_turn(phase), -speed, 1.0, grazes[1]).duration / speed
    if j == ABSCISSAE:
        return 2.0 * oscillator.half_backlash
    if kind == DROP:
        if j == 0:
            return graze_speed * graze_duration
        speed = graze_speed / (1.0 - abscissa * abscissa)
        return leave_upper(oscillator, part_turn(phase), -speed, 1.0, grazes[1]).duration * speed
    speed = largest_grazing_speed * abscissa / (1.0 - abscissa)
    return next_contact(oscillator, LOWER, phase, speed, 1.0).duration * (speed + largest_grazing_speed)


@inlined
def _interpolated(guess, first, stride, weights):
    """A node interpolated from six of its row or column, and from four of them."""
    six, four = 0.0, 0.0
    for at in range(6):
        value = guess[first[at] * stride[0] + stride[1]]
        six += weights[0, at] * value
        four += weights[1, at] * value
    return six, four


@kernel
def _fill_guess(oscillator, largest_grazing_speed, along_row, along_column, guess):
    """Solve for every fourth node of every fourth row; interpolate the others, or solve where two orders differ."""
    columns, row_weights = along_row
    rows, column_weights = along_column
    off = np.empty(ABSCISSAE + 1)
    for pass_ in range(2):
        for i in range(PHASES + 1):
            if (i % _EVERY == 0) != (pass_ == 0):
                continue
            grazes = _grazes(oscillator, i)
            for kind in range(3):
                at = kind * BLOCK + i * ROW
                row = guess[at : at + ROW]
                if pass_ == 0:
                    for j in range(0, ABSCISSAE + 1, _EVERY):
                        row[j] = _node(oscillator, largest_grazing_speed, grazes, kind, i, j)
                    for j in range(ABSCISSAE + 1):
                        if j % _EVERY != 0:
                            six, four = _interpolated(row, columns[j], (1, 0), row_weights[j])
                            row[j], off[j] = six, abs(six - four)
                        else:
                            off[j] = 0.0
                else:
                    first, weights = rows[i], column_weights[i]
                    for j in range(ABSCISSAE + 1):
                        six, four = _interpolated(guess, first, (ROW, kind * BLOCK + j), weights)
                        row[j], off[j] = six, abs(six - four)
                for j in range(ABSCISSAE + 1):
                    if off[j] > _DOUBT * abs(row[j]):
                        row[j] = _node(oscillator, largest_grazing_speed, grazes, kind, i, j)


def _stencils(intervals: int, *, wraps: bool) -> tuple[np.ndarray, np.ndarray]:
    """Six solved nodes for each node of a row or column, and Lagrange's weights of all six and of the nearest four."""
    nodes, weights = np.empty((intervals + 1, 6), np.int64), np.zeros((intervals + 1, 2, 6))
    coarse = intervals // _EVERY
    for i in range(intervals + 1):
        x = i / _EVERY
        first = math.floor(x) - 2
        first = first if wraps else min(max(first, 0), coarse - 5)
        inner = min(max(math.floor(x) - 1 - first, 0), 2)
        for which, chosen in enumerate((range(6), range(inner, inner + 4))):
            for at in chosen:
                others = [other for other in chosen if other != at]
                weights[i, which, at] = math.prod((x - first - other) / (at - other) for other in others)
        places = np.arange(first, first + 6) * _EVERY
        nodes[i] = places % intervals if wraps else places
    return nodes, weights


_ALONG_ROW = _stencils(ABSCISSAE, wraps=False)
_ALONG_COLUMN = _stencils(PHASES, wraps=True)


@inlined
def _speed_of(contact_speed, j):
    """Speed of a contact at an abscissa, counted in intervals."""
    abscissa = j / ABSCISSAE
    # The upper end stands for infinite speed: half a swing, whose correction falls as 1/speed.
    return contact_speed * abscissa / max(1.0 - abscissa, _FASTEST)


@inlined
def _duration_above(oscillator, contact_speed, phase, j):
    """Duration of a contact above; NaN where one nearby may end a swing or more before it, or may end or not."""
    speed = _speed_of(contact_speed, j)
    ended = follow_contact(oscillator, UPPER, phase, speed)
    # A contact of one swing lasts at most a turn of the ringing, nearly so if it grazes the wall from inside.
    if ended.duration < 0.95 * TWO_PI / math.sqrt(2.0 * oscillator.stiffness):
        return ended.duration
    contact = enter_contact(oscillator, UPPER, phase, 0.0, speed)
    least_press, _ = acceleration_range(oscillator)
    speed_step = _speed_of(contact_speed, j + 0.5) - speed
    if ended.outcome == OUTCOME_RETURNED:
        alike, duration = (
            ends_late_around(contact, ended.duration, least_press, 0.5 / PHASES, speed_step),
            ended.duration,
        )
    else:  # a contact that is permanent by the paper's rule alone, or was not followed to its end, may have one
        alike, duration = lasts_around(contact, least_press, 0.5 / PHASES, speed_step), ENDLESS
    return duration if alike else math.nan


@kernel
def _fill_contact(oscillator, contact_speed, contact):
    for i in range(PHASES + 1):
        phase = (i % PHASES) / PHASES
        at = i * ROW
        contact[CONTACT_BELOW * BLOCK + at] = 2.0 * contact_speed / rest_acceleration(oscillator, phase)
        from_rest = _duration_above(oscillator, contact_speed, phase, 0)
        contact[CONTACT_ABOVE * BLOCK + at] = from_rest if from_rest == ENDLESS else math.nan
        for j in range(1, ABSCISSAE + 1):
            contact[CONTACT_ABOVE * BLOCK + at + j] = _duration_above(oscillator, contact_speed, phase, j)
            below = follow_contact(oscillator, LOWER, phase, _speed_of(contact_speed, j))
            contact[CONTACT_BELOW * BLOCK + at + j] = below.duration / (j / ABSCISSAE)


def _without_jumps(table: np.ndarray, jump: float) -> np.ndarray:
    """The table with NaN on both sides of every jump between neighbouring nodes; its last row is its first."""
    between_rows = np.abs(np.diff(table, axis=0)) > jump
    along_row = np.abs(np.diff(table[:-1], axis=1)) > jump
    jumps = between_rows | np.roll(between_rows, 1, axis=0)
    jumps[:, 1:] |= along_row
    jumps[:, :-1] |= along_row
    return np.where(np.vstack([jumps, jumps[:1]]), np.nan, table)


def _contact_table(oscillator: Oscillator) -> tuple[np.ndarray, float]:
    contact = np.full(2 * BLOCK, np.nan)
    contact_speed = 4.0 * math.pi * oscillator.damping / math.sqrt(2.0 * oscillator.stiffness)
    if contact_speed > 0.0:
        _fill_contact(oscillator, contact_speed, contact)
        above = contact[CONTACT_ABOVE * BLOCK :][:BLOCK].reshape(-1, ROW)
        # A jump is by a swing: half a turn of the ringing is less, and more than neighbours differ by.
        above[:] = _without_jumps(above, math.pi / math.sqrt(2.0 * oscillator.stiffness))
    return contact, contact_speed


def _graze_table(oscillator: Oscillator) -> tuple[np.ndarray, float, float]:
    speed = grazing_speeds(oscillator)
    # Linear interpolation errs most about the middle of an interval; twice the largest error seen there bounds it.
    residual = np.abs(0.5 * (speed[:-2:2] + speed[2::2]) - speed[1::2]).max()
    return speed[::2].copy(), float(2.0 * residual + 1e-14 * speed.max()), float(speed.max())


@lru_cache(maxsize=32)
def lane_tables(oscillator: Oscillator) -> LaneTables | LooseTables:
    """Tables of one oscillator, built in some 10 ms and kept for the last 32 oscillators.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.

    Returns
    -------
    LaneTables or LooseTables
    """
    if oscillator.is_loose:
        return LooseTables(largest_grazing_speed(oscillator), capture_bound(oscillator))
    graze_speed, error, largest = _graze_table(oscillator)
    guess = np.empty(3 * BLOCK)
    _fill_guess(oscillator, largest, _ALONG_ROW, _ALONG_COLUMN, guess)
    return LaneTables(guess, graze_speed, error, largest, *_contact_table(oscillator), capture_bound(oscillator))

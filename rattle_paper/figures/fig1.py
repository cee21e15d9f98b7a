"""Fig. 1: stable rattling solutions at the machine's own parameters, and the quiet solution that coexists with them.

Damping is so small there that a departure rattles for thousands of rotations before it settles, and many solutions
coexist. They are found by following random departures for a long time. Rare solutions may be missed.
"""

import math
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from rattle.pictures import draw_history_panel
from rattle_kernels import (
    UNASSIGNED,
    Attractor,
    AttractorKind,
    Direction,
    Oscillator,
    Outcome,
    TimeHistory,
    find_attractors,
    name_solutions,
    next_impacts,
    time_history,
)
from rattle_paper.figure import PaperFigure, Report, Results, Sheet
from rattle_paper.numbers.solutions import motion_summary, oscillator_summary

MACHINE = Oscillator(damping=6e-4, eccentricity=1e-4, half_backlash=6e-4, stiffness=1000.0)

_DEPARTURES = 1000
# The fastest departures cross from +beta to -beta ten times as fast as under the driving torque alone.
_FASTEST = 12.0 * MACHINE.damping
_SEED = 1
_LEGS = 6
_LEG_IMPACTS = 10_000
# Seeds of the catalogue per batch. Progress is reported with every batch.
_BATCH = 100
_PERIODS = 4.0
_COLUMNS, _PANELS = 3, 12


def rattling_solutions(departures: int, report: Report) -> tuple[tuple[Attractor, ...], np.ndarray]:
    """Solutions that random departures end in, and the number of departures that end in each.

    Parameters
    ----------
    departures : int
        Their number. They are uniform in phase and in speed up to 12 delta.
    report : callable
        Called with progress.

    Returns
    -------
    tuple of Attractor
        Permanent contact first.
    ndarray of int
        Departures that end in each solution. The last entry counts those that have not settled yet.
    """
    chance = np.random.default_rng(_SEED)
    t, v = chance.random(departures), chance.uniform(0.0, _FASTEST, departures)
    for leg in range(_LEGS):
        report("following departures", leg, _LEGS)
        landed = next_impacts(MACHINE, t, v, _LEG_IMPACTS, shortcuts=True)
        going = landed.outcome == Outcome.RETURNED
        t, v = landed.t[going], landed.v[going]
    found = find_attractors(MACHINE, t[:0], v[:0])
    for begin in range(0, t.size, _BATCH):
        report("finding solutions", begin, t.size)
        batch = slice(begin, begin + _BATCH)
        found = find_attractors(MACHINE, t[batch], v[batch], known=found)
    ends = name_solutions(MACHINE, found, t, v)
    counts = np.bincount(np.where(ends == UNASSIGNED, len(found), ends), minlength=len(found) + 1)
    counts[0] += departures - t.size
    return found, counts


def quiet_state(oscillator: Oscillator) -> tuple[float, float]:
    """Phi and Phi' of the quiet solution at t = 0, Eq. (33) without ringing."""
    damping, eccentricity, half_backlash, stiffness, *_ = oscillator
    turn = 2.0 * math.pi
    response = eccentricity * complex(-(turn**2), turn * damping) / complex(2 * stiffness - turn**2, turn * damping)
    return half_backlash + turn * damping / stiffness + response.real, -turn * response.imag


def _contact_times(history: TimeHistory) -> np.ndarray:
    """Durations of the contacts that begin and end within a history."""
    contacts = history.contacts
    begins = np.flatnonzero(contacts.direction[:-1] == Direction.IN)
    return contacts.time[begins + 1] - contacts.time[begins]


def _follow(orbit: Attractor, periods: float) -> TimeHistory:
    return time_history(
        MACHINE, float(orbit.time[0]), MACHINE.half_backlash, -float(orbit.velocity[0]), periods=periods
    )


def _summary(orbit: Attractor, departures: int) -> dict[str, Any]:
    stays = _contact_times(_follow(orbit, float(orbit.forcing_periods) + 0.5))
    longest = {"longest_contact": float(stays.max())} if stays.size else {}
    return motion_summary(orbit) | {"departures": departures} | longest


def _quiet_history(periods: float) -> TimeHistory:
    displacement, velocity = quiet_state(MACHINE)
    return time_history(MACHINE, 0.0, displacement, velocity, periods=periods)


def _draw(orbits: list[Attractor]) -> Figure:
    drawing = Figure(figsize=(12.0, 9.0), dpi=90, layout="constrained")
    panels = drawing.subplots(_PANELS // _COLUMNS, _COLUMNS).ravel()
    for axes, orbit in zip(panels, orbits, strict=False):
        draw_history_panel(axes, MACHINE, _follow(orbit, _PERIODS), orbit.name)
    for axes in panels[len(orbits) : -1]:
        axes.set_axis_off()
    draw_history_panel(panels[-1], MACHINE, _quiet_history(_PERIODS), "quiet: permanent contact")
    for axes in panels[-_COLUMNS:]:
        axes.set_xlabel("time (forcing periods)")
    return drawing


def _make(results: Results, report: Report) -> Sheet:
    found, counts = rattling_solutions(_DEPARTURES, report)
    periodic = [index for index, motion in enumerate(found) if motion.kind == AttractorKind.PERIODIC]
    periodic.sort(key=lambda index: found[index].upper_contacts + found[index].lower_contacts)
    numbers = {
        "oscillator": oscillator_summary(MACHINE),
        "departures": _DEPARTURES,
        "quiet": {"departures": int(counts[0]), "least_displacement": float(_quiet_history(1.0).displacement.min())},
        "rattling": [_summary(found[index], int(counts[index])) for index in periodic],
        "not_settled": int(counts[-1]),
        "half_swing_of_contact": math.pi / math.sqrt(2.0 * MACHINE.stiffness - 0.25 * MACHINE.damping**2),
    }
    return Sheet(_draw([found[index] for index in periodic[: _PANELS - 1]]), numbers)


FIG1 = PaperFigure("fig1", "stable rattling solutions at the machine's parameters, and the quiet one", _make)

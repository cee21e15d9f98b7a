"""Fig. 4: three motions that enter linear contact: one leaves it again, one after several swings, and one never.

The paper sketches them. Here they are motions of one oscillator that enter contact at the same phase. They are found
by a scan of entry phases and speeds.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle_kernels import Direction, Oscillator, TimeHistory, time_history
from rattle_paper.figure import PaperFigure, Report, Results, Sheet
from rattle_paper.numbers.solutions import oscillator_summary

# Contact is soft enough that single swings are visible.
_OSCILLATOR = Oscillator(damping=0.6, eccentricity=0.1, half_backlash=0.6, stiffness=500.0)
_PHASES = 20
_SPEEDS = 40
# In units of the speed of a swing at rest, 4 pi delta/sqrt(2 kappa). Faster motions leave after half a swing.
_FASTEST = 2.0
_PERIODS = 2.0
_SAMPLES = 500


class _Entry(NamedTuple):
    """A motion that enters contact, and what becomes of it.

    ``stay`` is the time until it first leaves contact, infinite if it never does. ``maxima`` and ``minima`` count the
    turning points before that. ``departures`` counts how often it leaves within a rotation.
    """

    phase: float
    speed: float
    history: TimeHistory
    stay: float
    maxima: int
    minima: int
    departures: int


def _enter(phase: float, speed: float) -> _Entry:
    history = time_history(
        _OSCILLATOR, phase, _OSCILLATOR.half_backlash, speed, periods=_PERIODS, samples_per_period=_SAMPLES
    )
    contacts = history.contacts
    leaves = contacts.time[(contacts.wall > 0) & (contacts.direction == Direction.OUT)] - phase
    stay = float(leaves[0]) if leaves.size else math.inf
    rate = history.velocity[history.time - phase <= stay]
    maxima = int(((rate[:-1] > 0.0) & (rate[1:] <= 0.0)).sum())
    minima = int(((rate[:-1] < 0.0) & (rate[1:] >= 0.0)).sum())
    return _Entry(phase, speed, history, stay, maxima, minima, int((leaves <= 1.0).sum()))


def examples(report: Report) -> dict[str, _Entry]:
    """Motions (a), (b), (c) that enter contact at the same phase.

    (b) has the most maxima of all motions that leave within a rotation. At its phase, (a) leaves most often within a
    rotation, and (c) is the fastest motion that never leaves.
    """
    swing = 4.0 * math.pi * _OSCILLATOR.damping / math.sqrt(2.0 * _OSCILLATOR.stiffness)
    speeds = swing * _FASTEST * np.arange(1, _SPEEDS + 1) / _SPEEDS
    by_phase = []
    for i in range(_PHASES):
        report("entering contact", i, _PHASES)
        by_phase.append([_enter(i / _PHASES, float(speed)) for speed in speeds])

    def most_maxima(entries: list[_Entry]) -> tuple[int, float]:
        return max((entry.maxima, -entry.stay) for entry in entries if entry.stay <= 1.0)

    with_all = [entries for entries in by_phase if any(math.isinf(entry.stay) for entry in entries)]
    entries = max(with_all, key=most_maxima)
    return {
        "a": max(entries, key=lambda entry: entry.departures),
        "b": max((entry for entry in entries if entry.stay <= 1.0), key=lambda entry: (entry.maxima, -entry.stay)),
        "c": max((entry for entry in entries if math.isinf(entry.stay)), key=lambda entry: entry.speed),
    }


def _draw_panel(axes: Axes, label: str, entry: _Entry) -> None:
    history, beta = entry.history, _OSCILLATOR.half_backlash
    axes.axhline(0.0, color="black", linestyle=":", linewidth=1.0)
    axes.plot(history.time - entry.phase, history.displacement - beta, color="tab:blue", linewidth=1.2)
    axes.plot(0.0, 0.0, "o", color="tab:red", markersize=4)
    axes.set_title(f"({label})", y=-0.22)
    axes.set_xlabel("time since entering (forcing periods)")
    axes.set_xlim(-0.05, _PERIODS)


def _summary(entry: _Entry) -> dict[str, Any]:
    return {
        "enters_at": [entry.phase, entry.speed],
        "stay": entry.stay if math.isfinite(entry.stay) else "permanent",
        "maxima": entry.maxima,
        "minima": entry.minima,
        "departures_within_one_rotation": entry.departures,
    }


def _make(results: Results, report: Report) -> Sheet:
    found = examples(report)
    drawing = Figure(figsize=(12.0, 4.2), dpi=90, layout="constrained")
    for axes, (label, entry) in zip(drawing.subplots(1, 3, sharey=True), found.items(), strict=True):
        _draw_panel(axes, label, entry)
    drawing.axes[0].set_ylabel("Φ − β")
    numbers = {"oscillator": oscillator_summary(_OSCILLATOR), "panels": {key: _summary(found[key]) for key in found}}
    return Sheet(drawing, numbers)


FIG4 = PaperFigure("fig4", "three motions that enter linear contact", _make)

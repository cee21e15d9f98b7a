"""Figs. 2 and 3: the three types of flight from +beta to +beta (Sec. 2), and the grazing curve that separates them.

(a) goes straight back to +beta, (b) goes by way of -beta, (c) touches -beta.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.optimize import minimize_scalar

from rattle.pictures import draw_boundaries
from rattle_kernels import Oscillator, TimeHistory, grazing_velocity, time_history
from rattle_paper.figure import PaperFigure, Report, Results, Sheet
from rattle_paper.numbers.solutions import oscillator_summary
from rattle_paper.papers_oscillator import papers_oscillator

# Speeds in units of the grazing speed.
_SPEEDS = {"a": 0.85, "b": 1.15, "c": 1.0}
_SAMPLES = 2000
_LONGEST = 3.0
# Half-backlash so large that no flight reaches a wall.
_NO_WALL = 100.0


class Flights(NamedTuple):
    """A flight from +beta at ``t`` with speed ``v`` until it returns, and the same flight without a lower wall."""

    t: float
    v: float
    real: TimeHistory
    without_wall: TimeHistory


def three_flights(oscillator: Oscillator, t: float) -> dict[str, Flights]:
    """Flights (a), (b) and (c), which leave +beta at the same phase."""
    grazing = float(grazing_velocity(oscillator, t))
    return {label: _fly(oscillator, t, speed * grazing) for label, speed in _SPEEDS.items()}


def _fly(oscillator: Oscillator, t: float, v: float) -> Flights:
    beta = oscillator.half_backlash
    real = time_history(oscillator, t, beta, -v, periods=_LONGEST, departures=1, samples_per_period=_SAMPLES)
    wide = time_history(
        oscillator._replace(half_backlash=_NO_WALL), t, beta, -v, periods=_LONGEST, samples_per_period=_SAMPLES
    )
    back = int((wide.displacement[1:] >= beta).argmax()) + 2
    shown = wide._replace(**{name: getattr(wide, name)[:back] for name in ("time", "displacement", "velocity")})
    return Flights(t, v, real, shown)


def flight_summary(flight: Flights) -> dict[str, Any]:
    """Departure of a flight, its lowest displacement, and where and how fast it meets the walls."""
    contacts = flight.real.contacts
    events = zip(contacts.wall.tolist(), contacts.time.tolist(), contacts.speed.tolist(), strict=True)
    return {
        "leaves_at": [flight.t, flight.v],
        "lowest_displacement": float(flight.real.displacement.min()),
        "meets": [{"wall": "+beta" if wall > 0 else "-beta", "time": t, "speed": speed} for wall, t, speed in events],
    }


_PHASE = 0.6
_CAPTIONS = {"a": "next impact with +β", "b": "next impact with −β", "c": "grazes −β"}
_MARGIN = 0.12


def _draw_flight(axes: Axes, label: str, flight: Flights) -> None:
    draw_boundaries(axes, papers_oscillator())
    axes.plot(flight.real.time - flight.t, flight.real.displacement, color="tab:blue")
    star = "*" if label == "c" else ""
    beta = papers_oscillator().half_backlash
    axes.annotate(f"t₀, v₀{star}", (0.0, beta), (4, 6), textcoords="offset points")
    contacts = flight.real.contacts
    for t, wall in zip(contacts.time - flight.t, contacts.wall, strict=True):
        name = "t₁, v₁" if wall > 0 else "t\u0302, v\u0302"
        axes.annotate(name, (t, wall * beta), (-4, 6 if wall > 0 else -12), textcoords="offset points", ha="right")
        axes.plot(t, wall * beta, "o", color="tab:red", markersize=4)
    axes.plot(0.0, beta, "o", color="tab:red", markersize=4)
    axes.set_ylim(-beta - 3 * _MARGIN, beta + 3 * _MARGIN)
    axes.set_title(f"({label}) {_CAPTIONS[label]}", y=-0.28)
    axes.set_xlabel("time since the departure (forcing periods)")


def _make_fig2(results: Results, report: Report) -> Sheet:
    flights = three_flights(papers_oscillator(), _PHASE)
    drawing = Figure(figsize=(12.0, 4.2), dpi=90, layout="constrained")
    for axes, (label, flight) in zip(drawing.subplots(1, 3, sharey=True), flights.items(), strict=True):
        _draw_flight(axes, label, flight)
    drawing.axes[0].set_ylabel("Φ(t)")
    panels = {label: flight_summary(flight) for label, flight in flights.items()}
    return Sheet(drawing, {"oscillator": oscillator_summary(papers_oscillator()), "panels": panels})


FIG2 = PaperFigure("fig2", "the three types of flight: back to +beta, by way of -beta, and grazing", _make_fig2)


_SUMMARY_PHASES = 10
_CURVE_POINTS = 4001
_HIGHEST = 7.0
_LAST_STEP, _MOST_STEPS = 1e-14, 20


def _draw_flights(axes: Axes, flights: dict[str, Flights]) -> None:
    draw_boundaries(axes, papers_oscillator())
    for (label, flight), colour in zip(flights.items(), ("tab:blue", "tab:red", "black"), strict=True):
        axes.plot(flight.real.time, flight.real.displacement, color=colour, label=f"({label})")
        if label == "b":
            axes.plot(flight.without_wall.time, flight.without_wall.displacement, "--", color=colour)
    axes.set(xlabel="time t (forcing periods)", ylabel="Φ(t)")
    axes.legend(loc="lower left")


def _draw_regions(axes: Axes) -> None:
    t = np.linspace(0.0, 1.0, _CURVE_POINTS)
    curve = grazing_velocity(papers_oscillator(), t)
    axes.plot(t, curve, color="black", label="(c)  v*(t)")
    axes.fill_between(t, 0.0, curve, color="tab:blue", alpha=0.2, linewidth=0.0, label="(a)  next impact with +β")
    axes.fill_between(t, curve, _HIGHEST, color="tab:red", alpha=0.2, linewidth=0.0, label="(b)  next impact with −β")
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, _HIGHEST), ylabel="velocity v of departure")
    axes.set_xlabel("time t of departure (forcing periods)")
    axes.legend(loc="lower left")


def _graze_summary(oscillator: Oscillator, t0: float) -> dict[str, float]:
    """A point of the grazing curve by the paper's method, Newton's on Eq. (13), compared with the kernels' v*."""
    delta, epsilon, beta = oscillator.damping, oscillator.eccentricity, oscillator.half_backlash
    turn, t_hat, step, steps = 2.0 * math.pi, t0 + 0.5, math.inf, 0
    while abs(step) > _LAST_STEP and steps < _MOST_STEPS:
        grown = math.expm1(delta * (t_hat - t0))
        push = 2.0 * turn - turn * epsilon * math.sin(turn * t_hat)
        ripple = epsilon * (math.cos(turn * t0) - math.cos(turn * t_hat))
        residual = push * grown / delta + ripple + 2.0 * turn * (t0 - t_hat) - 2.0 * beta
        step = residual / (grown * (push - turn * turn * epsilon * math.cos(turn * t_hat) / delta))
        t_hat, steps = t_hat - step, steps + 1
    push = 2.0 * turn - turn * epsilon * math.sin(turn * t_hat)
    by_newton = push * math.exp(delta * (t_hat - t0)) + turn * epsilon * math.sin(turn * t0) - 2.0 * turn
    speed = float(grazing_velocity(oscillator, t0))
    return {"t": t0, "v": speed, "t_hat": t_hat, "newton_steps": steps, "newton_differs": by_newton - speed}


def _extreme(oscillator: Oscillator, way: float) -> list[float]:
    """Phase and speed where v* is highest (way 1) or lowest (way -1). Beside the mesh's best point it has no other."""
    t = np.linspace(0.0, 1.0, _CURVE_POINTS)
    best, mesh = t[(way * grazing_velocity(oscillator, t)).argmax()], t[1]
    found = minimize_scalar(
        lambda phase: -way * float(grazing_velocity(oscillator, phase)), bounds=(best - mesh, best + mesh),
        method="bounded", options={"xatol": 1e-9},
    )  # fmt: skip
    # Where a curve is level, its phase is known to half as many digits as its height.
    return [round(float(found.x), 6), -way * float(found.fun)]


def _curve_summary(oscillator: Oscillator) -> dict[str, Any]:
    return {
        "highest": _extreme(oscillator, 1.0),
        "lowest": _extreme(oscillator, -1.0),
        "points": [_graze_summary(oscillator, i / _SUMMARY_PHASES) for i in range(_SUMMARY_PHASES)],
    }


def _make_fig3(results: Results, report: Report) -> Sheet:
    oscillator = papers_oscillator()
    flights = three_flights(oscillator, _PHASE)
    drawing = Figure(figsize=(12.0, 4.8), dpi=90, layout="constrained")
    left, right = drawing.subplots(1, 2)
    _draw_flights(left, flights)
    _draw_regions(right)
    for axes, label in ((left, "a"), (right, "b")):
        axes.set_title(f"({label})", loc="left")
    summaries = {label: flight_summary(flight) for label, flight in flights.items()}
    numbers = {"flights": summaries, "grazing_curve": _curve_summary(oscillator)}
    return Sheet(drawing, {"oscillator": oscillator_summary(oscillator)} | numbers)


FIG3 = PaperFigure("fig3", "flights of types (a), (b), (c) that leave together, and the grazing curve", _make_fig3)

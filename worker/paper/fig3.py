"""Fig. 3: flights of the three types that leave +beta together, and the grazing curve that divides their departures."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle_kernels import Oscillator, grazing_velocity
from worker.paper.figure import PaperFigure, Sheet, Tell
from worker.paper.papers_oscillator import papers_oscillator
from worker.paper.solutions_told import told_oscillator
from worker.paper.three_flights import Flights, three_flights, told_flight
from worker.pictures.history_picture import draw_boundaries

_PHASE = 0.6
_TOLD_PHASES = 10
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


def _told_graze(oscillator: Oscillator, t0: float) -> dict[str, float]:
    """A point of the grazing curve by the paper's own way, Newton's method on Eq. (13), beside the kernels' v*."""
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


def _told_curve(oscillator: Oscillator) -> dict[str, Any]:
    t = np.linspace(0.0, 1.0, _CURVE_POINTS)
    curve = grazing_velocity(oscillator, t)
    return {
        "highest": [float(t[curve.argmax()]), float(curve.max())],
        "lowest": [float(t[curve.argmin()]), float(curve.min())],
        "points": [_told_graze(oscillator, i / _TOLD_PHASES) for i in range(_TOLD_PHASES)],
    }


def _make(stores: Mapping[str, str], tell: Tell) -> Sheet:
    oscillator = papers_oscillator()
    flights = three_flights(oscillator, _PHASE)
    drawing = Figure(figsize=(12.0, 4.8), dpi=90, layout="constrained")
    left, right = drawing.subplots(1, 2)
    _draw_flights(left, flights)
    _draw_regions(right)
    for axes, label in ((left, "a"), (right, "b")):
        axes.set_title(f"({label})", loc="left")
    told = {label: told_flight(flight) for label, flight in flights.items()}
    numbers = {"oscillator": told_oscillator(oscillator), "flights": told, "grazing_curve": _told_curve(oscillator)}
    return Sheet(drawing, numbers)


FIG3 = PaperFigure("fig3", "flights of types (a), (b), (c) that leave together, and the grazing curve", _make)

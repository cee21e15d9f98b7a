"""Fig. 2: the three ways from +beta to +beta, which the paper sketches, as motions of one oscillator."""

from collections.abc import Mapping

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from worker.paper.figure import PaperFigure, Sheet, Tell
from worker.paper.papers_oscillator import papers_oscillator
from worker.paper.solutions_told import told_oscillator
from worker.paper.three_flights import Flights, three_flights, told_flight
from worker.pictures.history_picture import draw_boundaries

_PHASE = 0.6
_NAMES = {"a": "next impact with +β", "b": "next impact with −β", "c": "grazes −β"}
_MARGIN = 0.12


def _draw_panel(axes: Axes, label: str, flight: Flights) -> None:
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
    axes.set_title(f"({label}) {_NAMES[label]}", y=-0.28)
    axes.set_xlabel("time since the departure (forcing periods)")


def _make(stores: Mapping[str, str], tell: Tell) -> Sheet:
    flights = three_flights(papers_oscillator(), _PHASE)
    drawing = Figure(figsize=(12.0, 4.2), dpi=90, layout="constrained")
    for axes, (label, flight) in zip(drawing.subplots(1, 3, sharey=True), flights.items(), strict=True):
        _draw_panel(axes, label, flight)
    drawing.axes[0].set_ylabel("Φ(t)")
    panels = {label: told_flight(flight) for label, flight in flights.items()}
    return Sheet(drawing, {"oscillator": told_oscillator(papers_oscillator()), "panels": panels})


FIG2 = PaperFigure("fig2", "the three types of flight: back to +beta, by way of -beta, and grazing", _make)

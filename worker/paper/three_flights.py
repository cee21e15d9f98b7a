"""The three ways from +beta to +beta (Sec. 2): (a) straight back, (b) by way of -beta, (c) touching it."""

from typing import Any, NamedTuple

from rattle_kernels import Oscillator, TimeHistory, grazing_velocity, time_history

# Speeds of (a) and (b) in those of the graze.
_SPEEDS = {"a": 0.85, "b": 1.15, "c": 1.0}
_SAMPLES = 2000
_LONGEST = 3.0
# Walls so far away that a flight does not meet them.
_NO_WALL = 100.0


class Flights(NamedTuple):
    """A flight from +beta at ``t`` with speed ``v`` until it is back, and the same without any wall below."""

    t: float
    v: float
    real: TimeHistory
    without_wall: TimeHistory


def three_flights(oscillator: Oscillator, t: float) -> dict[str, Flights]:
    """Flights (a), (b) and (c) that leave +beta at one phase."""
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


def told_flight(flight: Flights) -> dict[str, Any]:
    """Where a flight begins, where it meets the walls, and with which speeds."""
    contacts = flight.real.contacts
    events = zip(contacts.wall.tolist(), contacts.time.tolist(), contacts.speed.tolist(), strict=True)
    return {
        "leaves_at": [flight.t, flight.v],
        "lowest_displacement": float(flight.real.displacement.min()),
        "meets": [{"wall": "+beta" if wall > 0 else "-beta", "time": t, "speed": speed} for wall, t, speed in events],
    }

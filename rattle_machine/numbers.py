"""Numbers of a machine by their names: as they are, in which unit, and the machine with another one."""

import math
from typing import Any

from worker.errors import InvalidJob
from worker.gear_pair import GearPair

UNITS = {
    "speed": "rad/s", "inertia": "kg m^2", "drag_torque": "N m", "base_radius": "m", "backlash": "m",
    "mesh_stiffness": "N/m", "inertia_ratio": "", "contact_damping": "", "restitution": "",
}  # fmt: skip
"""Units in SI; empty of a pure number. Beside these there are ``transmission_error.ORDER.amplitude`` and ``.phase``."""
RPM = 60.0 / (2.0 * math.pi)
"""1 rad/s in rpm."""
OF_ORDERS = {"amplitude": "m", "phase": "periods"}
_ERROR = "transmission_error"


def unit_of(name: str) -> str:
    """Unit of a number in SI, empty of a pure number."""
    return UNITS.get(name) or OF_ORDERS.get(name.rpartition(".")[2], "")


def with_number(pair: GearPair, name: str, value: Any) -> GearPair:
    """The machine with another value of a number.

    Parameters
    ----------
    pair : GearPair
    name : str
        ``speed``, with which the drag torque follows the drag law; another of `UNITS`; or a part of an order of the
        transmission error, as in ``transmission_error.2.amplitude``.
    value : float or str
        In SI units, or with its unit.

    Returns
    -------
    GearPair

    Raises
    ------
    InvalidJob
        If there is no such number, or it cannot have the value.
    """
    if name == "speed":
        return pair.at_speed(value)
    fields = pair.model_dump()
    if name in UNITS:
        fields[name] = value
    else:
        order, part = _order_of(pair, name)
        fields[_ERROR][order][part] = value
    return GearPair(**fields)


def number_of(pair: GearPair, name: str) -> float | None:
    """A number of a machine, in SI units; None if it has none.

    Raises
    ------
    InvalidJob
        If no machine has such a number.
    """
    if name in UNITS:
        value: float | None = getattr(pair, name)
        return value
    order, part = _order_of(pair, name)
    return float(getattr(pair.transmission_error[order], part))


def _order_of(pair: GearPair, name: str) -> tuple[int, str]:
    first, _, rest = name.partition(".")
    order, _, part = rest.partition(".")
    if first != _ERROR:
        names = ", ".join((*UNITS, f"{_ERROR}.1.amplitude"))
        raise InvalidJob(f"there is no number {name!r} of a machine: there are {names}", ("parameter",))
    if not order.isdecimal() or int(order) not in pair.transmission_error or part not in OF_ORDERS:
        there = ", ".join(f"{_ERROR}.{each}.{what}" for each in sorted(pair.transmission_error) for what in OF_ORDERS)
        raise InvalidJob(f"there is no number {name!r} of the machine: there are {there}", ("parameter",))
    return int(order), part

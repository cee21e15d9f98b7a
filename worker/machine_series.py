"""Machines of a sweep, one after the other: a machine at several values of one of its numbers, or a list of machines.

All numbers of the model move with the speed of a machine, and two of them with its base radius. So such a sweep is no
grid of parameters, but a curve among them: the design of `worker.jobs.design`.

A request keeps the machine that its oscillator comes from, so its result has units wherever it is opened: `machine_of`.
"""

import json
import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np
from pydantic import TypeAdapter

from rattle_kernels import Harmonic, Oscillator
from worker.errors import InvalidFields, InvalidJob
from worker.gear_pair import MACHINE, GearPair, beside_in_si, factors_of, in_si, number_and_unit, with_columns_in_si
from worker.jobs.oscillator_request import OscillatorRequest
from worker.jobs.swept_parameter import Spacing, spaced

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from worker.jobs.job import Job

_Job = TypeVar("_Job", bound="Job")

UNITS: dict[str, str | None] = {
    "speed": "rad/s",
    "inertia": "kg m^2",
    "inertia_ratio": None,
    "drag_torque": "N m",
    "base_radius": "m",
    "backlash": "m",
    "mesh_stiffness": "N/m",
}
"""Numbers of a machine that a sweep steps through, and their units in SI."""
MACHINES = "machines"
"""Attribute of a result that says of which machines it is, one for each basin, as JSON."""
_LISTED = "machine"
_OSCILLATOR: TypeAdapter[Any] = TypeAdapter(OscillatorRequest)
# Where all machines are the same.
_ONE_AT_LEAST = "damping"


class _Steps(NamedTuple):
    """Values of a number, in the unit in which they were written."""

    units: str | None
    values: tuple[float, ...]

    def in_si(self, unit: str | None) -> list[float]:
        if unit is None or self.units == unit:
            return list(self.values)
        return [float(in_si(f"{value!r} {self.units}", unit)) for value in self.values]


class MachineSeries:
    """Machines along a coordinate.

    Parameters
    ----------
    name : str
        Of the coordinate: the number that differs, or ``machine``.
    units : str, optional
        Of its values.
    values : sequence of float
        One for each machine.
    machines : sequence of GearPair, or of Oscillator

    Examples
    --------
    >>> from rattle import GearPair
    >>> pair = GearPair(speed=300.0, inertia=0.02, drag_torque=0.4, base_radius=0.06, backlash=60e-6,
    ...                 transmission_error=5e-6)
    >>> series = MachineSeries.over(pair, "speed", [200.0, 300.0])
    >>> [round(machine.gamma, 3) for machine in series.machines]
    [0.084, 0.188]
    """

    def __init__(
        self,
        name: str,
        units: str | None,
        values: Sequence[float],
        machines: "Sequence[GearPair] | Sequence[Oscillator]",
    ) -> None:
        self.name, self.units, self.values = name, units, tuple(values)
        self.machines: tuple[GearPair | Oscillator, ...] = tuple(machines)

    @classmethod
    def over(cls, pair: GearPair, name: str, given: Any) -> "MachineSeries":
        """A machine at several values of one of its numbers; with the speed its drag torque follows the drag law.

        Parameters
        ----------
        pair : GearPair
        name : str
            One of `UNITS`.
        given : sequence
            A list or an array of numbers in SI or texts with units; or (start, stop, count[, spacing]).

        Returns
        -------
        MachineSeries

        Raises
        ------
        InvalidJob
            If they are no such values.
        """
        unit = UNITS[name]
        steps = _read_steps(name, unit, given)
        series = cls(name, steps.units, steps.values, [])
        machines = []
        for index, value in enumerate(steps.in_si(unit)):
            try:
                numbers = pair.model_dump() | {name: value}
                machines.append(pair.at_speed(value) if name == "speed" else GearPair(**numbers))
            except InvalidFields as error:
                raise InvalidJob(f"{series.which(index)}{error.faults[0][1]}", (name,)) from None
        return cls(name, steps.units, steps.values, machines)

    @classmethod
    def listed(cls, given: Any) -> "MachineSeries":
        """A list of machines, numbered from 0 on.

        Parameters
        ----------
        given : sequence of GearPair, or of Oscillator

        Returns
        -------
        MachineSeries

        Raises
        ------
        InvalidJob
            If there is none, or they are of several kinds.
        """
        machines = list(given) if isinstance(given, list | tuple) and not isinstance(given, Oscillator) else []
        alike = {type(machine) for machine in machines}
        if alike not in ({GearPair}, {Oscillator}):
            raise InvalidJob("machines are a list of rattle.GearPair, or one of rattle.Oscillator", ("machines",))
        return cls(_LISTED, None, [float(index) for index in range(len(machines))], machines)

    @classmethod
    def of_result(cls, machines: str, design: Mapping[str, Any]) -> "MachineSeries":
        """The machines of a result: its attribute `MACHINES`, and the design of its request."""
        pairs = [GearPair(**each) for each in json.loads(machines)]
        return cls(design["name"], design.get("units"), design["values"], pairs)

    @classmethod
    def of_request(cls, machine: Mapping[str, Any], design: Mapping[str, Any]) -> "MachineSeries":
        """The machines of a request: its field `machine`, as `as_request` has it, and its design.

        Raises
        ------
        InvalidJob
            If they are none.
        """
        count = len(design["values"])
        for name, column in machine.items():
            if isinstance(column, list) and len(column) != count:
                raise InvalidJob(f"{name} has {len(column)} values for {count} machines: give one for each", (name,))
        rows = [
            {name: column[index] if isinstance(column, list) else column for name, column in machine.items()}
            for index in range(count)
        ]
        pairs = [GearPair(**{name: value for name, value in row.items() if value is not None}) for row in rows]
        return cls(design["name"], design.get("units"), design["values"], pairs)

    @property
    def as_request(self) -> dict[str, Any] | None:
        """The machines as a request has them: numbers that differ as lists. None if they are the model's alone."""
        if not self.pairs:
            return None
        rows = [pair.as_request for pair in self.pairs]
        columns = {name: [row.get(name) for row in rows] for row in rows for name in row}
        return {
            name: column[0] if column.count(column[0]) == len(column) else column for name, column in columns.items()
        }

    @property
    def pairs(self) -> tuple[GearPair, ...]:
        """The machines that are in units of their own: all, or none."""
        return tuple(machine for machine in self.machines if isinstance(machine, GearPair))

    def index_of(self, value: float) -> int:
        """Which machine has a value of the coordinate."""
        return int(np.argmin(np.abs(np.array(self.values) - value)))

    def which(self, index: int) -> str:
        """Which machine it is, as a message begins."""
        value = f"{self.values[index]:.6g} {self.units or ''}".rstrip()
        return f"machine {index}: " if self.name == _LISTED else f"machine {index}, {self.name} = {value}: "

    @cached_property
    def oscillators(self) -> tuple[Oscillator, ...]:
        """The machines in the model, with the same orders of the forcing.

        Raises
        ------
        InvalidJob
            If they are of both models, or differ in a rule that is no number.
        """
        own: list[Oscillator] = [
            machine.oscillator if isinstance(machine, GearPair) else machine for machine in self.machines
        ]
        rules = {(math.isinf(each.stiffness), each.permanent_after) for each in own}
        if len(rules) > 1:
            raise InvalidJob(
                "machines are all of the impacting model or all of the piecewise linear one, with one rule for "
                "permanent contacts",
                (MACHINES,),
            )
        orders = sorted({harmonic.order for each in own for harmonic in each.harmonics})
        return tuple(each._replace(harmonics=_with_orders(each, orders)) for each in own)

    @property
    def design(self) -> dict[str, Any]:
        """The design of a sweep's request: those numbers of the model that differ."""
        first = self.oscillators[0]
        columns = {name: [each.value_of(name) for each in self.oscillators] for name in first.parameters}
        differ = {name: values for name, values in columns.items() if len(set(values)) > 1}
        design: dict[str, Any] = {"name": self.name, "values": list(self.values)}
        design["parameters"] = differ or {_ONE_AT_LEAST: columns[_ONE_AT_LEAST]}
        return design if self.units is None else design | {"units": self.units}

    def with_units(self, result: "xr.Dataset") -> "xr.Dataset":
        """A result of these machines with SI units beside the numbers of the model: of each machine its own.

        Parameters
        ----------
        result : xarray.Dataset
            Of the sweep over them.

        Returns
        -------
        xarray.Dataset
            What `GearPair.with_units` adds has the coordinate's dimension here, as one unit of the model differs from
            machine to machine; ``gamma`` is there, too.
        """
        if not self.pairs:
            return result
        import xarray as xr

        units = {unit: xr.Variable((self.name,), scales) for unit, scales in self._scales.items()}
        said = {"long_name": "inertia torque over drag torque"}
        gamma = ((self.name,), [pair.gamma for pair in self.pairs], said)
        machines = json.dumps([pair.as_request for pair in self.pairs])
        return beside_in_si(result, units).assign(gamma=gamma).assign_attrs({MACHINES: machines})

    def with_columns(self, table: "pd.DataFrame") -> "pd.DataFrame":
        """A table of a result of these machines with columns in SI units, if its rows say of which machine they are.

        Parameters
        ----------
        table : pandas.DataFrame

        Returns
        -------
        pandas.DataFrame
        """
        if self.name not in table.columns or not self.pairs:
            return table
        machines = table[self.name].map({value: index for index, value in enumerate(self.values)})
        return with_columns_in_si(table, {unit: scales[machines] for unit, scales in self._scales.items()})

    @property
    def factors(self) -> dict[str, tuple[str, np.ndarray]]:
        """Unit of each variable of a result that has one, and what one unit of the model is in it, of each machine."""
        return factors_of(self._scales) if self.pairs else {}

    @property
    def _scales(self) -> dict[str, np.ndarray]:
        """One unit of the model for each machine, by the unit in SI."""
        units = [pair.units for pair in self.pairs]
        return {unit: np.array([each[unit] for each in units]) for unit in units[0]}


def machine_of(request: Mapping[str, Any]) -> GearPair | MachineSeries | None:
    """Machine that a request's oscillator comes from, or the machines of its design.

    Parameters
    ----------
    request : mapping
        As JSON. Its oscillator and its design are valid.

    Returns
    -------
    GearPair or MachineSeries, optional
        None if the request is of the model alone.

    Raises
    ------
    InvalidJob
        If it is no machine, or another one than the oscillator says.
    """
    given, design = request.get(MACHINE), request.get("design")
    if given is None:
        return None
    try:
        found = GearPair(**given) if design is None else MachineSeries.of_request(given, design)
    except InvalidFields as error:
        raise InvalidFields([((MACHINE, *place), message) for place, message in error.faults]) from None
    except InvalidJob as error:
        raise InvalidJob(str(error), (MACHINE, *error.place)) from None
    asked: Oscillator = _OSCILLATOR.validate_python(request.get("oscillator", {"model": "impacting"})).value
    own = found.oscillator if isinstance(found, GearPair) else found.oscillators[0]
    vary = request.get("vary", [])
    swept = {each["parameter"] for each in (vary if isinstance(vary, list) else [vary])}
    alike = asked.parameters == own.parameters
    if isinstance(found, MachineSeries):
        swept = {*found.design["parameters"]}
        alike = alike and found.design == design
    if not alike or any(asked.value_of(name) != own.value_of(name) for name in asked.parameters if name not in swept):
        raise InvalidJob(
            "the machine has another oscillator than the request: leave one out, as one follows from the other",
            (MACHINE,),
        )
    return found


def settled_with_machine(job: "_Job") -> "_Job":
    """The job with its machine in canonical form: one machine, one digest, in whatever units it was written.

    Parameters
    ----------
    job : Job

    Returns
    -------
    Job
        The job itself if it has no machine, or one in this form.

    Raises
    ------
    InvalidJob
        If it is no machine, or another one than the oscillator says.
    """
    found = machine_of(job.request()) if job.machine_ is not None else None
    if found is None:
        return job
    own = found.as_request
    # 1 and 1.0 are equal, but not as texts.
    if json.dumps(own, sort_keys=True) == json.dumps(job.machine_, sort_keys=True):
        return job
    return type(job).from_request(job.request() | {MACHINE: own})


def _with_orders(oscillator: Oscillator, orders: Sequence[float]) -> tuple[Harmonic, ...]:
    """Harmonics of all orders; one that the oscillator lacks has no amplitude."""
    own = {harmonic.order: harmonic for harmonic in oscillator.harmonics}
    return tuple(own.get(order, Harmonic(order, 0.0, 0.0)) for order in orders)


def _read_steps(name: str, unit: str | None, given: Any) -> _Steps:
    """Values of a number of a machine: those of a list or an array, or (start, stop, count[, spacing])."""
    form = f"values of {name} are a list or an array, or (start, stop, count), not {given!r}"
    given = given.tolist() if isinstance(given, np.ndarray) else given
    if not isinstance(given, list | tuple) or (isinstance(given, tuple) and not 3 <= len(given) <= 4):
        raise InvalidJob(form, (name,))
    if not given:
        raise InvalidJob(f"{name} needs at least one value", (name,))
    rule = given[2:] if isinstance(given, tuple) else ()
    read = _in_one_unit(name, unit, given[:2] if rule else given)
    if not rule:
        return read
    try:
        count, spacing = _rule(*rule)
    except ValueError:
        raise InvalidJob(f"{form}: a count is 2 or more, a spacing linear or geometric", (name,)) from None
    if spacing == Spacing.GEOMETRIC and min(read.values) <= 0.0:
        raise InvalidJob(f"{name} can only be spaced geometrically from and to values above 0", (name,))
    start, stop = read.values
    return read._replace(values=spaced(start, stop, count, spacing))


def _rule(count: Any, spacing: Any = Spacing.LINEAR) -> tuple[int, Spacing]:
    if not isinstance(count, int) or count < 2:
        raise ValueError
    return count, Spacing(spacing)


def _in_one_unit(name: str, unit: str | None, given: Sequence[Any]) -> _Steps:
    """Values in the unit in which all are written, or in SI where they differ."""
    values = [each.item() if isinstance(each, np.generic) else each for each in given]
    for index, value in enumerate(values):
        if isinstance(value, bool) or not isinstance(value, int | float | str if unit else int | float):
            raise InvalidJob(
                f"number {index} of {name} is {value!r}: {'a quantity' if unit else 'a number'} is wanted", (name,)
            )
    try:
        numbers = [float(in_si(value, unit or "")) for value in values]
    except InvalidJob as error:
        raise InvalidJob(f"{name}: {error}", (name,)) from None
    written = [number_and_unit(value) if isinstance(value, str) else (float(value), unit) for value in values]
    if len({each for _, each in written}) > 1:
        return _Steps(unit, tuple(numbers))
    return _Steps(written[0][1], tuple(number for number, _ in written))

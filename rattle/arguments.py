"""From the arguments of a verb to its job; what is wrong is named as it was written.

Most arguments are fields of the job's class. Others are parts of a field, such as the numbers of the oscillator or the
window of the grid: `_PARTS` has those fields, each with the function that makes it of its arguments.
"""

import math
from collections.abc import Callable, Mapping
from numbers import Integral
from typing import Any

import numpy as np
from pydantic import ValidationError

from rattle.measured_curve import transmission_error
from rattle_kernels import TransmissionError
from rattle_kernels.model.oscillator import PARAMETERS
from worker.additions import Addition, additions
from worker.errors import FieldPath, InvalidFields, InvalidJob
from worker.gear_pair import MACHINE, GearPair
from worker.jobs.job import Job
from worker.jobs.oscillator_request import (
    BOTH_FORCINGS,
    PIECEWISE_LINEAR,
    ImpactingOscillator,
    PiecewiseLinearOscillator,
)
from worker.jobs.region import ResolutionRequest
from worker.jobs.request import refusal
from worker.jobs.swept_parameter import is_of_harmonic, is_parameter
from worker.jobs.trajectory_request import TrajectoryRequest
from worker.kinds import KINDS
from worker.machine_series import MACHINES, UNITS, MachineSeries
from worker.precision_limits import fastest_of

Values = dict[str, Any]
"""Arguments by name, only those that were given. What makes a field of some takes these out."""

# Of one basin the grid's own default holds; a sweep has many, and starts smaller.
_CELLS_OF_A_SWEEP = 200
_OF_IMPACTS, _OF_CONTACTS = ("restitution",), ("contact_damping", "permanent_contact", "allow_no_quiet_solution")
_OF_OSCILLATOR = (ImpactingOscillator.model_fields | PiecewiseLinearOscillator.model_fields).keys()
# Fields whose parts are arguments.
_FLAT = ("grid", "oscillator", "resolution", "region", "sample", *(each.name for each in additions()))


def read_machine(values: Values) -> GearPair | MachineSeries | None:
    """Read the machine of a verb's arguments, or the machines of a sweep, and leave it among them as ``machine``.

    Parameters
    ----------
    values : dict
        Arguments by name. What machines are made of is taken out.

    Returns
    -------
    GearPair or MachineSeries, optional

    Raises
    ------
    InvalidJob
        If there is none, it is not followed at its speed, or several things are stepped through.
    """
    given, listed = values.get("machine"), values.pop(MACHINES, None)
    several = {name: value for name in UNITS if (value := values.pop(name, None)) is not None}
    read: GearPair | MachineSeries | None = None
    if listed is not None:
        for name in (*several, *(("machine",) if given is not None else ())):
            raise InvalidJob(f"{name} is given beside machines: give the list alone", (name,))
        read = MachineSeries.listed(listed)
    elif several:
        if given is None:
            raise InvalidJob(f"{next(iter(several))} is a number of a machine: give the machine as well", ("machine",))
        if len(several) > 1:
            names = " and ".join(several)
            raise InvalidJob(
                f"a sweep steps through one number of a machine, not {names}: give machines=[...]", (names,)
            )
        ((name, value),) = several.items()
        read = MachineSeries.over(GearPair.of(given), name, value)
    elif isinstance(given, MachineSeries):
        read = given
    elif given is not None:
        read = GearPair.of(given)
    if read is not None:
        values["machine"] = read
    return read


def job_of(kind: str, given: Mapping[str, Any]) -> Job:
    """Job that arguments describe.

    Parameters
    ----------
    kind : str
        Of the job.
    given : mapping
        Only the arguments that were given. Of two swept parameters the later one runs fastest.

    Returns
    -------
    Job

    Raises
    ------
    InvalidJob, OutsideDomain
        If a value is wrong. Both are a ValueError.
    """
    job_class = KINDS[kind].job_class
    values = {name: _plain(value) for name, value in given.items()}
    for addition in additions():
        values = addition.with_values(values)
    _read_machine(values, kind)
    fields = {field.alias for field in job_class.model_fields.values()}
    made = {name: make(values, kind) for name, make in _PARTS.items() if name in fields}
    request = {name: value for name, value in made.items() if value is not None}
    try:
        return job_class.from_request(request | values)
    except InvalidFields as error:
        faults = [(_argument_at(place), message) for place, message in error.faults]
        raise InvalidFields(list(dict.fromkeys(faults))) from None  # one argument may make two fields


def trajectory_of(given: Mapping[str, Any]) -> TrajectoryRequest:
    """Request for a trajectory that arguments describe.

    Parameters
    ----------
    given : mapping
        Only the arguments that were given.

    Returns
    -------
    TrajectoryRequest

    Raises
    ------
    InvalidJob
        If a value has a wrong type or lies out of range.
    """
    values = {name: _plain(value) for name, value in given.items()}
    _read_machine(values, _TRAJECTORY)
    start = _taken(values, "time", "velocity", "displacement")
    request: Values = {"oscillator": _oscillator(values, _TRAJECTORY), "start": start}
    try:
        return TrajectoryRequest(**request | values)
    except ValidationError as error:
        raise refusal(error) from error


def _plain(value: Any) -> Any:
    """Numbers of NumPy as Python's; arrays as lists."""
    return value.tolist() if isinstance(value, np.generic | np.ndarray) else value


def _taken(values: Values, *names: str) -> Values:
    return {name: values.pop(name) for name in names if name in values}


def _argument_at(place: FieldPath) -> FieldPath:
    """Argument that a field of the request comes from."""
    if place[:1] == ("grid",) and place[-1:] == ("cells",):
        return ("cells",)
    if place[:2] == ("sample", "points"):
        return ("sample",)
    return place[1:] if place[:1] and place[0] in _FLAT and len(place) > 1 else place


def _oscillator(values: Values, kind: str) -> Values:
    """An oscillator of either model; what a study varies is left with the arguments."""
    soft = "stiffness" in values
    _read_measured_curve(values)
    swept = [name for name, value in values.items() if is_parameter(name) and isinstance(value, list | tuple | dict)]
    if swept and kind not in ("sweep", "bifurcation"):
        others = ", and ".join(("a sweep takes several values", *(each.on_pairs for each in additions())))
        raise InvalidJob(f"{swept[0]} has one value here; {others}", (swept[0],))
    harmonics = _harmonics(values, swept)
    request = _taken(values, *(name for name in _OF_OSCILLATOR if name not in swept))
    foreign = "impacting model: leave out the stiffness, or give contact_damping"
    if not soft:
        foreign = "piecewise linear model: give a stiffness"
    for name in _OF_IMPACTS if soft else _OF_CONTACTS:
        if name in request or name in swept:
            raise InvalidJob(f"{name} belongs to the {foreign}", (name,))
    return request | harmonics | ({"model": PIECEWISE_LINEAR} if soft else {})


_OF_WINDOWS = "basin", "sweep", "orbits", "manifold"
_TRAJECTORY = "trajectory"


def _read_machine(values: Values, kind: str) -> None:
    """Put the numbers of the model beside a machine, and a window that is not given, which follows it."""
    machine = read_machine(values)
    values.pop("machine", None)
    if machine is None:
        return
    oscillators = machine.oscillators if isinstance(machine, MachineSeries) else (machine.oscillator,)
    oscillator = oscillators[0]
    lossy = "restitution" if math.isinf(oscillator.stiffness) else "contact_damping"
    names = "damping", "eccentricity", "half_backlash", lossy, *(("stiffness",) if lossy == "contact_damping" else ())
    numbers: Values = {name: getattr(oscillator, name) for name in names}
    if oscillator.harmonics:
        numbers["harmonics"] = list(oscillator.harmonics)
    if lossy == "contact_damping":
        numbers["allow_no_quiet_solution"] = True  # the machine is as it is
    for name in ("transmission_error", "harmonics", *PARAMETERS):
        swept = name in PARAMETERS and isinstance(values.get(name), list | tuple | dict)
        if name in values and (isinstance(machine, MachineSeries) or not swept):
            raise InvalidJob(f"{name} is given twice: the machine has its own", (name,))
    if isinstance(machine, MachineSeries):
        values["design"] = machine.design
    if kind in _OF_WINDOWS and "velocity" not in values:
        values["velocity"] = (0.0, max(map(fastest_of, oscillators)))
    values.update(numbers | values)
    if kind != _TRAJECTORY and (own := machine.as_request) is not None:
        values[MACHINE] = own


def _read_measured_curve(values: Values) -> None:
    """Replace a measured curve by its eccentricity and harmonics; an eccentricity that is swept stays."""
    measured = values.pop("transmission_error", None)
    if measured is None:
        return
    if "harmonics" in values or isinstance(values.get("eccentricity"), int | float):
        raise InvalidJob(BOTH_FORCINGS, ("transmission_error",))
    if not isinstance(measured, TransmissionError):
        measured = transmission_error(measured)
    values.update(dict(measured.forcing) | values)


def _harmonics(values: Values, swept: list[str]) -> Values:
    """Harmonics of a request; one number of theirs that is not swept is refused, as it is one of theirs already."""
    for name in values:
        if is_of_harmonic(name) and name not in swept:
            raise InvalidJob(f"{name} has one value: write it into harmonics; several values are swept", (name,))
    harmonics = values.pop("harmonics", None)
    if harmonics is None:
        return {}
    if not isinstance(harmonics, list | tuple):
        raise InvalidJob(f"harmonics are a list of (order, amplitude, phase), not {harmonics!r}", ("harmonics",))
    written = []
    for each in harmonics:
        parts = each if isinstance(each, list | tuple) else [each]
        if not 2 <= len(parts) <= 3:
            raise InvalidJob(f"a harmonic is (order, amplitude, phase), not {each!r}", ("harmonics",))
        order = int(parts[0]) if isinstance(parts[0], float) and parts[0].is_integer() else parts[0]
        written.append(dict(zip(("order", "amplitude", "phase"), (order, *parts[1:]), strict=False)))
    return {"harmonics": written}


def _vary(values: Values, kind: str) -> Any:
    """Values of swept parameters: those of a list or an array, or (start, stop, count[, spacing]); none of machines."""
    if "design" in values:
        return None
    swept = [_spaced_or_listed(name, values.pop(name)) for name in list(values) if is_parameter(name)]
    several = kind == "sweep"
    if not swept or (len(swept) > 1 and not several):
        most = "one or two of" if several else "one of"
        raise InvalidJob(
            f"give several values of {most} {', '.join(PARAMETERS)}: a list or an array, or (start, stop, count)"
        )
    return swept if several else swept[0]


def _spaced_or_listed(parameter: str, value: Any) -> Values:
    if isinstance(value, dict):
        return {"parameter": parameter} | value
    if isinstance(value, list):
        return {"parameter": parameter, "values": value}
    if not 3 <= len(value) <= 4:
        raise InvalidJob(
            f"values of {parameter} are a list or an array, or (start, stop, count), not {value!r}", (parameter,)
        )
    return {"parameter": parameter} | dict(zip(("start", "stop", "count", "spacing"), value, strict=False))


def _velocity(values: Values, _: str) -> Values | None:
    return _windows(values, "velocity").get("velocity")


def _region(values: Values, _: str) -> Values | None:
    return _windows(values, "time", "velocity") or None


def _windows(values: Values, *names: str) -> Values:
    """Intervals, each written as a pair."""
    windows = {}
    for name, value in _taken(values, *names).items():
        if not (isinstance(value, list | tuple) and len(value) == 2):
            raise InvalidJob(f"{name} is a pair, from where to where, as in {name}=(0, 1), not {value!r}", (name,))
        windows[name] = {"start": value[0], "stop": value[1]}
    return windows


def _grid(values: Values, kind: str) -> Values:
    request: Values = {"time": {}, "velocity": {}} | _windows(values, "time", "velocity")
    usual = _CELLS_OF_A_SWEEP if kind == "sweep" and "sample" not in values else None
    counts = values.pop("cells", usual)
    if counts is None:
        return request
    if isinstance(counts, Integral):
        counts = counts, counts
    if not (isinstance(counts, list | tuple) and len(counts) == 2):
        raise InvalidJob(f"cells is a number, or a pair of them, not {counts!r}", ("cells",))
    for window, count in zip(request.values(), counts, strict=True):
        window["cells"] = count
    return request


def _sample(values: Values, _: str) -> Values | None:
    beside = _taken(values, "seed", "scramblings")
    if "sample" in values:
        return {"points": values.pop("sample")} | beside
    for name in beside:
        raise InvalidJob(f"{name} belongs to a sample: give its points, as in sample=4096 (--sample)", (name,))
    return None


def _added(addition: Addition) -> "Callable[[Values, str], Any]":
    return lambda values, _: addition.from_arguments(values)


def _seeds(values: Values, kind: str) -> list[Any] | None:
    return [_departure(each, "seeds", kind == "orbits") for each in _listed(values.pop("seeds", None))] or None


def _saddles(values: Values, _: str) -> list[Any]:
    return [
        {"itinerary": each} if isinstance(each, str) else _departure(each, "saddles", True)
        for each in _listed(values.pop("saddles", None))
    ]


def _listed(value: Any) -> list[Any]:
    """The values of an argument that takes several; one is a list of itself."""
    if value is None:
        return []
    return list(value) if isinstance(value, list | tuple) else [value]


def _departure(value: Any, name: str, with_period: bool) -> Any:
    if isinstance(value, dict):  # as in a request
        return value
    fields = ("time", "velocity", "period")[: 3 if with_period else 2]
    if not (isinstance(value, list | tuple) and 2 <= len(value) <= len(fields)):
        raise InvalidJob(f"{name} are a list of departures ({', '.join(fields)}), not {value!r}", (name,))
    return {field: _plain(part) for field, part in zip(fields, value, strict=False)}


def _resolution(values: Values, _: str) -> Values | None:
    request, finest = _taken(values, "chord", "angle"), ResolutionRequest().finest
    if "chord" in request:
        request["finest"] = min(request["chord"], finest)
    return request or None


def _continuation(name: str) -> "Callable[[Values, str], Any]":
    def read(values: Values, _: str) -> Any:
        value = values.pop(name, None)
        if value is None or (isinstance(value, dict) and "parameter" in value):
            return value
        if not (isinstance(value, dict) and len(value) == 1):
            raise InvalidJob(f'{name} is written as in {{"damping": (0.45, 0.7)}}, not {value!r}', (name,))
        ((parameter, interval),) = value.items()
        if not (isinstance(interval, list | tuple) and 2 <= len(interval) <= 3):
            raise InvalidJob(f"{parameter} is followed between two values, as in (0.45, 0.7)", (name,))
        return {"parameter": parameter} | dict(zip(("start", "stop", "most_points"), interval, strict=False))

    return read


_PARTS: "dict[str, Callable[[Values, str], Any]]" = {
    "oscillator": _oscillator,
    "vary": _vary,  # after the oscillator, which takes what has one value
    "velocity": _velocity,  # before the region, which a job with speeds to keep cannot use
    "region": _region,
    "grid": _grid,
    "sample": _sample,  # after the grid, whose cells a sample replaces
    **{each.name: _added(each) for each in additions()},
    "seeds": _seeds,
    "saddles": _saddles,
    "resolution": _resolution,
    "continuation": _continuation("continuation"),
    "curves": _continuation("curves"),
}

"""Options that are written as text, converted to arguments of the verbs."""

from collections.abc import Sequence
from typing import Any

from rattle.measured_curve import transmission_error
from rattle_kernels import TransmissionError
from worker.errors import InvalidJob
from worker.jobs.swept_parameter import known_parameter

_MEASURED: dict[str, Any] = {"unit": str, "scale": float, "explained": float}


def swept_of(texts: Sequence[str]) -> dict[str, Any]:
    """Swept parameters, each written ``damping=0.5,0.55,0.6`` or ``damping=0.5:0.7:21[:geometric]``.

    Parameters
    ----------
    texts : sequence of str

    Returns
    -------
    dict
        Values by parameter.

    Raises
    ------
    InvalidJob
        If one has another form, or a parameter is named twice.
    """
    swept: dict[str, Any] = {}
    for text in texts:
        parameter, values = _values_of(text)
        parameter = parameter.replace("-", "_")  # as its own option is written
        try:
            known_parameter(parameter)
        except ValueError as error:
            raise InvalidJob(str(error)) from error
        if parameter in swept:
            raise InvalidJob(f"{parameter} is swept twice")
        swept[parameter] = values
    return swept


def _values_of(text: str) -> tuple[str, Any]:
    parameter, _, values = text.partition("=")
    try:
        if ":" not in values:
            return parameter, [float(value) for value in values.split(",") if value]
        start, stop, count, *spacing = values.split(":")
        return parameter, (float(start), float(stop), int(count), *spacing[:1])
    except ValueError as error:
        forms = "write values, damping=0.5,0.55,0.6, or from where to where and how many, damping=0.5:0.7:21"
        raise InvalidJob(f"--vary {text}: {forms}") from error


def tolerances_of(texts: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Tolerances, each written ``damping=0.59:0.61``.

    Parameters
    ----------
    texts : sequence of str

    Returns
    -------
    dict
        Least and greatest value by parameter.

    Raises
    ------
    InvalidJob
        If one has another form.
    """
    tolerances = {}
    for text in texts:
        parameter, _, ends = text.partition("=")
        try:
            least, greatest = map(float, ends.split(":"))
        except ValueError as error:
            raise InvalidJob(f"--tolerance {text}: write between which values, damping=0.59:0.61") from error
        tolerances[parameter.replace("-", "_")] = least, greatest
    return tolerances


def departure_of(text: str) -> tuple[float, ...]:
    """Departure, written ``t,v``.

    Parameters
    ----------
    text : str

    Returns
    -------
    tuple

    Raises
    ------
    InvalidJob
        If it has another form.
    """
    try:
        time, velocity = (float(part) for part in text.split(","))
    except ValueError as error:
        raise InvalidJob(f"--seed {text}: write phase and speed of a departure, as in 0.6,3.77") from error
    return time, velocity


def orbit_seed_of(text: str, option: str = "seed") -> tuple[float, ...]:
    """Departure and impact period, written ``t,v[,period]``.

    Parameters
    ----------
    text : str
    option : str
        For the message.

    Returns
    -------
    tuple

    Raises
    ------
    InvalidJob
        If it has another form.
    """
    *departure, period = text.split(",") if text.count(",") == 2 else [*text.split(","), "1"]
    try:
        time, velocity = (float(part) for part in departure)
        return time, velocity, int(period)
    except ValueError as error:
        raise InvalidJob(f"--{option} {text}: write phase, speed and impact period, as in 0.786,1.613,2") from error


def saddle_of(text: str) -> str | tuple[float, ...]:
    """Saddle, written ``t,v[,period]`` or as an itinerary.

    Parameters
    ----------
    text : str

    Returns
    -------
    str or tuple

    Raises
    ------
    InvalidJob
        If it has another form.
    """
    return text if "(" in text else orbit_seed_of(text, "saddle")


def harmonic_of(text: str) -> tuple[float, ...]:
    """Harmonic of the forcing, written ``order:amplitude[:phase]``.

    Parameters
    ----------
    text : str

    Returns
    -------
    tuple

    Raises
    ------
    InvalidJob
        If it has another form.
    """
    try:
        order, amplitude, phase = text.split(":") if text.count(":") > 1 else (*text.split(":"), "0")
        return int(order), float(amplitude), float(phase)
    except ValueError as error:
        told = "write order, amplitude and phase, as in 2:0.01:0.25; an order is a whole number"
        raise InvalidJob(f"--harmonic {text}: {told}") from error


def measured_of(text: str) -> TransmissionError:
    """Measured transmission error, written ``te.csv[,unit=degrees][,scale=0.01][,explained=0.99]``.

    Parameters
    ----------
    text : str

    Returns
    -------
    TransmissionError

    Raises
    ------
    InvalidJob
        If it has another form, or the curve cannot be used.
    """
    # Settings are the last parts that have "=": a file's name may have commas.
    parts = text.split(",")
    named = next((place for place in range(len(parts), 1, -1) if "=" not in parts[place - 1]), 1)
    options: dict[str, Any] = {}
    for setting in parts[named:]:
        name, _, value = setting.partition("=")
        try:
            options[name] = _MEASURED[name](value)
        except (KeyError, ValueError) as error:
            forms = "write te.csv,unit=degrees,scale=0.01,explained=0.99, or some of these"
            raise InvalidJob(f"--transmission-error {text}: {forms}") from error
    return transmission_error(",".join(parts[:named]), **options)


def continuation_of(text: str, option: str) -> dict[str, Any]:
    """Parameter to follow something in, written ``damping=0.45:0.7[:points]``.

    Parameters
    ----------
    text : str
    option : str
        For the message.

    Returns
    -------
    dict

    Raises
    ------
    InvalidJob
        If it has another form.
    """
    parameter, _, interval = text.partition("=")
    try:
        start, stop, *points = interval.split(":")
        return {parameter.replace("-", "_"): (float(start), float(stop), *(int(count) for count in points[:1]))}
    except ValueError as error:
        raise InvalidJob(f"--{option} {text}: write damping=0.45:0.7 or damping=0.45:0.7:5000") from error

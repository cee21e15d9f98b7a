"""Values of options that are written as text, as requests have them."""

from typing import Any

from worker.errors import InvalidJob


def vary_of(text: str) -> dict[str, Any]:
    """Swept parameter, written ``damping=0.5,0.55,0.6`` or ``damping=0.5:0.7:21[:geometric]``.

    Parameters
    ----------
    text : str

    Returns
    -------
    dict

    Raises
    ------
    InvalidJob
        If it is written otherwise.
    """
    parameter, _, values = text.partition("=")
    try:
        if ":" not in values:
            return {"parameter": parameter, "values": [float(value) for value in values.split(",") if value]}
        start, stop, count, *spacing = values.split(":")
        spaced = {"parameter": parameter, "start": float(start), "stop": float(stop), "count": int(count)}
        return spaced | ({"spacing": spacing[0]} if spacing else {})
    except ValueError as error:
        raise InvalidJob(f"--vary {text}: write damping=0.5,0.55,0.6 or damping=0.5:0.7:21 ({error})") from error


def departure_of(text: str) -> dict[str, Any]:
    """Departure, written ``t,v``.

    Parameters
    ----------
    text : str

    Returns
    -------
    dict

    Raises
    ------
    InvalidJob
        If it is written otherwise.
    """
    try:
        time, velocity = (float(part) for part in text.split(","))
    except ValueError as error:
        raise InvalidJob(f"--seed {text}: write phase and speed of a departure, as in 0.6,3.77") from error
    return {"time": time, "velocity": velocity}


def orbit_seed_of(text: str, option: str = "seed") -> dict[str, Any]:
    """Departure and impact period, written ``t,v[,period]``.

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
        If it is written otherwise.
    """
    *departure, period = text.split(",") if text.count(",") == 2 else [*text.split(","), "1"]
    try:
        time, velocity = (float(part) for part in departure)
        return {"time": time, "velocity": velocity, "period": int(period)}
    except ValueError as error:
        raise InvalidJob(f"--{option} {text}: write phase, speed and impact period, as in 0.786,1.613,2") from error


def saddle_of(text: str) -> dict[str, Any]:
    """Saddle, written ``t,v[,period]`` or as an itinerary.

    Parameters
    ----------
    text : str

    Returns
    -------
    dict

    Raises
    ------
    InvalidJob
        If it is written otherwise.
    """
    return {"itinerary": text} if "(" in text else orbit_seed_of(text, "saddle")


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
        If it is written otherwise.
    """
    parameter, _, interval = text.partition("=")
    try:
        start, stop, *points = interval.split(":")
        bounds = {"parameter": parameter, "start": float(start), "stop": float(stop)}
        return bounds | ({"most_points": int(points[0])} if points else {})
    except ValueError as error:
        raise InvalidJob(f"--{option} {text}: write damping=0.45:0.7 or damping=0.45:0.7:5000") from error

"""From the arguments of a verb to its job; what is wrong is named as it was written."""

import difflib
from collections.abc import Iterable, Sequence
from typing import Any

from rattle.argument import Argument, Values, is_parameter, plain
from rattle.argument_groups import groups_of
from worker.errors import InvalidFields, Place
from worker.jobs.job import Job
from worker.jobs.swept_parameter import is_of_harmonic


def arguments_of(job_class: type[Job]) -> list[Argument]:
    """Arguments of the verb for a job.

    Parameters
    ----------
    job_class : type

    Returns
    -------
    list of Argument
    """
    return [each for group in groups_of(job_class).values() for each in group.arguments]


def job_of(job_class: type[Job], given: Values, verb: str) -> Job:
    """Job that arguments describe.

    Parameters
    ----------
    job_class : type
    given : dict
        Only the arguments that were given.
    verb : str
        For messages.

    Returns
    -------
    Job

    Raises
    ------
    TypeError
        If an argument is unknown or missing.
    InvalidJob, OutsideDomain
        If a value is wrong. Both are a ValueError.
    """
    demand_given(verb, given, arguments_of(job_class))
    try:
        return job_class.from_request(request_of(job_class, given))
    except InvalidFields as error:
        faults = [(_argument_at(place), message) for place, message in error.faults]
        raise InvalidFields(list(dict.fromkeys(faults))) from None  # one argument may make two fields


def demand_given(verb: str, given: Values, arguments: Sequence[Argument]) -> None:
    """Refuse arguments that a verb does not have, and the lack of those that it needs.

    Raises
    ------
    TypeError
    """
    demand_known(verb, given, [each.name for each in arguments])
    for each in arguments:
        if each.default is ... and each.name not in given:
            raise TypeError(f"{verb}() needs {each.name}: {each.text}")


def demand_names(verb: str, positional: Sequence[Any], arguments: Sequence[Argument]) -> None:
    """Refuse arguments without names.

    Raises
    ------
    TypeError
        It writes them with the names that they seem to be meant for.
    """
    if positional:
        named = ", ".join(f"{each.name}={value!r}" for each, value in zip(arguments, positional, strict=False))
        raise TypeError(f"{verb}() takes its arguments by name, as in {verb}({named})")


def demand_known(verb: str, given: Iterable[str], known: Sequence[str]) -> None:
    """Refuse an argument that a verb does not have.

    Raises
    ------
    TypeError
        It names the argument, and one that may have been meant.
    """
    for name in given:
        if name not in known and not ("harmonics" in known and is_of_harmonic(name)):
            near = difflib.get_close_matches(name, known, 1)
            hint = f"did you mean {near[0]}?" if near else f"it takes {', '.join(known)}"
            raise TypeError(f"{verb}() has no argument {name!r}: {hint}")


def request_of(job_class: type[Job], given: Values) -> dict[str, Any]:
    """Request that arguments make, as JSON; nothing is checked yet but what cannot be read.

    Raises
    ------
    InvalidJob
    """
    values = _with_middles({name: plain(value) for name, value in given.items()})
    read = {name: group.read(values) for name, group in groups_of(job_class).items()}
    return {name: value for name, value in read.items() if value is not None}


def _with_middles(values: dict[str, Any]) -> dict[str, Any]:
    """Parameters that are a pair where a proof is asked for are tolerances: the oscillator is in their middle."""
    pairs = {
        name: tuple(value) for name, value in values.items() if is_parameter(name) and isinstance(value, list | tuple)
    }
    if values.get("prove") is not True or any(len(pair) != 2 for pair in pairs.values()):
        return values
    middles = {name: 0.5 * (low + high) for name, (low, high) in pairs.items()}
    tolerances = pairs | (values.get("tolerances") or {})
    return values | middles | ({"tolerances": tolerances} if tolerances else {})


def _argument_at(place: Place) -> Place:
    """Argument that a field of the request comes from."""
    if place[:1] == ("grid",) and place[-1:] == ("cells",):
        return ("cells",)
    if place[:2] == ("sample", "points"):
        return ("sample",)
    grouped = (("grid",), ("oscillator",), ("resolution",), ("region",), ("sample",), ("prove",))
    return place[1:] if place[:1] in grouped and len(place) > 1 else place

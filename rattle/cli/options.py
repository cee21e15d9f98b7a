"""Options of the command line, made from the arguments of the verbs.

Arguments that are a list, a tuple or a dict in Python are text here: `_WRITTEN` has those options.
"""

import inspect
from collections.abc import Callable, Sequence
from typing import Annotated, Any, NamedTuple

import typer

from rattle.argument import Argument, is_parameter
from rattle.arguments import arguments_of
from rattle.cli.texts import (
    continuation_of,
    departure_of,
    harmonic_of,
    measured_of,
    orbit_seed_of,
    saddle_of,
    swept_of,
    tolerances_of,
)
from worker.jobs.basin_job import SweepJob
from worker.jobs.bifurcation_job import BifurcationJob
from worker.jobs.job import Job
from worker.jobs.orbits_job import OrbitsJob

Values = dict[str, Any]
"""Values of a command's options, by their names in Python."""


class Written(NamedTuple):
    """An option whose value is text, and how it is read: from all values of the command, into arguments of the verb."""

    name: str
    kind: Any
    default: Any
    help: str
    read: Callable[[Any], Values]


def option(name: str, kind: Any, default: Any, *flags: str, **details: Any) -> inspect.Parameter:
    """Option of a command.

    Parameters
    ----------
    name : str
        Name of the function's argument.
    kind : type
    default : object
        ``...`` if the option is required.
    *flags : str
        Flags of the option, if they differ from its name.
    **details
        Arguments of `typer.Option`: help, min.

    Returns
    -------
    inspect.Parameter
    """
    default = inspect.Parameter.empty if default is ... else default
    annotation = Annotated[kind, typer.Option(*flags, **details)]
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


def with_options(options: Sequence[inspect.Parameter]) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command more options, whose values it takes as keyword arguments.

    Parameters
    ----------
    options : sequence of inspect.Parameter

    Returns
    -------
    callable
        Decorator.
    """

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        own = inspect.signature(command).parameters.values()
        named = [each.replace(kind=each.KEYWORD_ONLY) for each in own if each.kind is not each.VAR_KEYWORD]
        command.__signature__ = inspect.Signature([*named, *options])  # type: ignore[attr-defined]
        command.__annotations__ = {each.name: each.annotation for each in (*named, *options)}
        return command

    return decorate


def options_of(arguments: Sequence[Argument]) -> list[inspect.Parameter]:
    """Options for arguments that need no conversion."""
    return [_as_option(each) for each in arguments]


def _as_option(argument: Argument) -> inspect.Parameter:
    # A switch has no `--no-` form.
    flags = [f"--{argument.name.replace('_', '-')}"] if argument.kind is bool else []
    details = {"help": argument.text or None, "min": argument.least}
    if is_parameter(argument.name) and argument.default is not None:
        # None tells what was not given: beside a measured curve an eccentricity is refused, the default one, too.
        details["help"] = rf"{argument.text} \[default: {argument.default}]"
        return option(argument.name, argument.kind | None, None, *flags, **details)
    return option(argument.name, argument.kind, argument.default, *flags, **details)


def job_options(job_class: type[Job]) -> list[inspect.Parameter]:
    """Options of the command for a job.

    Parameters
    ----------
    job_class : type

    Returns
    -------
    list of inspect.Parameter
    """
    written = _written(job_class)
    as_they_are = [each for each in arguments_of(job_class) if each.name not in written]
    texts = [option(each.name, each.kind, each.default, help=each.help) for each in written.values()]
    return options_of(as_they_are) + texts


def given_of(arguments: Sequence[Argument], values: Values) -> Values:
    """Values of the options of `options_of` that were given: numbers of the oscillator, and what is no default.

    Parameters
    ----------
    arguments : sequence of Argument
    values : dict
        Of all options, by name.

    Returns
    -------
    dict
    """
    without = {each.name: (None, None if is_parameter(each.name) else each.default) for each in arguments}
    return {name: value for name, value in values.items() if name in without and value not in without[name]}


def arguments_from(job_class: type[Job], values: Values) -> Values:
    """Arguments of the verb, from the options that were given.

    Parameters
    ----------
    job_class : type
    values : dict

    Returns
    -------
    dict

    Raises
    ------
    InvalidJob
        If an option that is written as text cannot be read.
    """
    written = {each.name: each for each in _written(job_class).values()}
    given = given_of([each for each in arguments_of(job_class) if each.name not in written], values)
    for name, each in written.items():
        if values[name]:
            read = each.read(values[name])
            # Swept values come last, in their order.
            given = {key: value for key, value in given.items() if key not in read} | read
    return given


def _written(job_class: type[Job]) -> dict[str, Written]:
    """Options that are written as text, by the argument that they replace."""
    written = {}
    if issubclass(job_class, SweepJob):
        text = "damping=0.5,0.55,0.6 or damping=0.5:0.7:21[:geometric]; once or twice, the last fastest"
        written["vary"] = Written("vary", list[str], ..., text, swept_of)
    if issubclass(job_class, BifurcationJob):
        text = "damping=0.5:0.6:1000[:geometric] or damping=0.5,0.55,0.6"
        written["vary"] = Written("vary", str, ..., text, lambda text: swept_of([text]))
    names = [each.name for each in arguments_of(job_class)]
    return written | {name: make(job_class) for name, make in _REPLACED.items() if name in names}


def _seeds(job_class: type[Job]) -> Written:
    read: Callable[[str], tuple[float, ...]]
    if issubclass(job_class, OrbitsJob):
        text, read = "t,v[,period] close to an orbit; several; no search then", orbit_seed_of
    else:
        text, read = "Departure t,v to begin with; several; without, attractors are found", departure_of
    return Written("seed", list[str] | None, None, text, lambda texts: {"seeds": [read(each) for each in texts]})


def _continuation(name: str, argument: str, text: str) -> Callable[[type[Job]], Written]:
    def read(value: str) -> Values:
        return {argument: continuation_of(value, name)}

    return lambda _: Written(name, str | None, None, text, read)


HARMONICS = Written(
    "harmonic", list[str] | None, None, "order:amplitude[:phase] of a harmonic of the forcing: 2:0.01:0.25; several",
    lambda texts: {"harmonics": [harmonic_of(each) for each in texts]},
)  # fmt: skip
MEASURED = Written(
    "transmission_error", str | None, None,
    "te.csv[,unit=degrees][,scale=0.01][,explained=0.99]: a measured curve in place of eccentricity and harmonics",
    lambda text: {"transmission_error": measured_of(text)},
)  # fmt: skip
FORCING = {"harmonics": HARMONICS, "transmission_error": MEASURED}
"""Options for the forcing of an oscillator, by the argument that they replace."""

TOLERANCES = Written(
    "tolerance", list[str] | None, None, "damping=0.59:0.61, of a proof: it holds for every machine within; several",
    lambda texts: {"tolerances": tolerances_of(texts)},
)  # fmt: skip

_REPLACED: dict[str, Callable[[type[Job]], Written]] = {
    "tolerances": lambda _: TOLERANCES,
    "harmonics": lambda _: HARMONICS,
    "transmission_error": lambda _: MEASURED,
    "seeds": _seeds,
    "saddles": lambda _: Written(
        "saddle", list[str], ..., "t,v[,period] close to a saddle, or P(1,1,0); several",
        lambda texts: {"saddles": [saddle_of(each) for each in texts]},
    ),
    "continuation": _continuation(
        "follow", "continuation", "damping=0.45:0.7[:points]: follow orbits in a parameter"
    ),
    "curves": _continuation(
        "curves", "curves", "eccentricity=0.05:0.15[:points]: and special points in a second one"
    ),
}  # fmt: skip

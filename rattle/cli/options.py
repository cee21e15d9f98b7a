"""Options of the commands that compute, from the signatures and docstrings of the verbs.

What is a list, a tuple of more than two numbers or a dict in Python is text here: `_WRITTEN` has those options.
"""

import inspect
from collections.abc import Callable, Mapping, Sequence
from enum import StrEnum
from typing import Annotated, Any, Literal, NamedTuple, get_args, get_origin

import typer

from rattle.measured_curve import transmission_error
from rattle.verbs import given_of
from worker.additions import additions
from worker.errors import InvalidJob
from worker.gear_pair import number_and_unit
from worker.jobs.swept_parameter import is_parameter, known_parameter
from worker.machine_series import MACHINES, UNITS

Values = dict[str, Any]
"""Values of options, or of arguments, by name."""

_CHOICES: Any = StrEnum  # called with members, which type checkers take for a look-up

# The verbs leave it to the jobs to refuse what lies below; here the help says so, too.
LEAST = {"iterations": 1, "transient": 0, "kept": 1, "longest": 1, "samples_per_period": 1}
for _addition in additions():
    LEAST |= _addition.least()
# Where a result lies, and how it is computed, has options of its own. A number of a machine is given to `--vary`, and a
# list of machines is Python's alone.
_LEFT_OUT = {"store", "workers", "scheduler", "progress", MACHINES, *UNITS}


def options_of(verb: Callable[..., Any]) -> list[inspect.Parameter]:
    """Options of the command for a verb.

    Parameters
    ----------
    verb : callable

    Returns
    -------
    list of inspect.Parameter
    """
    written, texts = _written_of(verb), texts_of(verb)
    arguments = [
        each
        for name, each in inspect.signature(verb).parameters.items()
        if name not in written
        and name not in _LEFT_OUT
        and each.kind is each.KEYWORD_ONLY
        # What has parts is written as text, by a package that may be missing.
        and not any(get_origin(part) is Mapping for part in get_args(each.annotation))
    ]
    options = [_as_option(each, texts[each.name]) for each in arguments]
    return options + [option(each.option, each.kind, each.default, help=each.help) for each in written.values()]


def arguments_from(verb: Callable[..., Any], values: Values) -> Values:
    """Arguments of a verb, from the options that were given.

    Parameters
    ----------
    verb : callable
    values : dict
        Of all options of `options_of`.

    Returns
    -------
    dict

    Raises
    ------
    InvalidJob
        If an option that is written as text cannot be read.
    """
    written = {each.option: each for each in _written_of(verb).values()}
    usual = {each.name: each.default for each in options_of(verb)}
    plain = {
        name: value.value if isinstance(value, StrEnum) else value
        for name, value in values.items()
        if name not in written and value != usual[name]
    }
    given = given_of(verb, plain)
    for name, each in written.items():
        if values[name]:
            read = each.read(values[name])
            # Swept values come last, in their order.
            given = {key: value for key, value in given.items() if key not in read} | read
    return given


def option(name: str, kind: Any, default: Any, *flags: str, **details: Any) -> inspect.Parameter:
    """Option of a command; a default of `inspect.Parameter.empty` makes it required."""
    annotation = Annotated[kind, typer.Option(*flags, **details)]
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


def with_options(options: Sequence[inspect.Parameter]) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command more options, for Typer to read; their values come as keyword arguments.

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


def texts_of(verb: Callable[..., Any]) -> dict[str, str]:
    """What a verb's docstring says of each argument."""
    _, _, section = (inspect.getdoc(verb) or "").partition("Parameters\n----------\n")
    texts: dict[str, str] = {}
    for line in section.partition("\n\n")[0].splitlines():
        if not line.startswith(" "):
            name = line.partition(" : ")[0]
            texts[name] = ""
        else:
            texts[name] = f"{texts[name]} {line.strip()}".lstrip()
    return texts


def _as_option(argument: inspect.Parameter, text: str) -> inspect.Parameter:
    """Option of an argument that needs no text of its own."""
    kind: Any = argument.annotation
    name, default = argument.name, argument.default
    if is_parameter(name):
        # One number here. None tells what was not given: the default is the verb's.
        note = "" if default is None else rf" \[default: {default}]"
        return option(name, float | None, None, help=text + note)
    if kind is bool:  # a switch has no `--no-` form
        return option(name, bool, default, f"--{name.replace('_', '-')}", help=text)
    if get_origin(kind) is Literal:
        kind = _CHOICES(name, [(each, each) for each in get_args(kind)])
    elif kind == int | tuple[int, int]:
        kind, default = tuple[int, int], (default, default)
    least = 1 if (name, kind) == ("cells", int) else LEAST.get(name)
    return option(name, kind, default, help=text, min=least)


class _Written(NamedTuple):
    """An option whose value is text, and how that is read into arguments of the verb."""

    option: str
    kind: Any
    default: Any
    help: str
    read: Callable[[Any], Values]


def _written_of(verb: Callable[..., Any]) -> dict[str, _Written]:
    """Options that are written as text, by the argument that they replace."""
    written = _WRITTEN | _OWN.get(verb.__name__, {})
    return {name: written[name] for name in inspect.signature(verb).parameters if name in written}


def _read(option: str, text: str, form: str, read: Callable[[str], Any]) -> Any:
    try:
        return read(text)
    except (ValueError, KeyError) as error:
        raise InvalidJob(f"--{option} {text}: {form}") from error


def _swept(texts: Sequence[str]) -> Values:
    """Swept parameters, each written ``damping=0.5,0.55,0.6`` or ``damping=0.5:0.7:21[:geometric]``."""
    forms = "write values, damping=0.5,0.55,0.6, or from where to where and how many, damping=0.5:0.7:21"
    swept: Values = {}
    for text in texts:
        name = text.partition("=")[0].replace("-", "_")
        read = _read("vary", text, forms, lambda text: _values(text.partition("=")[2], float))
        try:
            known_parameter(name)
        except ValueError as error:
            raise InvalidJob(str(error)) from error
        if name in swept:
            raise InvalidJob(f"{name} is swept twice")
        swept[name] = read
    return swept


def _swept_or_machines(texts: Sequence[str]) -> Values:
    """Swept parameters, or a number of a machine, written ``speed=600:6000rpm:200`` or ``backlash=20,35,50um``."""
    quantities = {name: text for text in texts if (name := text.partition("=")[0].replace("-", "_")) in UNITS}
    if not quantities:
        return _swept(texts)
    if len(texts) > 1:
        raise InvalidJob(f"{next(iter(quantities))} is a number of a machine: step through it alone")
    ((name, text),) = quantities.items()
    form = f"write {name}=600,800,1000rpm or {name}=600:6000rpm:200, with a unit of its own"
    return {name: _read("vary", text, form, lambda text: _values(text.partition("=")[2], _quantity))}


def _values(text: str, number: Callable[[str], Any]) -> Any:
    """Values of a list, or start, stop, count and perhaps the spacing; a unit behind the last number is that of all."""
    if ":" not in text:
        return _in_units_of_the_last([number(value) for value in text.split(",") if value])
    start, stop, count, *spacing = text.split(":")
    return *_in_units_of_the_last([number(start), number(stop)]), int(count), *spacing[:1]


def _quantity(text: str) -> float | str:
    """A number, which is in SI, or a number with a unit."""
    try:
        return float(text)
    except ValueError:
        return text.strip()


def _in_units_of_the_last(values: list[Any]) -> list[Any]:
    last = values[-1] if values else None
    if not isinstance(last, str):
        return values
    unit = number_and_unit(last)[1]
    return [value if isinstance(value, str) else f"{value!r} {unit}" for value in values]


def _departure(text: str) -> tuple[float, ...]:
    time, velocity = (float(part) for part in text.split(","))
    return time, velocity


def _orbit(text: str) -> tuple[float, ...]:
    *departure, period = text.split(",") if text.count(",") == 2 else [*text.split(","), "1"]
    time, velocity = (float(part) for part in departure)
    return time, velocity, int(period)


def _departures(texts: Sequence[str]) -> Values:
    form = "write phase and speed of a departure, as in 0.6,3.77"
    return {"seeds": [_read("seed", text, form, _departure) for text in texts]}


_ORBIT = "write phase, speed and impact period, as in 0.786,1.613,2"


def _orbits(texts: Sequence[str]) -> Values:
    return {"seeds": [_read("seed", text, _ORBIT, _orbit) for text in texts]}


def _saddles(texts: Sequence[str]) -> Values:
    return {"saddles": [text if "(" in text else _read("saddle", text, _ORBIT, _orbit) for text in texts]}


def _harmonic(text: str) -> tuple[float, ...]:
    order, amplitude, phase = text.split(":") if text.count(":") > 1 else (*text.split(":"), "0")
    return int(order), float(amplitude), float(phase)


def _harmonics(texts: Sequence[str]) -> Values:
    form = "write order, amplitude and phase, as in 2:0.01:0.25; an order is a whole number"
    return {"harmonics": [_read("harmonic", text, form, _harmonic) for text in texts]}


def _setting(text: str) -> tuple[str, Any]:
    name, _, value = text.partition("=")
    kinds: dict[str, Callable[[str], Any]] = {"unit": str, "scale": float, "explained": float}
    return name, kinds[name](value)


def _measured(text: str) -> Values:
    """A measured curve. Settings are the last parts that have "=": a file's name may have commas."""
    form = "write te.csv,unit=degrees,scale=0.01,explained=0.99, or some of these"
    parts = text.split(",")
    named = next((place for place in range(len(parts), 1, -1) if "=" not in parts[place - 1]), 1)
    settings = _read("transmission-error", text, form, lambda _: dict(map(_setting, parts[named:])))
    return {"transmission_error": transmission_error(",".join(parts[:named]), **settings)}


def _followed(option: str, argument: str) -> Callable[[str], Values]:
    """Reader of a parameter to follow something in, written ``damping=0.45:0.7[:points]``."""

    def read(text: str) -> Values:
        name, _, interval = text.partition("=")
        start, stop, *points = interval.split(":")
        return {argument: {name.replace("-", "_"): (float(start), float(stop), *map(int, points[:1]))}}

    return lambda text: _read(option, text, "write damping=0.45:0.7 or damping=0.45:0.7:5000", read)


_SEVERAL, _REQUIRED = list[str] | None, inspect.Parameter.empty
_WRITTEN = {
    argument: _Written(text.option, _SEVERAL, None, text.help, text.read)
    for addition in additions()
    for argument, text in addition.text_options().items()
} | {
    "machine": _Written(
        "machine", str | None, None, "TOML file of a machine in its own units, in place of its numbers in the model",
        lambda path: {"machine": path},
    ),
    "harmonics": _Written(
        "harmonic", _SEVERAL, None, "order:amplitude[:phase] of a harmonic of the forcing: 2:0.01:0.25; several",
        _harmonics,
    ),
    "transmission_error": _Written(
        "transmission_error", str | None, None,
        "te.csv[,unit=degrees][,scale=0.01][,explained=0.99]: a measured curve in place of eccentricity and harmonics",
        _measured,
    ),
    "seeds": _Written(
        "seed", _SEVERAL, None, "Departure t,v to begin with; several; without, attractors are found", _departures
    ),
    "saddles": _Written(
        "saddle", list[str], _REQUIRED, "t,v[,period] close to a saddle, or P(1,1,0); several", _saddles
    ),
    "continuation": _Written(
        "follow", str | None, None, "damping=0.45:0.7[:points]: follow orbits in a parameter",
        _followed("follow", "continuation"),
    ),
    "curves": _Written(
        "curves", str | None, None, "eccentricity=0.05:0.15[:points]: and special points in a second one",
        _followed("curves", "curves"),
    ),
}  # fmt: skip
"""Options that are written as text, by the argument that they replace."""
_OWN = {
    "orbits": {
        "seeds": _Written("seed", _SEVERAL, None, "t,v[,period] close to an orbit; several; no search then", _orbits)
    },
    "sweep": {
        "of_harmonics": _Written(
            "vary", list[str], _REQUIRED,
            "damping=0.5,0.55,0.6 or damping=0.5:0.7:21[:geometric]; once or twice, the last fastest. Or a number of "
            "the machine: speed=600:6000rpm:200, backlash=20,35,50um",
            _swept_or_machines,
        )
    },
    "bifurcation": {
        "of_harmonics": _Written(
            "vary", str, _REQUIRED, "damping=0.5:0.6:1000[:geometric] or damping=0.5,0.55,0.6",
            lambda text: _swept([text]),
        )
    },
}  # fmt: skip
"""Those of one verb alone; ``--vary`` stands for all arguments that may have several values."""

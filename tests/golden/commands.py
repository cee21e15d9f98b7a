"""The command line: what each command takes, and its help as a terminal of 200 columns without colours shows it."""

import typing
from enum import Enum

from tests.golden.adapter import command_line


def commands():
    """Every command by its words, sub-commands as well."""
    return dict(_commands("rattle", command_line()))


def _commands(words, command):
    yield words, command
    for name in getattr(command, "commands", {}):
        _, found, _ = command.resolve_command(None, [name])
        yield from _commands(f"{words} {name}", found)


def parameters(command):
    """What a command takes, without words."""
    return [_parameter(each) for each in command.params]


def _parameter(parameter):
    """What there is to say of a parameter; an argument has a name for those who call it, an option its options."""
    told = {
        "argument": parameter.name if parameter.param_type_name == "argument" else None,
        "options": list(parameter.opts) if parameter.param_type_name == "option" else None,
        "opposites": list(parameter.secondary_opts),
        "range": [_default(getattr(parameter, end, None)) for end in ("min", "max")],
        "metavar": parameter.metavar,
        "multiple": parameter.multiple,
        "flag": getattr(parameter, "is_flag", False),
        "hidden": getattr(parameter, "hidden", False),
        "variable": parameter.envvar,
    }
    kept = {name: value for name, value in told.items() if value not in (None, False, [], [None, None])}
    return kept | {
        "type": _type(parameter.type_descriptor.annotation),
        "default": _default(parameter.default),
        "required": parameter.required,
        "nargs": parameter.nargs,
    }


def _type(annotation):
    """A type by its name, or what may be chosen: the name of an enumeration is nobody's business."""
    if isinstance(annotation, type) and issubclass(annotation, Enum):
        return [str(each.value) for each in annotation]
    inner = typing.get_args(annotation)
    if inner:
        return [typing.get_origin(annotation).__name__, *map(_type, inner)]
    return getattr(annotation, "__name__", str(annotation))


def _default(value):
    """A default as JSON; one that is computed is told as such."""
    if value is None or isinstance(value, bool | int | float):
        return value
    if isinstance(value, list | tuple):
        return [_default(each) for each in value]
    return "computed" if callable(value) else str(getattr(value, "value", value))

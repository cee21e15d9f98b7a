"""Options of the command line, made from the fields of jobs: names, types, defaults, bounds and help.

A number or a choice becomes an option of the same name. A field of parts, such as the oscillator or the grid, becomes
the options of `_GROUPS`, with the defaults and descriptions of its parts.
"""

import inspect
from collections.abc import Callable, Sequence
from enum import Enum
from typing import Annotated, Any, NamedTuple, get_args

import typer
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from service.cli.texts import continuation_of, departure_of, orbit_seed_of, saddle_of, vary_of
from worker.jobs.basin_job import SweepJob
from worker.jobs.grid_request import GridRequest
from worker.jobs.job import Job
from worker.jobs.manifold_job import ManifoldJob
from worker.jobs.orbits_job import OrbitsJob
from worker.jobs.oscillator_request import PIECEWISE_LINEAR, PiecewiseLinearOscillator
from worker.jobs.region import papers_phases, papers_speeds
from worker.jobs.sample import Sample

Values = dict[str, Any]
"""Values of a command's options, by their names as Python has them."""
_ONLY_IN_JSON = {"most_points", "kind"}


class Group(NamedTuple):
    """Options that together make one field of a request, and how they do; None leaves the field out."""

    options: tuple[inspect.Parameter, ...]
    read: Callable[[Values], Any]


def option(name: str, kind: Any, default: Any, *flags: str, **details: Any) -> inspect.Parameter:
    """Option of a command.

    Parameters
    ----------
    name : str
        Of the function's argument.
    kind : type
    default : object
        ``...`` if it must be given.
    *flags : str
        As it is written, if not after its name.
    **details
        Of `typer.Option`: help, min.

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


def job_options(job_class: type[Job]) -> list[inspect.Parameter]:
    """Options of the command for a job.

    Parameters
    ----------
    job_class : type

    Returns
    -------
    list of inspect.Parameter
    """
    return [each for group in _groups(job_class).values() for each in group.options]


def job_request(job_class: type[Job], values: Values) -> dict[str, Any]:
    """Request that options make.

    Parameters
    ----------
    job_class : type
    values : dict

    Returns
    -------
    dict
        As JSON.

    Raises
    ------
    InvalidJob
        If an option that is written as text cannot be read.
    """
    read = {name: group.read(values) for name, group in _groups(job_class).items()}
    request = {name: value for name, value in read.items() if value is not None}
    if "seeds" in request:  # nothing is searched
        request = {name: value for name, value in request.items() if name not in ("longest", "region", "cells")}
    return request


def _groups(job_class: type[Job]) -> dict[str, Group]:
    groups = {}
    for field in job_class.model_fields.values():
        name = field.alias or ""
        if name in _ONLY_IN_JSON or (issubclass(job_class, ManifoldJob) and name in ("region", "cells")):
            continue
        groups[name] = _GROUPS[name](job_class, field) if name in _GROUPS else _single(name, field)
    return groups


def _parts_of(annotation: Any) -> list[Any]:
    """The types and metadata that an annotation is made of."""
    inside = [part for each in get_args(annotation) for part in _parts_of(each)]
    return [annotation, *inside] + [part for each in getattr(annotation, "metadata", ()) for part in _parts_of(each)]


def _single(name: str, field: FieldInfo) -> Group:
    """A number or a choice."""
    parts = _parts_of(field.annotation) + list(field.metadata)
    kind = next(part for part in parts if part in (int, float) or isinstance(part, type) and issubclass(part, Enum))
    least = next((part.ge for part in parts if getattr(part, "ge", None) is not None), None)
    optional = kind if type(None) not in parts else kind | None
    return Group(
        (option(name, optional, field.default, help=field.description, min=least),), lambda values: values[name]
    )


def _of_part(model: type[BaseModel], name: str, **details: Any) -> inspect.Parameter:
    """A number, a choice or a switch that is a field of a part."""
    field = model.model_fields[name]
    flags = [f"--{name.replace('_', '-')}"]
    return option(name, field.annotation, field.default, *flags, **{"help": field.description} | details)


def _pair(name: str, kind: type, default: tuple[Any, Any], text: str) -> inspect.Parameter:
    return option(name, tuple[kind, kind], default, help=text)  # type: ignore[valid-type]


def oscillator_group(impacting_only: bool = False) -> Group:
    """Options that name an oscillator.

    Parameters
    ----------
    impacting_only : bool
        Whether only the impacting model can be computed.

    Returns
    -------
    Group
    """
    model = PiecewiseLinearOscillator
    options = [_of_part(model, name) for name in ("damping", "eccentricity", "half_backlash")]
    if not impacting_only:
        without = "kappa; without it, the impacting model"
        options.append(option("stiffness", float | None, None, help=without))
        options += [_of_part(model, name) for name in ("permanent_contact", "allow_no_quiet_solution")]

    def read(values: Values) -> dict[str, Any]:
        request = {each.name: values[each.name] for each in options[:3]}
        swept = any(text.startswith("stiffness=") for text in _texts(values.get("vary")))
        if values.get("stiffness") is None and not swept:
            return request
        request |= {"model": PIECEWISE_LINEAR} | {each.name: values[each.name] for each in options[3:]}
        return {name: value for name, value in request.items() if value is not None}

    return Group(tuple(options), read)


def _texts(values: str | list[str] | None) -> list[str]:
    return [values] if isinstance(values, str) else values or []


def _grid(job_class: type[Job], _: FieldInfo) -> Group:
    grid = GridRequest().to_grid()
    # A sweep has many basins: here it starts smaller than one of them alone.
    cells = (200, 200) if issubclass(job_class, SweepJob) else (grid.time_cells, grid.velocity_cells)
    options = (
        _pair("cells", int, cells, "Cells along time and along velocity"),
        _pair("time", float, (grid.time_start, grid.time_stop), "Window of phases"),
        _pair("velocity", float, (grid.velocity_start, grid.velocity_stop), "Window of speeds"),
    )

    def read(values: Values) -> dict[str, Any]:
        request = {name: _interval(values[name]) for name in ("time", "velocity")}
        if values["sample"] is None:
            for name, count in zip(request, values["cells"], strict=True):
                request[name]["cells"] = count
        return request

    return Group(options, read)


def _interval(ends: tuple[float, float]) -> dict[str, Any]:
    return {"start": ends[0], "stop": ends[1]}


def _sample(*_: Any) -> Group:
    options = (
        option("sample", int | None, None, "--sample", help="Start from so many points in place of cells"),
        option("seed", int, Sample(1).seed, help="Of the sample: the same seed gives the same points"),
    )

    def read(values: Values) -> dict[str, Any] | None:
        return None if values["sample"] is None else {"points": values["sample"], "seed": values["seed"]}

    return Group(options, read)


def _vary(job_class: type[Job], _: FieldInfo) -> Group:
    if issubclass(job_class, SweepJob):
        text = "damping=0.5,0.55,0.6 or damping=0.5:0.7:21[:geometric]; once or twice, the last fastest"
        options = (option("vary", list[str], ..., help=text),)
        return Group(options, lambda values: [vary_of(each) for each in values["vary"]])
    text = "damping=0.5:0.6:1000[:geometric] or damping=0.5,0.55,0.6"
    return Group((option("vary", str, ..., help=text),), lambda values: vary_of(values["vary"]))


def _seeds(job_class: type[Job], _: FieldInfo) -> Group:
    read: Callable[[str], dict[str, Any]]
    if issubclass(job_class, OrbitsJob):
        text, read = "t,v[,period] close to an orbit; several; no search then", orbit_seed_of
    else:
        text, read = "Departure t,v to begin with; several; without, attractors are found", departure_of
    options = (option("seed", list[str] | None, None, help=text),)
    return Group(options, lambda values: [read(each) for each in values["seed"] or ()] or None)


def _region(*_: Any) -> Group:
    options = (
        _pair("time", float, papers_phases().ends, "Phases of the region searched"),
        _pair("velocity", float, papers_speeds().ends, "Speeds of the region searched"),
    )
    return Group(options, lambda values: {name: _interval(values[name]) for name in ("time", "velocity")})


def _velocity(*_: Any) -> Group:
    options = (_pair("velocity", float, papers_speeds().ends, "Speeds to keep"),)
    return Group(options, lambda values: _interval(values["velocity"]))


def _saddles(*_: Any) -> Group:
    options = (option("saddle", list[str], ..., help="t,v[,period] close to a saddle, or P(1,1,0); several"),)
    return Group(options, lambda values: [saddle_of(each) for each in values["saddle"]])


def _resolution(_: type[Job], field: FieldInfo) -> Group:
    default = field.get_default(call_default_factory=True)
    options = tuple(_of_part(type(default), name) for name in ("chord", "angle"))

    def read(values: Values) -> dict[str, Any]:
        chord = values["chord"]
        return {"chord": chord, "angle": values["angle"], "finest": min(chord, default.finest)}

    return Group(options, read)


def _continuation(name: str, text: str) -> Callable[..., Group]:
    def read(values: Values) -> dict[str, Any] | None:
        return None if values[name] is None else continuation_of(values[name], name)

    return lambda *_: Group((option(name, str | None, None, help=text),), read)


_GROUPS: dict[str, Callable[[type[Job], FieldInfo], Group]] = {
    "oscillator": lambda job_class, _: oscillator_group(job_class.impacting_only),
    "grid": _grid,
    "sample": _sample,
    "vary": _vary,
    "seeds": _seeds,
    "region": _region,
    "velocity": _velocity,
    "saddles": _saddles,
    "resolution": _resolution,
    "continuation": _continuation("follow", "damping=0.45:0.7[:points]: follow orbits in a parameter"),
    "curves": _continuation("curves", "eccentricity=0.05:0.15[:points]: and special points in a second one"),
}

"""Which arguments make which field of a request: flat for the oscillator and the window, the rest as they are.

A number or a choice is an argument of the same name. A field of parts, such as the oscillator or the grid, becomes the
arguments of a `Group`. Defaults, types and descriptions are those of the job's class.
"""

from collections.abc import Callable
from enum import Enum
from numbers import Integral
from typing import Any, get_args

from pydantic.fields import FieldInfo

from rattle.argument import Argument, Group, Values, is_parameter, is_swept, of_part, plain
from rattle.oscillator_arguments import oscillator_group
from rattle_kernels.model.oscillator import PARAMETERS
from worker.errors import InvalidJob
from worker.jobs.basin_job import SweepJob
from worker.jobs.bifurcation_job import BifurcationJob
from worker.jobs.grid_request import GridRequest
from worker.jobs.job import Job
from worker.jobs.manifold_job import ManifoldJob
from worker.jobs.orbits_job import OrbitsJob
from worker.jobs.proof_request import ProofRequest
from worker.jobs.region import papers_phases, papers_speeds
from worker.jobs.sample import Sample

# Of one basin the grid's own default holds; a sweep has many, and starts smaller.
_CELLS_OF_A_SWEEP = 200
_ONLY_IN_JSON = {"most_points", "kind"}
_TOLERANCES = (
    "Of a proof: least and greatest value of parameters, as in {'damping': (0.59, 0.61)}; it holds for every machine "
    "within"
)


def groups_of(job_class: type[Job]) -> dict[str, Group]:
    """Arguments of a job by the field of the request that they make."""
    groups = {}
    for field in job_class.model_fields.values():
        name = field.alias or ""
        if name in _ONLY_IN_JSON or name in _lacks(job_class):
            continue
        groups[name] = _GROUPS[name](job_class, field) if name in _GROUPS else _single(name, field)
    return groups


def _lacks(job_class: type[Job]) -> tuple[str, ...]:
    """Fields that a job has from its base, and that it cannot use."""
    if issubclass(job_class, ManifoldJob):
        return "region", "cells"
    return ("prove",) if issubclass(job_class, SweepJob) else ()


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
    argument = Argument(name, optional, field.default, field.description or "", least)
    return Group((argument,), lambda given: given.get(name))


def _ends(value: Any, name: str) -> dict[str, Any]:
    if not (isinstance(value, list | tuple) and len(value) == 2):
        raise InvalidJob(f"{name} is a pair, from where to where, as in {name}=(0, 1), not {value!r}", (name,))
    return {"start": value[0], "stop": value[1]}


def _grid(job_class: type[Job], _: FieldInfo) -> Group:
    grid = GridRequest().to_grid()
    cells = _CELLS_OF_A_SWEEP if issubclass(job_class, SweepJob) else grid.time_cells
    arguments = (
        Argument("cells", tuple[int, int], (cells, cells), "Cells along time and along velocity"),
        Argument("time", tuple[float, float], (grid.time_start, grid.time_stop), "Window of phases"),
        Argument("velocity", tuple[float, float], (grid.velocity_start, grid.velocity_stop), "Window of speeds"),
    )

    def read(given: Values) -> dict[str, Any]:
        request = {name: _ends(given[name], name) if name in given else {} for name in ("time", "velocity")}
        if "cells" in given or given.get("sample") is None:
            counts = given.get("cells", cells)
            if isinstance(counts, Integral):
                counts = counts, counts
            if not (isinstance(counts, list | tuple) and len(counts) == 2):
                raise InvalidJob(f"cells is a number, or a pair of them, not {counts!r}", ("cells",))
            for name, count in zip(request, counts, strict=True):
                request[name]["cells"] = count
        return request

    return Group(arguments, read)


def _sample(*_: Any) -> Group:
    arguments = (
        Argument("sample", int | None, None, "Start from so many points in place of cells"),
        Argument("seed", int, Sample(1).seed, "Of the sample: the same seed gives the same points"),
        Argument("scramblings", int, Sample(1).scramblings, "Sets of points: their scatter measures the errors"),
    )

    def read(given: Values) -> dict[str, Any] | None:
        beside = {name: given[name] for name in ("seed", "scramblings") if given.get(name) is not None}
        if given.get("sample") is None:
            for name in beside:
                raise InvalidJob(f"{name} belongs to a sample: give its points, as in sample=4096 (--sample)", (name,))
            return None
        return {"points": given["sample"]} | beside

    return Group(arguments, read)


def _prove(_: type[Job], field: FieldInfo) -> Group:
    levels = ProofRequest.model_fields["levels"]
    arguments = (
        Argument("prove", bool, False, field.description or ""),
        Argument("levels", int, levels.default, f"Of a proof: {levels.description}", 0),
        Argument("tolerances", dict[str, tuple[float, float]] | None, None, _TOLERANCES),
    )

    def read(given: Values) -> Any:
        beside = {name: given[name] for name in ("levels", "tolerances") if given.get(name) is not None}
        if given.get("prove", False) is False:
            for name in beside:
                raise InvalidJob(f"{name} belongs to a proof: give prove=True (--prove)", (name,))
            return None
        return beside if given["prove"] is True else given["prove"]

    return Group(arguments, read)


def _spaced_or_listed(parameter: str, value: Any) -> dict[str, Any]:
    """Values of a parameter: those of a list or an array, or (start, stop, count[, spacing])."""
    if isinstance(value, dict):
        return {"parameter": parameter} | value
    if isinstance(value, list):
        return {"parameter": parameter, "values": value}
    if not 3 <= len(value) <= 4:
        raise InvalidJob(
            f"values of {parameter} are a list or an array, or (start, stop, count), not {value!r}", (parameter,)
        )
    return {"parameter": parameter} | dict(zip(("start", "stop", "count", "spacing"), value, strict=False))


def _vary(job_class: type[Job], _: FieldInfo) -> Group:
    several = issubclass(job_class, SweepJob)

    def read(given: Values) -> Any:
        swept = [
            _spaced_or_listed(name, value) for name, value in given.items() if is_parameter(name) and is_swept(value)
        ]
        if not swept or (len(swept) > 1 and not several):
            most = "one or two of" if several else "one of"
            raise InvalidJob(
                f"give several values of {most} {', '.join(PARAMETERS)}: a list or an array, or (start, stop, count)"
            )
        return swept if several else swept[0]

    return Group((), read)


def _seeds(job_class: type[Job], _: FieldInfo) -> Group:
    with_period = issubclass(job_class, OrbitsJob)
    of_orbits = "(t, v) or (t, v, period) close to an orbit; several; no search then"
    text = of_orbits if with_period else "Departures (t, v) to begin with; without them, attractors are found"
    argument = Argument("seeds", list[tuple[float, ...]] | None, None, text)

    def read(given: Values) -> list[dict[str, Any]] | None:
        return [_seed(each, "seeds", with_period) for each in _listed(given.get("seeds"))] or None

    return Group((argument,), read)


def _listed(value: Any) -> list[Any]:
    """The values of an argument that takes several; one is a list of itself."""
    if value is None:
        return []
    return list(value) if isinstance(value, list | tuple) else [value]


def _seed(value: Any, name: str, with_period: bool) -> Any:
    if isinstance(value, dict):  # as in a request
        return value
    fields = ("time", "velocity", "period")[: 3 if with_period else 2]
    if not (isinstance(value, list | tuple) and 2 <= len(value) <= len(fields)):
        raise InvalidJob(f"{name} are a list of departures ({', '.join(fields)}), not {value!r}", (name,))
    return {name: plain(part) for name, part in zip(fields, value, strict=False)}


def _region(*_: Any) -> Group:
    arguments = (
        Argument("time", tuple[float, float], papers_phases().ends, "Phases of the region searched"),
        Argument("velocity", tuple[float, float], papers_speeds().ends, "Speeds of the region searched"),
    )

    def read(given: Values) -> dict[str, Any] | None:
        return {name: _ends(given[name], name) for name in ("time", "velocity") if name in given} or None

    return Group(arguments, read)


def _velocity(*_: Any) -> Group:
    argument = Argument("velocity", tuple[float, float], papers_speeds().ends, "Speeds to keep")
    return Group((argument,), lambda given: _ends(given["velocity"], "velocity") if "velocity" in given else None)


def _saddles(*_: Any) -> Group:
    argument = Argument("saddles", list[Any], ..., "(t, v) or (t, v, period) close to a saddle, or P(1,1,0); several")

    def read(given: Values) -> list[Any]:
        return [
            {"itinerary": each} if isinstance(each, str) else _seed(each, "saddles", True)
            for each in _listed(given["saddles"])
        ]

    return Group((argument,), read)


def _resolution(_: type[Job], field: FieldInfo) -> Group:
    default: Any = field.get_default(call_default_factory=True)
    arguments = tuple(of_part(type(default), name) for name in ("chord", "angle"))

    def read(given: Values) -> dict[str, Any] | None:
        request = {name: given[name] for name in ("chord", "angle") if name in given}
        if "chord" in request:
            request["finest"] = min(request["chord"], default.finest)
        return request or None

    return Group(arguments, read)


def _continuation(name: str, text: str) -> Callable[..., Group]:
    def read(given: Values) -> Any:
        value = given.get(name)
        if value is None or (isinstance(value, dict) and "parameter" in value):
            return value
        if not (isinstance(value, dict) and len(value) == 1):
            raise InvalidJob(f'{name} is written as in {{"damping": (0.45, 0.7)}}, not {value!r}', (name,))
        ((parameter, interval),) = value.items()
        if not (isinstance(interval, list | tuple) and 2 <= len(interval) <= 3):
            raise InvalidJob(f"{parameter} is followed between two values, as in (0.45, 0.7)", (name,))
        return {"parameter": parameter} | dict(zip(("start", "stop", "most_points"), interval, strict=False))

    return lambda *_: Group((Argument(name, dict[str, tuple[float, float]] | None, None, text),), read)


_GROUPS: dict[str, Callable[[type[Job], FieldInfo], Group]] = {
    "oscillator": lambda job_class, _: oscillator_group(
        job_class.impacting_only, issubclass(job_class, SweepJob | BifurcationJob)
    ),
    "grid": _grid,
    "sample": _sample,
    "prove": _prove,
    "vary": _vary,
    "seeds": _seeds,
    "region": _region,
    "velocity": _velocity,
    "saddles": _saddles,
    "resolution": _resolution,
    "continuation": _continuation("continuation", '{"damping": (0.45, 0.7)}: follow orbits in a parameter'),
    "curves": _continuation("curves", '{"eccentricity": (0.05, 0.15)}: and special points in a second one'),
}

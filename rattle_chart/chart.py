"""A chart as a function: `rattle.chart`."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import rattle
from rattle_chart.job import ChartJob
from worker.errors import InvalidJob
from worker.jobs.oscillator_request import PIECEWISE_LINEAR

if TYPE_CHECKING:
    import xarray as xr

    from worker.progress import Report

    # A value, or from where to where.
    Span = float | tuple[float, float]


def chart(
    *,
    damping: "Span" = 0.6,
    eccentricity: "Span" = 0.1,
    half_backlash: "Span" = 0.6,
    stiffness: "Span | None" = None,
    restitution: "Span | None" = None,
    contact_damping: "Span | None" = None,
    harmonics: Sequence[Sequence[float]] = (),
    longest: int = 2,
    lines: int = 3,
    time: tuple[float, float] = (0.0, 1.0),
    velocity: tuple[float, float] = (0.0, 7.0),
    cells: int = 16,
    pixels: int = 40,
    departures: int = 16,
    store: str | Path | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: "bool | Report" = True,
) -> "xr.Dataset":
    """Chart two parameters: curves of special points, points of codimension two, and what machines do.

    Two of the oscillator's numbers are pairs, from where to where. The first of them, in the order of the arguments
    below, lies along the chart, the other one up it.

    Parameters
    ----------
    damping, eccentricity, half_backlash : float or (float, float)
    stiffness, restitution, contact_damping : float or (float, float), optional
        Without a stiffness the model is the impacting one, with restitution 1 unless it is given.
    harmonics : sequence of tuples
        (order, amplitude, phase) of each harmonic of the forcing beside the first.
    longest : int
        Greatest n+ of the orbits that are searched for.
    lines : int
        Orbits are followed along so many lines each way. A curve that crosses none of them is missed.
    time, velocity : (float, float)
        Departures among which orbits are searched for.
    cells : int
        The search starts from the centres of so many cells each way.
    pixels : int
        So many machines each way have a quiet share and an exponent; 0 for none.
    departures : int
        Of each of them, so many each way.
    store : str or path, optional
        Where the result lies; by default in `rattle.cache`.
    workers : int, optional
        Threads; by default one for each core.
    scheduler : str, optional
        Address of a Dask scheduler, in place of threads.
    progress : bool or callable
        Whether progress is shown; or a function, called with each `Progress`.

    Returns
    -------
    xarray.Dataset
        Curves along ``curve`` and ``curve_point``, points of codimension two along ``point``, ``quiet_share`` and
        ``exponent`` over the two parameters. Its accessor ``.rattle`` draws it.

    Raises
    ------
    InvalidJob, OutsideDomain
        If a value is wrong. Both are a ValueError.

    Examples
    --------
    >>> import rattle
    >>> found = rattle.chart(damping=(0.75, 0.78), eccentricity=(0.094, 0.0995), lines=2, pixels=0, progress=False)
    >>> found.point_damping.values.round(6).tolist()
    [0.770147, 0.760165]
    """
    numbers: dict[str, Any] = {
        "damping": damping, "eccentricity": eccentricity, "half_backlash": half_backlash, "stiffness": stiffness,
        "restitution": restitution, "contact_damping": contact_damping,
    }  # fmt: skip
    job = job_of(
        numbers, harmonics, longest=longest, lines=lines, cells=cells, pixels=pixels, departures=departures,
        region={"time": _span("time", time), "velocity": _span("velocity", velocity)},
    )  # fmt: skip
    return rattle.compute(job, store=store, workers=workers, scheduler=scheduler, progress=progress)


def job_of(numbers: dict[str, Any], harmonics: Sequence[Sequence[float]], **fields: Any) -> ChartJob:
    """Job of a chart.

    Parameters
    ----------
    numbers : dict
        Of the oscillator; two of them are pairs, and None stands for those that are not given.
    harmonics : sequence of tuples
    **fields
        Of the job.

    Returns
    -------
    ChartJob

    Raises
    ------
    InvalidJob, OutsideDomain
    """
    given = {name: value for name, value in numbers.items() if value is not None}
    pairs = {name: value for name, value in given.items() if isinstance(value, tuple | list)}
    if len(pairs) != 2:
        which = " and ".join(pairs) or "none"
        raise InvalidJob(f"a chart has two parameters from where to where, as in damping=(0.75, 0.78), not {which}")
    axes = [{"parameter": name} | _span(name, value) for name, value in pairs.items()]
    oscillator = {name: value for name, value in given.items() if name not in pairs}
    if "stiffness" in given:
        oscillator["model"] = PIECEWISE_LINEAR
        oscillator.setdefault("stiffness", pairs.get("stiffness", (0.0,))[0])
    if harmonics:
        names = "order", "amplitude", "phase"
        oscillator["harmonics"] = [dict(zip(names, each, strict=False)) for each in harmonics]
    return ChartJob(oscillator=oscillator, first=axes[0], second=axes[1], **fields)


def _span(name: str, value: Sequence[float]) -> dict[str, float]:
    if len(value) != 2:
        raise InvalidJob(f"{name} is a pair, from where to where, not {value!r}", (name,))
    return {"start": value[0], "stop": value[1]}

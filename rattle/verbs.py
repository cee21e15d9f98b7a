"""The verbs: what is computed here, in threads of this process.

The shell's commands and the verbs of a connected service come from these functions. What they call is imported within
them: ``import rattle`` loads neither Numba nor Dask, Zarr or xarray.
"""

import functools
import inspect
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, ParamSpec

from rattle.garbage import fewer_collections

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from rich.console import Console

    from rattle_kernels import Oscillator, TransmissionError
    from worker.gear_pair import GearPair
    from worker.jobs.job import Job
    from worker.progress import Report

    # A value, or several: a list or an array of them, or (start, stop, count[, spacing]).
    Swept = float | Sequence[float] | np.ndarray | tuple[float, float, int, str]
    # Several numbers of a machine, in SI or with their units.
    SweptQuantity = Sequence[float | str] | np.ndarray | tuple[float | str, float | str, int, str]

_P = ParamSpec("_P")
_LARGE_SECONDS = 60.0
_WHERE = ("store", "workers", "scheduler", "progress")


@fewer_collections()
def compute(
    job: "Job",
    *,
    store: str | Path | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: "bool | Report" = True,
) -> "xr.Dataset":
    """Compute a job here, or open its result if it is there already.

    Parameters
    ----------
    job : Job
        A `rattle.BasinJob`, or one of another kind.
    store : str or path, optional
        Where the result lies: a folder, or ``s3://bucket/prefix``. By default in `rattle.cache`.
    workers : int, optional
        Threads; by default one for each core.
    scheduler : str, optional
        Address of a Dask scheduler, in place of threads.
    progress : bool or callable
        Whether progress is shown on a terminal and in a notebook. Or a function that is called with each `Progress`,
        in another thread; an exception that it raises stops the work.

    Returns
    -------
    xarray.Dataset

    Raises
    ------
    InvalidJob
        If its machine has another oscillator than the job.
    JobCancelled
        If it was interrupted. The same call goes on from what is in the store.
    StoreConflict
        If the store is another request's.
    StoreFailed, TileFailed, ClusterFailed, NotFound

    Examples
    --------
    >>> import rattle
    >>> job = rattle.BasinJob(grid={"time": {"cells": 20}, "velocity": {"cells": 20}}, iterations=101)
    >>> rattle.compute(job, progress=False).rattle.complete
    True
    """
    from rattle.results.cache import cache
    from rattle.results.opening import open
    from worker.stores.opening import is_complete

    if job.machine_ is not None:
        from worker.machine_series import settled_with_machine

        job = settled_with_machine(job)
    location = cache.location_of(job) if store is None else str(store)
    if workers is not None and workers < 1:
        raise ValueError(f"workers must be 1 or more, not {workers}")
    if not is_complete(location, job.digest):
        from rattle.local import run_here  # loads tasks, which a result that is kept does without
        from rattle.progress import console_for, progress_line
        from worker.kinds import KINDS

        where: dict[str, Any] = {"workers": workers, "scheduler": scheduler}
        if callable(progress):
            run_here(job, location, progress, **where)
        else:
            console = console_for(progress)
            if not console.quiet:
                _announce(job, workers, console)
            with progress_line(console, KINDS[job.kind].unit) as line:
                run_here(job, location, line.report, compiling=line.compiling, **where)
    return open(location)


def _announce(job: "Job", workers: int | None, console: "Console") -> None:
    """Say what large work takes, before it begins."""
    from rattle.local import usable_cores
    from worker.estimate import estimate

    expected = estimate(job, workers or usable_cores())
    if expected.seconds > _LARGE_SECONDS:
        console.print(f"this takes {expected}", highlight=False)


class _Numbered(NamedTuple):
    """A value of an argument, and its number among those of the call."""

    number: int
    value: Any


def _in_order(verb: "Callable[_P, xr.Dataset]") -> "Callable[_P, xr.Dataset]":
    """Number the arguments of a call: of two swept parameters the one that is written last runs fastest."""

    @functools.wraps(verb)
    def call(*args: _P.args, **kwargs: _P.kwargs) -> "xr.Dataset":
        numbered: Any = {name: _Numbered(number, value) for number, (name, value) in enumerate(kwargs.items())}
        return verb(*args, **numbered)

    return call


def given_of(verb: Callable[..., Any], arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of a call that say something: one with its default value, or None, says nothing.

    Parameters
    ----------
    verb : callable
        One of this module.
    arguments : mapping
        Values by name, of all arguments or of some.

    Returns
    -------
    dict

    Raises
    ------
    TypeError
        If one is no argument of the verb, nor a number of a harmonic where these can be swept.
    """
    from worker.jobs.swept_parameter import is_of_harmonic

    parameters = inspect.signature(verb).parameters
    for name in arguments:
        if name not in parameters and not is_of_harmonic(name):
            raise TypeError(f"{verb.__name__}() got an unexpected keyword argument {name!r}")
    defaults = {name: each.default for name, each in parameters.items()}
    return {
        name: value for name, value in arguments.items() if value is not None and _differs(value, defaults.get(name))
    }


def _differs(value: Any, default: Any) -> bool:
    """Whether a value is another than the default; an array always is."""
    return getattr(value, "shape", ()) != () or bool(value != default)


@fewer_collections()
def _computed(kind: str, arguments: dict[str, Any]) -> "xr.Dataset":
    """Compute the job that the arguments of a verb describe, or open its result."""
    from rattle.arguments import job_of

    arguments |= arguments.pop("of_harmonics", {})
    written = {name: each for name, each in arguments.items() if isinstance(each, _Numbered)}
    for name in sorted(written, key=lambda name: written[name].number):
        del arguments[name]
        arguments[name] = written[name].value
    where = {name: arguments.pop(name) for name in _WHERE}
    return compute(job_of(kind, given_of(VERBS[kind], arguments)), **where)


def basin(
    machine: "GearPair | str | Path | None" = None,
    *,
    damping: float | tuple[float, float] = 0.6,
    eccentricity: float | tuple[float, float] | None = None,
    half_backlash: float | tuple[float, float] = 0.6,
    stiffness: float | tuple[float, float] | None = None,
    harmonics: Sequence[Sequence[float]] | None = None,
    transmission_error: "TransmissionError | str | Path | None" = None,
    restitution: float | tuple[float, float] = 1.0,
    contact_damping: float | tuple[float, float] = 0.0,
    permanent_contact: Literal["envelope", "one_rotation"] = "envelope",
    allow_no_quiet_solution: bool = False,
    cells: int | tuple[int, int] = 1000,
    time: tuple[float, float] = (0.0, 1.0),
    velocity: tuple[float, float] = (0.0, 7.0),
    iterations: int | None = None,
    sample: int | None = None,
    seed: int = 0,
    scramblings: int = 1,
    prove: bool = False,
    levels: int = 3,
    tolerances: Mapping[str, tuple[float, float]] | None = None,
    store: str | Path | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: "bool | Report" = True,
) -> "xr.Dataset":
    """Compute a basin of attraction: which motion each departure ends in.

    Times count forcing periods; everything else is nondimensional, unless a machine is given.

    Parameters
    ----------
    machine : GearPair, str or path, optional
        A machine in its own units, or a TOML file of it, in place of its numbers in the model. The result then has SI
        units as well, and the window follows the machine
    damping : float or (float, float), default 0.6
        delta
    eccentricity : float or (float, float), optional
        epsilon, amplitude of the first harmonic; 0.1 without a measured curve
    half_backlash : float or (float, float), default 0.6
        beta
    stiffness : float or (float, float), optional
        kappa, finite and above damping^2/8; without it, the impacting model
    harmonics : sequence of tuples, optional
        (order, amplitude, phase) of each harmonic of the forcing beside the first; phases count periods of the
        harmonic
    transmission_error : TransmissionError, str or path, optional
        A measured curve in place of eccentricity and harmonics: what `rattle.transmission_error` returns, or a CSV file
        of angle (in turns) and error
    restitution : float or (float, float), default 1.0
        r, by which an impact multiplies the speed; 1 is elastic
    contact_damping : float or (float, float), default 0.0
        zeta, damping of the ringing in contact; 1 is critical
    permanent_contact : {"envelope", "one_rotation"}, default envelope
        When a contact counts as permanent: exactly, or by the paper's rule
    allow_no_quiet_solution : bool, default False
        Accept an eccentricity beyond the bound of Eq. (3), where no quiet solution exists
    cells : int or (int, int), default 1000
        Cells along time and along velocity
    time : (float, float), default (0.0, 1.0)
        Window of phases
    velocity : (float, float), default (0.0, 7.0)
        Window of speeds
    iterations : int, optional
        k of P_corr o P^k: 1 or a prime. By default 1499 where the least damping is 0.5 or more, else the first prime
        from 900/damping
    sample : int, optional
        Start from so many points in place of cells
    seed : int, default 0
        Of the sample: the same seed gives the same points
    scramblings : int, default 1
        Sets of points: their scatter measures the errors
    prove : bool, default False
        Prove of each cell that every departure in it ends as the cell is coloured: true, or how
    levels : int, default 3
        Of a proof: how often a cell that is not proven whole may be cut into four
    tolerances : dict, optional
        Of a proof: least and greatest value of parameters, as in {'damping': (0.59, 0.61)}; it holds for every machine
        within. A parameter that is a pair says the same of itself
    store : str or path, optional
        Where the result lies; by default in `rattle.cache`
    workers : int, optional
        Threads; by default one for each core
    scheduler : str, optional
        Address of a Dask scheduler, in place of threads
    progress : bool or callable, default True
        Whether progress is shown on a terminal and in a notebook; or a function, called with each `Progress`

    Returns
    -------
    xarray.Dataset
        Cells over ``velocity`` and ``time``: ``solution``, Hsu's ``group``, ``period`` and ``step``, landing
        points; and the motions along ``attractor``, each with its ``share``. Its accessor ``.rattle`` draws and
        measures it.

    Raises
    ------
    TypeError
        If an argument is unknown or missing.
    ValueError
        If a value is wrong; the message says what would be right.

    Examples
    --------
    >>> import rattle
    >>> basin = rattle.basin(damping=0.6, eccentricity=0.1, half_backlash=0.6, cells=20, progress=False)
    >>> basin.rattle.to_table()['name'].tolist()
    ['permanent contact', 'P(1,1,0)', 'chaotic']
    """
    return _computed("basin", locals())


@_in_order
def sweep(
    machine: "GearPair | str | Path | None" = None,
    *,
    damping: "Swept" = 0.6,
    eccentricity: "Swept | None" = None,
    half_backlash: "Swept" = 0.6,
    stiffness: "Swept | None" = None,
    harmonics: Sequence[Sequence[float]] | None = None,
    transmission_error: "TransmissionError | str | Path | None" = None,
    restitution: "Swept" = 1.0,
    contact_damping: "Swept" = 0.0,
    permanent_contact: Literal["envelope", "one_rotation"] = "envelope",
    allow_no_quiet_solution: bool = False,
    cells: int | tuple[int, int] = 200,
    time: tuple[float, float] = (0.0, 1.0),
    velocity: tuple[float, float] = (0.0, 7.0),
    iterations: int | None = None,
    sample: int | None = None,
    seed: int = 0,
    scramblings: int = 1,
    store: str | Path | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: "bool | Report" = True,
    speed: "SweptQuantity | None" = None,
    inertia: "SweptQuantity | None" = None,
    inertia_ratio: "SweptQuantity | None" = None,
    drag_torque: "SweptQuantity | None" = None,
    base_radius: "SweptQuantity | None" = None,
    backlash: "SweptQuantity | None" = None,
    mesh_stiffness: "SweptQuantity | None" = None,
    machines: "Sequence[GearPair] | Sequence[Oscillator] | None" = None,
    **of_harmonics: "Swept",
) -> "xr.Dataset":
    """Compute basins over one or two parameters, or over a number of a machine.

    A list or an array is swept, or (start, stop, count).

    Times count forcing periods; everything else is nondimensional, unless a machine is given.

    Parameters
    ----------
    machine : GearPair, str or path, optional
        A machine in its own units, or a TOML file of it, in place of its numbers in the model. The result then has SI
        units as well, and the window follows the machine
    damping : float or several, default 0.6
        delta
    eccentricity : float or several, optional
        epsilon, amplitude of the first harmonic; 0.1 without a measured curve
    half_backlash : float or several, default 0.6
        beta
    stiffness : float or several, optional
        kappa, finite and above damping^2/8; without it, the impacting model
    harmonics : sequence of tuples, optional
        (order, amplitude, phase) of each harmonic of the forcing beside the first; phases count periods of the
        harmonic
    transmission_error : TransmissionError, str or path, optional
        A measured curve in place of eccentricity and harmonics: what `rattle.transmission_error` returns, or a CSV file
        of angle (in turns) and error
    restitution : float or several, default 1.0
        r, by which an impact multiplies the speed; 1 is elastic
    contact_damping : float or several, default 0.0
        zeta, damping of the ringing in contact; 1 is critical
    permanent_contact : {"envelope", "one_rotation"}, default envelope
        When a contact counts as permanent: exactly, or by the paper's rule
    allow_no_quiet_solution : bool, default False
        Accept an eccentricity beyond the bound of Eq. (3), where no quiet solution exists
    cells : int or (int, int), default 200
        Cells along time and along velocity
    time : (float, float), default (0.0, 1.0)
        Window of phases
    velocity : (float, float), default (0.0, 7.0)
        Window of speeds
    iterations : int, optional
        k of P_corr o P^k: 1 or a prime. By default 1499 where the least damping is 0.5 or more, else the first prime
        from 900/damping
    sample : int, optional
        Start from so many points in place of cells
    seed : int, default 0
        Of the sample: the same seed gives the same points
    scramblings : int, default 1
        Sets of points: their scatter measures the errors
    store : str or path, optional
        Where the result lies; by default in `rattle.cache`
    workers : int, optional
        Threads; by default one for each core
    scheduler : str, optional
        Address of a Dask scheduler, in place of threads
    progress : bool or callable, default True
        Whether progress is shown on a terminal and in a notebook; or a function, called with each `Progress`
    speed : several, optional
        Of a machine, each a number in SI or a text with its unit: ("600 rpm", "6000 rpm", 200). All numbers of the
        model move with it. This is no run-up from rest: each machine runs at its own speed for ever
    inertia : several, optional
        Of a machine, its driven shaft
    inertia_ratio : several, optional
        Of a machine
    drag_torque : several, optional
        Of a machine, at its speed
    base_radius : several, optional
        Of a machine, its driven gear
    backlash : several, optional
        Of a machine
    mesh_stiffness : several, optional
        Of a machine
    machines : sequence of GearPair or of Oscillator, optional
        Machines one after the other, which may differ in everything but the model; their number is the coordinate
    **of_harmonics : several values
        Of ``amplitude_2`` or ``phase_2``: sweep the harmonic of order 2 of ``harmonics``; so for other orders

    Returns
    -------
    xarray.Dataset
        As of a basin, with a leading dimension for each swept parameter in the order of the arguments; births
        and deaths of motions along ``change``. Its accessor ``.rattle`` draws and measures it.

    Raises
    ------
    TypeError
        If an argument is unknown or missing.
    ValueError
        If a value is wrong; the message says what would be right.

    Examples
    --------
    >>> import rattle
    >>> sweep = rattle.sweep(damping=[0.6, 0.7], eccentricity=0.1, half_backlash=0.6, cells=16, progress=False)
    >>> sweep.share.sel(damping=0.7).values[0].round(2).item()
    1.0
    """
    return _computed("sweep", locals())


def bifurcation(
    machine: "GearPair | str | Path | None" = None,
    *,
    damping: "Swept" = 0.6,
    eccentricity: "Swept | None" = None,
    half_backlash: "Swept" = 0.6,
    stiffness: "Swept | None" = None,
    harmonics: Sequence[Sequence[float]] | None = None,
    transmission_error: "TransmissionError | str | Path | None" = None,
    restitution: "Swept" = 1.0,
    contact_damping: "Swept" = 0.0,
    permanent_contact: Literal["envelope", "one_rotation"] = "envelope",
    allow_no_quiet_solution: bool = False,
    seeds: Sequence[Sequence[float]] | None = None,
    time: tuple[float, float] = (0.0, 1.0),
    velocity: tuple[float, float] = (0.0, 7.0),
    direction: Literal["up", "down", "both"] = "up",
    transient: int = 1000,
    kept: int = 20,
    store: str | Path | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: "bool | Report" = True,
    **of_harmonics: "Swept",
) -> "xr.Dataset":
    """Compute a bifurcation diagram over the parameter that has several values.

    Times count forcing periods; everything else is nondimensional, unless a machine is given.

    Parameters
    ----------
    machine : GearPair, str or path, optional
        A machine in its own units, or a TOML file of it, in place of its numbers in the model. The result then has SI
        units as well, and the window follows the machine
    damping : float or several, default 0.6
        delta
    eccentricity : float or several, optional
        epsilon, amplitude of the first harmonic; 0.1 without a measured curve
    half_backlash : float or several, default 0.6
        beta
    stiffness : float or several, optional
        kappa, finite and above damping^2/8; without it, the impacting model
    harmonics : sequence of tuples, optional
        (order, amplitude, phase) of each harmonic of the forcing beside the first; phases count periods of the
        harmonic
    transmission_error : TransmissionError, str or path, optional
        A measured curve in place of eccentricity and harmonics: what `rattle.transmission_error` returns, or a CSV file
        of angle (in turns) and error
    restitution : float or several, default 1.0
        r, by which an impact multiplies the speed; 1 is elastic
    contact_damping : float or several, default 0.0
        zeta, damping of the ringing in contact; 1 is critical
    permanent_contact : {"envelope", "one_rotation"}, default envelope
        When a contact counts as permanent: exactly, or by the paper's rule
    allow_no_quiet_solution : bool, default False
        Accept an eccentricity beyond the bound of Eq. (3), where no quiet solution exists
    seeds : sequence of tuples, optional
        Departures (t, v) to begin with; without them, attractors are found
    time : (float, float), default (0.0, 1.0)
        Phases of the region searched
    velocity : (float, float), default (0.0, 7.0)
        Speeds of the region searched
    direction : {"up", "down", "both"}, default up
        both: up and then, from where that ends, down again
    transient : int, default 1000
        Impacts at each value before any departure is kept
    kept : int, default 20
        Departures kept at each value
    store : str or path, optional
        Where the result lies; by default in `rattle.cache`
    workers : int, optional
        Threads; by default one for each core
    scheduler : str, optional
        Address of a Dask scheduler, in place of threads
    progress : bool or callable, default True
        Whether progress is shown on a terminal and in a notebook; or a function, called with each `Progress`
    **of_harmonics : several values
        Of ``amplitude_2`` or ``phase_2``: sweep the harmonic of order 2 of ``harmonics``; so for other orders

    Returns
    -------
    xarray.Dataset
        Last departures ``time`` and ``velocity`` at each value, of each seed.
        Its accessor ``.rattle`` draws and measures it.

    Raises
    ------
    TypeError
        If an argument is unknown or missing.
    ValueError
        If a value is wrong; the message says what would be right.

    Examples
    --------
    >>> import rattle
    >>> diagram = rattle.bifurcation(damping=(0.5, 0.6, 5), seeds=[(0.7641, 4.0002)], progress=False)
    >>> diagram.impact_period.values.ravel().tolist()[0]
    3
    """
    return _computed("bifurcation", locals())


def orbits(
    machine: "GearPair | str | Path | None" = None,
    *,
    damping: float = 0.6,
    eccentricity: float | None = None,
    half_backlash: float = 0.6,
    stiffness: float | None = None,
    harmonics: Sequence[Sequence[float]] | None = None,
    transmission_error: "TransmissionError | str | Path | None" = None,
    restitution: float = 1.0,
    contact_damping: float = 0.0,
    permanent_contact: Literal["envelope", "one_rotation"] = "envelope",
    allow_no_quiet_solution: bool = False,
    longest: int = 4,
    time: tuple[float, float] = (0.0, 1.0),
    velocity: tuple[float, float] = (0.0, 7.0),
    cells: int = 40,
    seeds: Sequence[Sequence[float]] | None = None,
    continuation: Mapping[str, Sequence[float]] | None = None,
    curves: Mapping[str, Sequence[float]] | None = None,
    store: str | Path | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: "bool | Report" = True,
) -> "xr.Dataset":
    """Find periodic orbits, stable or not; follow them in a parameter and locate special points.

    Times count forcing periods; everything else is nondimensional, unless a machine is given.

    Parameters
    ----------
    machine : GearPair, str or path, optional
        A machine in its own units, or a TOML file of it, in place of its numbers in the model. The result then has SI
        units as well, and the window follows the machine
    damping : float, default 0.6
        delta
    eccentricity : float, optional
        epsilon, amplitude of the first harmonic; 0.1 without a measured curve
    half_backlash : float, default 0.6
        beta
    stiffness : float, optional
        kappa, finite and above damping^2/8; without it, the impacting model
    harmonics : sequence of tuples, optional
        (order, amplitude, phase) of each harmonic of the forcing beside the first; phases count periods of the
        harmonic
    transmission_error : TransmissionError, str or path, optional
        A measured curve in place of eccentricity and harmonics: what `rattle.transmission_error` returns, or a CSV file
        of angle (in turns) and error
    restitution : float, default 1.0
        r, by which an impact multiplies the speed; 1 is elastic
    contact_damping : float, default 0.0
        zeta, damping of the ringing in contact; 1 is critical
    permanent_contact : {"envelope", "one_rotation"}, default envelope
        When a contact counts as permanent: exactly, or by the paper's rule
    allow_no_quiet_solution : bool, default False
        Accept an eccentricity beyond the bound of Eq. (3), where no quiet solution exists
    longest : int, default 4
        Greatest n+ that is searched for
    time : (float, float), default (0.0, 1.0)
        Phases of the region searched
    velocity : (float, float), default (0.0, 7.0)
        Speeds of the region searched
    cells : int, default 40
        The search starts from the centres of so many cells each way
    seeds : sequence of tuples, optional
        (t, v) or (t, v, period) close to an orbit; several; no search then
    continuation : dict, optional
        {"damping": (0.45, 0.7)}: follow orbits in a parameter
    curves : dict, optional
        {"eccentricity": (0.05, 0.15)}: and special points in a second one
    store : str or path, optional
        Where the result lies; by default in `rattle.cache`
    workers : int, optional
        Threads; by default one for each core
    scheduler : str, optional
        Address of a Dask scheduler, in place of threads
    progress : bool or callable, default True
        Whether progress is shown on a terminal and in a notebook; or a function, called with each `Progress`

    Returns
    -------
    xarray.Dataset
        Orbits along ``orbit``; branches and special points, if they are followed.
        Its accessor ``.rattle`` draws and measures it.

    Raises
    ------
    TypeError
        If an argument is unknown or missing.
    ValueError
        If a value is wrong; the message says what would be right.

    Examples
    --------
    >>> import rattle
    >>> found = rattle.orbits(damping=0.6, longest=1, cells=8, progress=False)
    >>> 'P(1,1,0)' in found.name.values
    True
    """
    return _computed("orbits", locals())


def manifolds(
    machine: "GearPair | str | Path | None" = None,
    *,
    damping: float = 0.6,
    eccentricity: float | None = None,
    half_backlash: float = 0.6,
    harmonics: Sequence[Sequence[float]] | None = None,
    transmission_error: "TransmissionError | str | Path | None" = None,
    restitution: float = 1.0,
    saddles: Sequence[str | Sequence[float]],
    side: Literal["stable", "unstable", "both"] = "stable",
    arclength: float = 20.0,
    velocity: tuple[float, float] = (0.0, 7.0),
    chord: float = 0.01,
    angle: float = 0.2,
    store: str | Path | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: "bool | Report" = True,
) -> "xr.Dataset":
    """Grow stable and unstable manifolds of saddles of the impacting model.

    Times count forcing periods; everything else is nondimensional, unless a machine is given.

    Parameters
    ----------
    machine : GearPair, str or path, optional
        A machine in its own units, or a TOML file of it, in place of its numbers in the model. The result then has SI
        units as well, and the window follows the machine
    damping : float, default 0.6
        delta
    eccentricity : float, optional
        epsilon, amplitude of the first harmonic; 0.1 without a measured curve
    half_backlash : float, default 0.6
        beta
    harmonics : sequence of tuples, optional
        (order, amplitude, phase) of each harmonic of the forcing beside the first; phases count periods of the
        harmonic
    transmission_error : TransmissionError, str or path, optional
        A measured curve in place of eccentricity and harmonics: what `rattle.transmission_error` returns, or a CSV file
        of angle (in turns) and error
    restitution : float, default 1.0
        r, by which an impact multiplies the speed; 1 is elastic
    saddles : sequence
        (t, v) or (t, v, period) close to a saddle, or P(1,1,0); several
    side : {"stable", "unstable", "both"}, default stable
        Which manifolds
    arclength : float, default 20.0
        Of each branch, within the window of speeds
    velocity : (float, float), default (0.0, 7.0)
        Speeds to keep
    chord : float, default 0.01
        Longest distance between neighbouring points
    angle : float, default 0.2
        Largest angle between chords, radians
    store : str or path, optional
        Where the result lies; by default in `rattle.cache`
    workers : int, optional
        Threads; by default one for each core
    scheduler : str, optional
        Address of a Dask scheduler, in place of threads
    progress : bool or callable, default True
        Whether progress is shown on a terminal and in a notebook; or a function, called with each `Progress`

    Returns
    -------
    xarray.Dataset
        Saddles along ``orbit``, branches along ``branch``, their curves piece by piece.
        Its accessor ``.rattle`` draws and measures it.

    Raises
    ------
    TypeError
        If an argument is unknown or missing.
    ValueError
        If a value is wrong; the message says what would be right.

    Examples
    --------
    >>> import rattle
    >>> grown = rattle.manifolds(damping=0.6, saddles=[(0.6017, 3.7699)], arclength=2, progress=False)
    >>> grown.name.values.tolist()
    ['P(1,1,0)']
    """
    return _computed("manifold", locals())


def grazing_curve(
    machine: "GearPair | str | Path | None" = None,
    *,
    damping: float = 0.6,
    eccentricity: float | None = None,
    half_backlash: float = 0.6,
    harmonics: Sequence[Sequence[float]] | None = None,
    transmission_error: "TransmissionError | str | Path | None" = None,
    restitution: float = 1.0,
    order: int = 2,
    first: Literal["lower", "upper", "rest"] = "lower",
    velocity: tuple[float, float] = (0.0, 7.0),
    chord: float = 0.01,
    angle: float = 0.2,
    store: str | Path | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: "bool | Report" = True,
) -> "xr.Dataset":
    """Compute the grazing curve of the impacting model and its pre-images.

    Times count forcing periods; everything else is nondimensional, unless a machine is given.

    Parameters
    ----------
    machine : GearPair, str or path, optional
        A machine in its own units, or a TOML file of it, in place of its numbers in the model. The result then has SI
        units as well, and the window follows the machine
    damping : float, default 0.6
        delta
    eccentricity : float, optional
        epsilon, amplitude of the first harmonic; 0.1 without a measured curve
    half_backlash : float, default 0.6
        beta
    harmonics : sequence of tuples, optional
        (order, amplitude, phase) of each harmonic of the forcing beside the first; phases count periods of the
        harmonic
    transmission_error : TransmissionError, str or path, optional
        A measured curve in place of eccentricity and harmonics: what `rattle.transmission_error` returns, or a CSV file
        of angle (in turns) and error
    restitution : float, default 1.0
        r, by which an impact multiplies the speed; 1 is elastic
    order : int, default 2
        Highest order of pre-images; 0 is the grazing curve itself
    first : {"lower", "upper", "rest"}, default lower
        The curve of order 0: departures that next touch -beta; of a loose gear also those that next touch +beta from
        below ("upper"), or those up to which it comes to rest on +beta ("rest")
    velocity : (float, float), default (0.0, 7.0)
        Speeds to keep
    chord : float, default 0.01
        Longest distance between neighbouring points
    angle : float, default 0.2
        Largest angle between chords, radians
    store : str or path, optional
        Where the result lies; by default in `rattle.cache`
    workers : int, optional
        Threads; by default one for each core
    scheduler : str, optional
        Address of a Dask scheduler, in place of threads
    progress : bool or callable, default True
        Whether progress is shown on a terminal and in a notebook; or a function, called with each `Progress`

    Returns
    -------
    xarray.Dataset
        Orders along ``order``, their curves piece by piece.
        Its accessor ``.rattle`` draws and measures it.

    Raises
    ------
    TypeError
        If an argument is unknown or missing.
    ValueError
        If a value is wrong; the message says what would be right.

    Examples
    --------
    >>> import rattle
    >>> curves = rattle.grazing_curve(damping=0.6, order=1, progress=False)
    >>> curves.sizes['order']
    2
    """
    return _computed("grazing_curve", locals())


def trajectory(
    machine: "GearPair | str | Path | None" = None,
    *,
    damping: float = 0.6,
    eccentricity: float | None = None,
    half_backlash: float = 0.6,
    stiffness: float | None = None,
    harmonics: Sequence[Sequence[float]] | None = None,
    transmission_error: "TransmissionError | str | Path | None" = None,
    restitution: float = 1.0,
    contact_damping: float = 0.0,
    permanent_contact: Literal["envelope", "one_rotation"] = "envelope",
    allow_no_quiet_solution: bool = False,
    time: float = 0.0,
    velocity: float,
    displacement: float | None = None,
    periods: float = 20.0,
    samples_per_period: int = 200,
) -> "xr.Dataset":
    """Follow one motion of either model.

    Times count forcing periods; everything else is nondimensional, unless a machine is given.

    Parameters
    ----------
    machine : GearPair, str or path, optional
        A machine in its own units, or a TOML file of it, in place of its numbers in the model. The result then has SI
        units as well, and the window follows the machine
    damping : float, default 0.6
        delta
    eccentricity : float, optional
        epsilon, amplitude of the first harmonic; 0.1 without a measured curve
    half_backlash : float, default 0.6
        beta
    stiffness : float, optional
        kappa, finite and above damping^2/8; without it, the impacting model
    harmonics : sequence of tuples, optional
        (order, amplitude, phase) of each harmonic of the forcing beside the first; phases count periods of the
        harmonic
    transmission_error : TransmissionError, str or path, optional
        A measured curve in place of eccentricity and harmonics: what `rattle.transmission_error` returns, or a CSV file
        of angle (in turns) and error
    restitution : float, default 1.0
        r, by which an impact multiplies the speed; 1 is elastic
    contact_damping : float, default 0.0
        zeta, damping of the ringing in contact; 1 is critical
    permanent_contact : {"envelope", "one_rotation"}, default envelope
        When a contact counts as permanent: exactly, or by the paper's rule
    allow_no_quiet_solution : bool, default False
        Accept an eccentricity beyond the bound of Eq. (3), where no quiet solution exists
    time : float, default 0.0
        t, forcing periods
    velocity : float
        Signed velocity Phi'; without a displacement, the speed v > 0 of the departure
    displacement : float, optional
        Phi; within the backlash in the impacting model. Without it, +beta is left
    periods : float, default 20.0
        Span, forcing periods
    samples_per_period : int, default 200
        Samples beside the contacts

    Returns
    -------
    xarray.Dataset
        ``displacement`` and ``velocity`` over ``time``; contacts along ``contact``.
        Its accessor ``.rattle`` draws and measures it.

    Raises
    ------
    TypeError
        If an argument is unknown or missing.
    ValueError
        If a value is wrong; the message says what would be right.

    Examples
    --------
    >>> import rattle
    >>> motion = rattle.trajectory(damping=0.6, stiffness=1000.0, velocity=4.0, periods=5.0)
    >>> float(motion.time[-1])
    5.0
    """
    arguments = given_of(trajectory, locals())
    from rattle.arguments import read_machine, trajectory_of
    from rattle.results.trajectories import dataset_of

    pair = read_machine(arguments)
    request = trajectory_of(arguments)
    result = dataset_of(request, request.follow())
    return result if pair is None else pair.with_units(result)


VERBS: "dict[str, Callable[..., xr.Dataset]]" = {
    "basin": basin,
    "sweep": sweep,
    "bifurcation": bifurcation,
    "orbits": orbits,
    "manifold": manifolds,
    "grazing_curve": grazing_curve,
}
"""The verb that computes each kind of job."""

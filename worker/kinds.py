"""The kinds of jobs. Each says all of itself: its route and its command, and how it is run, summarised and drawn.

A kind takes files of its own and one entry; what is wanted of every kind is asked of its entry, so its route and the
models of its request and result in the API, its command, its picture and its tables follow. To add one:

1. Write its job, a class of `worker.jobs.job.AnalysisJob`. Its fields are the request; ``kind_`` holds the kind's name.
2. Write how it is computed, an `Analysis` of `worker.analyses.analysis`: the pieces of its work, what they are
   assembled to, the columns of its store, a summary with the `AnalysisView` that describes it, and a picture.
3. Enter it, by `analysis_kind`: in this module, or in a package of its own that is installed beside this one ::

       [project.entry-points."rattle.kinds"]
       impact_speeds = "impact_speeds.kind:KIND"

   The module that is named there holds nothing but the entry, since every command loads it. Workers need the package
   as well.

In Python, ``rattle.compute(job)`` computes a job of any kind, and ``rattle.connect(...).submit(job)`` submits it. A
kind that is not computed in pieces, as basins are not, is a `JobKind` with functions of its own in place of an
`Analysis`.

Entries name their modules and load them when they are first used: a command that only calls a service needs neither
Numba nor Dask.
"""

import pkgutil
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, Any, Literal, Protocol

from worker.fence import Fence

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from pydantic import BaseModel

    from worker.jobs.job import Job

GROUP = "rattle.kinds"
"""Group of the entry points by which packages add kinds."""
_AGAIN = (
    "The same request again answers with the same job. After a failure or a cancellation it makes a new one, which "
    "continues from what is there."
)
# Records of jobs have room for as much; a command and a route are named by these characters.
_NAME, _PATH = re.compile(r"[a-z][a-z0-9_]{0,15}"), re.compile(r"[a-z][a-z0-9-]*")


class Runs(Protocol):
    """What a job's computation into a store consists of, one `worker.run.Run` after the other."""

    def __call__(self, job: Any, location: str, driver: Any, fence: Fence) -> Iterator[Any]:
        """Begin each when the one before has finished; none if the store is complete. `worker.run.run_job` calls it."""


class Summarise(Protocol):
    """How a store is summarised, complete or not."""

    def __call__(self, location: str, zarr: str | None = None) -> "BaseModel":
        """The kind's model of its results. `zarr` is where its reader finds the store, by default its location."""


class DrawStore(Protocol):
    """How a store is drawn, complete or not."""

    def __call__(self, location: str, look: Any = ...) -> "Figure":
        """Draw a store; `look` is a `worker.results.panel.Look`."""


def later(name: str) -> Callable[..., Any]:
    """Function, or method of a value, that is loaded when it is first called.

    Parameters
    ----------
    name : str
        As ``module:name``, or ``module:value.method``.

    Returns
    -------
    callable
    """

    def call(*arguments: Any, **options: Any) -> Any:
        return pkgutil.resolve_name(name)(*arguments, **options)

    return call


@dataclass(frozen=True, kw_only=True)
class ResultKind:
    """One kind of result, as a dataset.

    Parameters
    ----------
    name : str
        As in the dataset's request.
    draw : callable
        ``draw(dataset, figure, look)``: draws a result on an empty figure; `look` is a `worker.results.panel.Look`.
    draw_on : callable, optional
        ``draw_on(dataset, axes, look)``: draws a result that takes no more on axes.
    shares : callable, optional
        ``shares(dataset, target)``: draws shares over swept parameters on an empty figure, or on axes.
    overlays : callable, optional
        ``overlays(dataset, names)``: what of it can be laid over axes of the (t, v) plane, by default all. Each draws
        itself by ``draw(axes, time_start)``.
    """

    name: str
    draw: "Callable[[xr.Dataset, Figure, Any], object]"
    draw_on: "Callable[[xr.Dataset, Axes, Any], object] | None" = None
    shares: "Callable[[xr.Dataset, Figure | Axes], object] | None" = None
    overlays: "Callable[[xr.Dataset, Collection[str]], Iterable[Any]] | None" = None


@dataclass(frozen=True, kw_only=True)
class JobKind(ResultKind):
    """One kind of job, and of its result. Its name is that of ``Job.kind``, of records, and with hyphens its command's.

    Parameters
    ----------
    path : str
        Its route: requests are posted to ``/v1/PATH``.
    title : str
        What a job of it is, in a few words.
    summary, description : str
        Of the route.
    command : str
        What ``rattle --help`` says of its command; nothing where it has none, since a package has one of its own.
    job : str
        Its class, as ``module:name``.
    view : str
        The model of its results, as ``module:name``.
    table : str
        The table that is meant where none is named: a dimension or an array of its stores.
    unit : {"tiles", "pieces"}
        What its progress counts.
    runs : Runs
    summarise : Summarise
    fingerprint : callable
        ``fingerprint(location)``: bytes that change whenever a picture of the store does.
    figure : DrawStore
    routes : callable, optional
        ``routes()``: routes of its own, a `fastapi.APIRouter`.
    """

    path: str
    title: str
    summary: str
    description: str
    command: str
    job: str
    view: str
    table: str
    unit: Literal["tiles", "pieces"]
    runs: Runs
    summarise: Summarise
    fingerprint: Callable[[str], bytes]
    figure: DrawStore
    routes: Callable[[], Any] | None = None

    def __post_init__(self) -> None:
        for what, text, pattern in (("name", self.name, _NAME), ("path", self.path, _PATH)):
            if not pattern.fullmatch(text):
                raise ValueError(f"the {what} {text!r} of a kind is not of the form {pattern.pattern}")

    @property
    def has_tiles(self) -> bool:
        """Whether its results are basins, of tiles."""
        return self.unit == "tiles"

    @cached_property
    def job_class(self) -> "type[Job]":
        """Class of its jobs."""
        found: type[Job] = pkgutil.resolve_name(self.job)
        return found

    @cached_property
    def result_view(self) -> "type[BaseModel]":
        """Model of its results: what a service answers, and describes in the API."""
        found: type[BaseModel] = pkgutil.resolve_name(self.view)
        return found


def analysis_kind(analysis: str, **said: Any) -> JobKind:
    """Kind whose jobs are computed in pieces.

    Parameters
    ----------
    analysis : str
        Its `worker.analyses.analysis.Analysis`, as ``module:name``.
    **said
        The name, path, title, summary, description, command, job and table of a `JobKind`, and its overlays and routes
        if it has any.

    Returns
    -------
    JobKind
    """
    return JobKind(
        **said, unit="pieces", view=f"{analysis}.view", runs=later(f"{analysis}.runs"),
        summarise=later(f"{analysis}.summary"), fingerprint=later(f"{analysis}.fingerprint"),
        figure=later(f"{analysis}.figure"), draw=later(f"{analysis}.draw_dataset"),
    )  # fmt: skip


def kind_of(request: Mapping[str, Any]) -> Any:
    """What a request says of its kind: the name that it gives, else a basin, or a sweep of several."""
    return request.get("kind", "sweep" if "vary" in request or "design" in request else "basin")


class Kinds(Mapping[str, JobKind]):
    """Kinds by name: some of this project, and those that packages add, which are loaded on the first look.

    Parameters
    ----------
    own : iterable of JobKind

    Raises
    ------
    ImportError
        On the first look, if a package's kind cannot be loaded, or clashes with another one.
    """

    def __init__(self, own: Iterable[JobKind]) -> None:
        self._own = {kind.name: kind for kind in own}

    @cached_property
    def _found(self) -> dict[str, JobKind]:
        kinds = dict(self._own)
        for entry in sorted(entry_points(group=GROUP), key=lambda entry: entry.name):
            kind = _loaded(entry)
            for other in kinds.values():
                if other.name == kind.name or other.path == kind.path:
                    raise ImportError(f"{_said_of(entry)} clashes with {other.name}, whose route is {other.path}")
            kinds[kind.name] = kind
        return kinds

    def __getitem__(self, name: str) -> JobKind:
        if name not in self._found:
            from worker.errors import UnknownKind  # loads Numba

            known = ", ".join(self)
            raise UnknownKind(f"there is no kind {name!r} here: install the package that adds it; there are {known}")
        return self._found[name]

    def offering(self, what: str) -> tuple[str, ...]:
        """Names of the kinds whose entry has something: `shares`, or what else not all have."""
        return tuple(name for name, kind in self.items() if getattr(kind, what))

    def __contains__(self, name: object) -> bool:
        return name in self._found

    def __iter__(self) -> Iterator[str]:
        return iter(self._found)

    def __len__(self) -> int:
        return len(self._found)


def _loaded(entry: EntryPoint) -> JobKind:
    try:
        kind = entry.load()
    except Exception as error:
        raise ImportError(f"{_said_of(entry)} cannot be loaded: {error}") from error
    if not isinstance(kind, JobKind):
        raise ImportError(f"{_said_of(entry)} is a {type(kind).__name__}, no JobKind")
    if kind.name != entry.name:
        raise ImportError(f"{_said_of(entry)} names itself {kind.name}")
    return kind


def _said_of(entry: EntryPoint) -> str:
    package = f" of the package {entry.dist.name} {entry.dist.version}" if entry.dist else ""
    return f"the kind {entry.name} = {entry.value}{package}"


def _of_basins(*, job: str, **said: Any) -> JobKind:
    return JobKind(
        **said, job=f"worker.jobs.basin_job:{job}", unit="tiles",
        view="worker.results.summary:ResultView", runs=later("worker.basins.pipeline:basin_runs"),
        summarise=later("worker.results.summary:summarise"), fingerprint=later("worker.results.summary:fingerprint"),
        figure=later("worker.results.figure:basin_figure"), draw=later("worker.results.figure:draw_basins"),
    )  # fmt: skip


KINDS = Kinds((
    _of_basins(
        name="basin", path="basins", title="Basin",
        summary="Submit a basin",
        description=f"Compute one basin of attraction.\n\n{_AGAIN}",
        command="Compute one basin on this machine, without a service.",
        job="BasinJob", table="attractor", draw_on=later("worker.results.figure:draw_basin"),
        overlays=later("worker.results.panel:overlays_of"),
    ),
    _of_basins(
        name="sweep", path="sweeps", title="Sweep",
        summary="Submit a sweep",
        description="Compute basins over one or two parameters, or those of a list of machines, all into one store."
        f"\n\n{_AGAIN}",
        command="Compute basins over one or two parameters, or over a number of a machine, into one store, on this "
        "machine.",
        job="SweepJob", table="share", shares=later("worker.results.shares:draw_shares"),
    ),
    analysis_kind(
        "worker.analyses.bifurcation:BIFURCATION",
        name="bifurcation", path="bifurcations", title="Bifurcation diagram",
        summary="Submit a bifurcation diagram",
        description=f"Compute a bifurcation diagram.\n\n{_AGAIN}",
        command="Compute a bifurcation diagram: last departures at each value, the very last seeding the next value.",
        job="worker.jobs.bifurcation_job:BifurcationJob", table="velocity",
    ),
    analysis_kind(
        "worker.analyses.orbits:ORBITS_ANALYSIS",
        name="orbits", path="orbits", title="Periodic orbits",
        summary="Submit a search for periodic orbits",
        description=f"Find periodic orbits, and on request follow them in one parameter or two.\n\n{_AGAIN}",
        command="Find periodic orbits, stable or not; follow them in a parameter and locate special points.",
        job="worker.jobs.orbits_job:OrbitsJob", table="orbit",
    ),
    analysis_kind(
        "worker.analyses.manifolds:MANIFOLD",
        name="manifold", path="manifolds", title="Manifolds of saddles",
        summary="Submit manifolds of saddles",
        description="Grow manifolds of saddles.\n\nWhether a seed leads to a saddle is known only when the job runs. "
        f"If it does not, the job fails and says what is there. {_AGAIN}",
        command="Grow stable and unstable manifolds of saddles of the impacting model.",
        job="worker.jobs.manifold_job:ManifoldJob", table="orbit",
        overlays=later("worker.analyses.manifolds:overlays_of"),
    ),
    analysis_kind(
        "worker.analyses.grazing_curves:GRAZING_CURVE",
        name="grazing_curve", path="grazing-curves", title="Grazing curve and its pre-images",
        summary="Submit a grazing curve",
        description=f"Compute the grazing curve and its pre-images.\n\n{_AGAIN}",
        command="Draw the grazing curve of the impacting model and its pre-images.",
        job="worker.jobs.grazing_curve_job:GrazingCurveJob", table="order",
        overlays=later("worker.analyses.grazing_curves:overlays_of"),
    ),
))  # fmt: skip
"""All kinds, by name."""

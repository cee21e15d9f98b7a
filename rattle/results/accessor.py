"""What a dataset of this project can do: ``dataset.rattle`` draws it, measures it, and lists what it holds.

What draws and measures loads Matplotlib and more, and is imported where it is used.
"""

import json
from collections.abc import Collection, Iterable, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import xarray as xr

from rattle.results.trajectories import TRAJECTORY, TRAJECTORY_RESULT, history_of
from rattle_kernels import NOT_CONVERGED, PERMANENT_CONTACT, SINK, Attractor, Oscillator
from worker.additions import additions
from worker.errors import InvalidJob
from worker.gear_pair import GearPair
from worker.jobs.job import Job
from worker.kinds import KINDS, ResultKind, kind_of
from worker.machine_series import MachineSeries
from worker.results import opening
from worker.results.opening import demand_all_cells
from worker.results.tables import table_of

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from worker.results.panel import Look

_SIZE = 10.0, 6.5
_RESERVED_IMAGES = {"sink": SINK, "permanent_contact": PERMANENT_CONTACT, "undecided": NOT_CONVERGED}


@xr.register_dataset_accessor("rattle")
class Result:
    """A result of this project, as a dataset: of a basin, a sweep, an analysis or a trajectory.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of `rattle.open` or of a verb.

    Raises
    ------
    InvalidJob
        If it is no result of this project.

    Examples
    --------
    >>> import rattle
    >>> basin = rattle.basin(cells=40, progress=False)
    >>> basin.rattle.kind, basin.rattle.complete
    ('basin', True)
    """

    def __init__(self, dataset: xr.Dataset) -> None:
        if "request" not in dataset.attrs:
            raise InvalidJob("this dataset is no result of this project: it has no attribute `request`")
        self._dataset = dataset

    def __repr__(self) -> str:
        state = "complete" if self.complete else "incomplete"
        return f"<{self.kind} of {self.oscillator}, {state}>"

    def __getattr__(self, name: str) -> Any:
        """What packages add to results of basins."""
        for addition in additions():
            if name in addition.results():
                self._demand(name, "basin")
                return addition.results()[name](self._dataset)
        raise AttributeError(f"a result has no attribute {name!r}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *(name for addition in additions() for name in addition.results())]

    @property
    def request(self) -> dict[str, Any]:
        """Request that the result answers, as JSON.

        Examples
        --------
        >>> rattle.basin(cells=40, progress=False).rattle.request["iterations"]
        1499
        """
        request: dict[str, Any] = json.loads(self._dataset.attrs["request"])
        return request

    @property
    def kind(self) -> str:
        """Kind of the job: basin, sweep, bifurcation, orbits, manifold, grazing_curve, or trajectory.

        Examples
        --------
        >>> rattle.grazing_curve(order=0, progress=False).rattle.kind
        'grazing_curve'
        """
        return str(kind_of(self.request))

    @property
    def _kind(self) -> ResultKind:
        """How results of its kind are drawn."""
        return TRAJECTORY_RESULT if self.kind == TRAJECTORY else KINDS[self.kind]

    @property
    def complete(self) -> bool:
        """Whether all of it is there.

        Examples
        --------
        >>> rattle.basin(cells=40, progress=False).rattle.complete
        True
        """
        return bool(self._dataset.attrs.get("complete", True))

    @cached_property
    def job(self) -> Job:
        """The job whose result this is; a trajectory is of no job, since it is computed at once.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> basin.rattle.job.grid.velocity_stop
        7.0
        """
        if self.kind == TRAJECTORY:
            raise InvalidJob("a trajectory is no job: it is computed at once")
        job_class, digest = KINDS[self.kind].job_class, self._dataset.attrs.get("request_sha256")
        return job_class.from_request(self.request) if digest is None else job_class.trusted(self.request, digest)

    @cached_property
    def machine(self) -> GearPair | None:
        """Machine that was given in its own units; None of a result in the model's alone.

        Examples
        --------
        >>> rattle.basin(cells=20, progress=False).rattle.machine is None
        True
        """
        machine = opening.machine_in(self._dataset)
        return machine if isinstance(machine, GearPair) else None

    @cached_property
    def machines(self) -> tuple[GearPair, ...]:
        """Machines of a sweep that steps from one to the next, in their own units; empty of other results.

        Examples
        --------
        >>> rattle.basin(cells=20, progress=False).rattle.machines
        ()
        """
        machines = opening.machine_in(self._dataset)
        return machines.pairs if isinstance(machines, MachineSeries) else ()

    @property
    def oscillator(self) -> Oscillator:
        """Oscillator; of a sweep or a diagram, at the first value.

        Examples
        --------
        >>> rattle.basin(damping=0.7, cells=10, progress=False).rattle.oscillator.damping
        0.7
        """
        return history_of(self._dataset)[0] if self.kind == TRAJECTORY else self.job.oscillator

    @property
    def attractors(self) -> xr.Dataset:
        """What motions end in, with the shares: the part of the dataset on the dimension ``attractor``.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> basin.rattle.attractors.name.values.tolist()
        ['permanent contact', 'P(1,1,0)', 'chaotic']
        """
        self._demand("attractors", "basin", "sweep")
        names = [name for name, array in self._dataset.variables.items() if "attractor" in array.dims]
        attractors: xr.Dataset = self._dataset[names].load()
        return attractors

    def catalogue(self) -> tuple[Attractor, ...]:
        """The motions of a basin as ``rattle_kernels`` has them, for its functions; ``solution`` indexes them.

        Returns
        -------
        tuple of Attractor
            Of a basin of a sweep, all motions of the sweep; those that this basin lacks have no points.

        Raises
        ------
        InvalidJob
            If this is no basin.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> basin.rattle.catalogue()[1].name
        'P(1,1,0)'
        """
        self._demand("catalogue", "basin")
        return opening.attractors_of(self._dataset)

    @property
    def colours(self) -> list[tuple[float, float, float]]:
        """Colour of each motion in the project's pictures (red, green, blue), the same in all basins of a sweep.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> basin.rattle.colours[0]
        (0.0784313725490196, 0.12156862745098039, 0.25098039215686274)
        """
        self._demand("colours", "basin", "sweep")
        from worker.pictures.colours import colours_of

        one = self._dataset if self.kind == "basin" else self.basins()[0]
        return colours_of(opening.attractors_of(one))

    @property
    def levels(self) -> dict[int, tuple[int, int]]:
        """Cells of each level, along velocity and time. ``rattle.open(location, level=n)`` opens level n.

        Level 0 is the basin itself. Only basins of more than 4,000 cells a side have others.

        Examples
        --------
        >>> rattle.basin(cells=40, progress=False).rattle.levels
        {0: (40, 40)}
        """
        self._demand("levels", "basin", "sweep")
        from worker.results.opening import levels_in

        return {level.number: level.tiling.grid.shape for level in levels_in(self._dataset)}

    @cached_property
    def shown(self) -> xr.Dataset:
        """The cells of a basin for figures of your own, in memory: at most 1000 each way.

        Beyond, every n-th stands for its neighbours, since labels have no mean. Shares remain those of all cells.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> basin.rattle.shown.solution.shape
        (40, 40)
        """
        self._demand("shown", "basin")
        return opening.thinned(self._dataset).load()

    def cell_names(self) -> xr.DataArray:
        """Name of the motion that each cell ends in, or each point of a sample.

        Returns
        -------
        xarray.DataArray of str
            Empty where a cell is not computed yet.

        Raises
        ------
        InvalidJob
            If this is neither a basin nor a sweep.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> basin.rattle.cell_names().sel(time=0.5, velocity=0.2, method="nearest").item()
        'permanent contact'
        """
        self._demand("cell_names", "basin", "sweep")
        names = np.array([*self._dataset.name.values.tolist(), ""]) if "name" in self._dataset else np.array([""])
        solution = self._dataset.solution
        numbered = np.where(solution >= 0, solution, len(names) - 1)
        return solution.copy(data=names[numbered]).assign_attrs(long_name="motion that it ends in").rename("cell_names")

    def image_counts(self) -> dict[str, int]:
        """How many cells have no cell as their image under ``P^k``: sink, permanent contact, undecided.

        Returns
        -------
        dict of str to int
            Of the cells that are computed so far. Points of a sample have no sink.

        Raises
        ------
        InvalidJob
            If this is neither a basin nor a sweep.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> sorted(basin.rattle.image_counts())
        ['permanent_contact', 'sink', 'undecided']
        """
        self._demand("image_counts", "basin", "sweep")
        if "image_cell" in self._dataset:
            images, reserved = self._dataset.image_cell.values, _RESERVED_IMAGES
        else:
            images = self._dataset.landing.values
            reserved = {name: code for name, code in _RESERVED_IMAGES.items() if name != "sink"}
        return {name: int((images == code).sum()) for name, code in reserved.items()}

    def basin(self, **values: float) -> xr.Dataset:
        """One basin of a sweep, as if it had been opened alone; numbers and colours stay those of the sweep.

        Parameters
        ----------
        **values : float
            Of every swept parameter, or of the coordinate of the machines.

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        InvalidJob
            If a parameter is missing or not swept, or a value is not among those swept.

        Examples
        --------
        >>> sweep = rattle.sweep(damping=[0.55, 0.6, 0.7], cells=16, iterations=101, progress=False)
        >>> sweep.rattle.basin(damping=0.6).rattle.oscillator.damping
        0.6
        """
        self._demand("basin", "sweep")
        return opening.basin_of(self._dataset, **values)

    def basins(self) -> tuple[xr.Dataset, ...]:
        """All basins of a sweep, each as `basin` returns it.

        Returns
        -------
        tuple of xarray.Dataset
            In the order of the values; of two parameters the last one runs fastest.

        Raises
        ------
        InvalidJob
            If this is no sweep.

        Examples
        --------
        >>> sweep = rattle.sweep(damping=[0.55, 0.6, 0.7], cells=16, iterations=101, progress=False)
        >>> [float(basin.damping) for basin in sweep.rattle.basins()]
        [0.55, 0.6, 0.7]
        """
        self._demand("basins", "sweep")
        job: Any = self.job
        return tuple(opening.basin_of(self._dataset, **job.values_of(number)) for number in range(job.basins))

    def measures(self, tolerance: float = 1e-6) -> xr.Dataset:
        """Measures of each basin: integrity, entropies, uncertainty exponent, least disturbance.

        Parameters
        ----------
        tolerance : float
            Width of the bracket to which each least disturbance is narrowed.

        Returns
        -------
        xarray.Dataset
            As ``worker.results.measures.measure_basins`` describes it.

        Raises
        ------
        InvalidJob
            If it is of a sample, or has too few cells.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> 0.0 < basin.rattle.measures().basin_entropy.item() < 1.0
        True
        """
        self._demand("measures", "basin", "sweep")
        from worker.results.measures import measure_basins

        return measure_basins(self._dataset, tolerance)

    def loudness(self) -> xr.Dataset:
        """How loud each motion is, and what is to be expected over the window: impacts, their speed and power.

        Returns
        -------
        xarray.Dataset
            As ``worker.results.measures.measure_loudness`` describes it; of a machine in watts and m/s as well.

        Raises
        ------
        InvalidJob
            If this is neither a basin nor a sweep.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> basin.rattle.loudness().impacts_per_period.values[:2].tolist()
        [0.0, 1.0]
        """
        self._demand("loudness", "basin", "sweep")
        from worker.results.measures import measure_loudness

        measured = measure_loudness(self._dataset)
        machine = opening.machine_in(self._dataset)
        return measured if machine is None else machine.with_units(measured)

    def least_disturbance(self, tolerance: float = 1e-6) -> xr.DataArray:
        """Smallest speed at each phase that leads from quiet to rattle.

        Parameters
        ----------
        tolerance : float
            Width of the bracket to which it is narrowed.

        Returns
        -------
        xarray.DataArray
            Over ``time``.

        Raises
        ------
        InvalidJob, ValueError
            If the window does not begin at speed 0, or there are no cells.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> bool((basin.rattle.least_disturbance() > basin.rattle.proven_quiet()).all())
        True
        """
        self._demand("least_disturbance", "basin")
        demand_all_cells(self._dataset)
        from rattle_kernels import least_disturbance

        job: Any = self.job
        found = least_disturbance(job.oscillator, self.catalogue(), self._dataset.solution, job.grid, tolerance)
        attributes = {"units": "1", "long_name": "smallest speed that leads from quiet to rattle"}
        return xr.DataArray(found.velocity, {"time": self._dataset.time}, ["time"], "least_disturbance", attributes)

    def proven_quiet(self) -> xr.DataArray:
        """Speed at each phase below which every departure falls quiet, by proof: ever lower bounces capture it.

        Returns
        -------
        xarray.DataArray
            Over ``time``; 0 where nothing is proven.

        Raises
        ------
        InvalidJob
            If this is no basin.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> bool((basin.rattle.proven_quiet() > 0.0).all())
        True
        """
        self._demand("proven_quiet", "basin")
        from rattle_kernels import capture_velocity

        speeds = capture_velocity(self.oscillator, self._dataset.time.values)
        attributes = {"units": "1", "long_name": "speed below which quiet is proven"}
        return xr.DataArray(speeds, {"time": self._dataset.time}, ["time"], "proven_quiet", attributes)

    def boundary_share(self, curves: xr.Dataset) -> dict[str, float]:
        """Share of the cells on boundaries of basins that lie within one cell of curves.

        Parameters
        ----------
        curves : xarray.Dataset
            Of `rattle.manifolds` or `rattle.grazing_curve`.

        Returns
        -------
        dict of str to float
            By the name of each curve, and of all together.

        Raises
        ------
        InvalidJob
            If this is no basin.

        Examples
        --------
        >>> basin, curves = rattle.basin(cells=40, progress=False), rattle.grazing_curve(order=1, progress=False)
        >>> list(basin.rattle.boundary_share(curves))
        ['grazing curve', 'pre-image 1', 'all together']
        """
        self._demand("boundary_share", "basin")
        demand_all_cells(self._dataset)
        from rattle_kernels import boundary_share

        job: Any = self.job
        pieces = {each.label: each.pieces for each in curves.rattle._overlays(())}
        pieces["all together"] = tuple(piece for own in pieces.values() for piece in own)
        solution = self._dataset.solution.values
        return {name: float(boundary_share(solution, job.grid, own)) for name, own in pieces.items()}

    def overlay(
        self, *kinds: str, ax: "Axes | None" = None, color: Any = None, linewidth: float | None = None
    ) -> "Axes":  # fmt: skip
        """Lay curves and marks over axes that show the (t, v) plane.

        Parameters
        ----------
        *kinds : str
            Of a basin: some of ``grazing``, ``preimages``, ``manifolds``, ``attractors``, ``saddles``, and masks of
            packages; by default all that there are. Of manifolds and grazing curves none: all of their curves are
            drawn.
        ax : matplotlib.axes.Axes, optional
            By default the current axes.
        color : optional
            One of Matplotlib, for all that is drawn; each kind and curve has its own by default.
        linewidth : float, optional
            Of curves, points.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InvalidJob
            If an overlay is not known, or the basin lacks it.

        Examples
        --------
        >>> axes = rattle.basin(cells=40, progress=False).rattle.plot(overlays=[])
        >>> curves = rattle.grazing_curve(order=1, progress=False)
        >>> [line.get_label() for line in curves.rattle.overlay(ax=axes).lines]
        ['grazing curve', 'pre-image 1']
        """
        import matplotlib.pyplot as plt

        from worker.pictures.overlay import Lines, Marks

        axes = plt.gca() if ax is None else ax
        for each in self._overlays(kinds):
            if color is not None and isinstance(each, Lines | Marks):
                each = each._replace(colour=color)
            if linewidth is not None and isinstance(each, Lines):
                each = each._replace(width=linewidth)
            each.draw(axes, axes.get_xlim()[0])
        return axes

    def _overlays(self, names: Collection[str]) -> Iterable[Any]:
        """What of it can be laid over axes of the (t, v) plane."""
        if self._kind.overlays is None:
            self._demand("overlay", *KINDS.offering("overlays"))
        assert self._kind.overlays is not None
        return self._kind.overlays(self._dataset, names)

    def plot(
        self, ax: "Axes | None" = None, *, overlays: Collection[str] | None = None, legend: bool = True,
        colors: Mapping[str, Any] | None = None, palette: str | None = None, title: str | None = None,
        overlay_key: bool = False,
    ) -> Any:  # fmt: skip
        """Draw the result: cells in the colours of their motions, a diagram, curves, or Phi(t).

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw one basin. By default, and for everything else, on a new figure, as ``rattle plot`` draws it.
        overlays : collection of str, optional
            What is laid over basins: some of ``grazing``, ``preimages``, ``manifolds``, ``attractors``, ``saddles``,
            and masks of packages; by default the grazing curve and the attractors.
        legend : bool
            Whether the motions are listed beside the basins.
        colors : dict, optional
            Colours of Matplotlib for some motions of basins, by name: ``{"permanent contact": "white"}``.
        palette : str, optional
            Of basins: ``"paper"`` or ``"colour_blind"``.
        title : str, optional
            Of the axes or the figure; by default of a new one the oscillator.
        overlay_key : bool
            Whether all that lies over basins is named, also marks.

        Returns
        -------
        matplotlib.axes.Axes or matplotlib.figure.Figure
            Axes of one basin, otherwise the figure.

        Raises
        ------
        InvalidJob
            If an overlay is not known for the model, or the basin lacks it; if a colour, a motion or a palette is not
            known, or colours are given for what has none.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> axes = basin.rattle.plot(overlays=["grazing"], colors={"P(1,1,0)": "orange"}, title="forty cells")
        >>> axes.get_ylabel(), axes.get_title()
        ('velocity v of departure', 'forty cells')
        """
        import matplotlib.pyplot as plt

        look, kind = self._look(overlays, legend, colors, palette, overlay_key), self._kind
        if ax is None:
            figure = plt.figure(figsize=_SIZE, layout="constrained")
            kind.draw(self._dataset, figure, look)
            if kind.draw_on is None:
                if title is not None:
                    figure.suptitle(title)
                return figure
            ax = figure.axes[0]
        elif kind.draw_on is not None:
            kind.draw_on(self._dataset, ax, look)
        else:
            over = " or lay it over a basin with .rattle.overlay(ax=ax)" if kind.overlays is not None else ""
            raise InvalidJob(f"a result of kind {self.kind} is drawn on a figure of its own: leave out ax{over}")
        if title is not None:
            ax.set_title(title)
        return ax

    def _look(
        self, overlays: Collection[str] | None, legend: bool, colors: Mapping[str, Any] | None, palette: str | None,
        overlay_key: bool,
    ) -> "Look":  # fmt: skip
        """How basins are drawn that `plot` is asked for; refuses a palette, a motion or a colour that is not known."""
        from matplotlib.colors import to_rgb

        from worker.pictures.colours import USUAL, Palette
        from worker.pictures.overlay_kind import USUAL_OVERLAYS
        from worker.results.panel import Look

        if colors or palette:
            self._demand("colors and palette", "basin", "sweep")
        if palette is not None and palette not in list(Palette):
            raise InvalidJob(f"there is no palette {palette!r}: take {' or '.join(Palette)}")
        known = self._dataset["name"].values.tolist() if colors else []
        for name in colors or {}:
            if name not in known:
                raise InvalidJob(f"there is no motion {name!r} to colour: there are {', '.join(known)}")
        try:
            own = {name: to_rgb(color) for name, color in (colors or {}).items()}
        except ValueError as error:
            raise InvalidJob(f"colors: {error}") from None
        return Look(
            overlays=USUAL_OVERLAYS if overlays is None else overlays, legend=legend, own_colours=own,
            palette=USUAL if palette is None else Palette(palette), overlay_key=overlay_key,
        )  # fmt: skip

    def caption(self) -> str:
        """What a picture of the result shows, for below it: parameters, window, and what to cite.

        Returns
        -------
        str

        Raises
        ------
        InvalidJob
            If it is a trajectory.

        Examples
        --------
        >>> rattle.basin(cells=40, progress=False).rattle.caption().split(", ")[0]
        'Basins of attraction of a rattling gear pair: impacting model'
        """
        from worker.results.caption import caption_of

        self._demand("caption", *KINDS)
        return caption_of(self._dataset)

    def plot_shares(self, ax: "Axes | None" = None) -> "Figure | Axes":
        """Draw shares and expected loudness over the swept parameter or the machines: lines over one, maps over two.

        The loudness of a machine is in its units, and Gamma is drawn where it differs from machine to machine.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw lines of shares alone over one parameter, without a legend. By default on a new figure, with
            one, and with the expected loudness below.

        Returns
        -------
        matplotlib.figure.Figure or matplotlib.axes.Axes
            The new figure, or the axes given.

        Raises
        ------
        InvalidJob
            If no basin is complete, or axes are given for maps over two parameters.

        Examples
        --------
        >>> sweep = rattle.sweep(damping=[0.55, 0.6, 0.7], cells=16, iterations=101, progress=False)
        >>> sweep.rattle.plot_shares().axes[0].get_ylabel()
        'share'
        """
        self._demand("plot_shares", *KINDS.offering("shares"))
        import matplotlib.pyplot as plt

        target = plt.figure(layout="constrained") if ax is None else ax
        assert self._kind.shares is not None
        self._kind.shares(self._dataset, target)
        return target

    def to_table(self, name: str | None = None, *, units: Literal["both", "model", "si"] = "both") -> "pd.DataFrame":
        """What the result lists, as a table.

        Parameters
        ----------
        name : str, optional
            Which table, where there are several; a wrong one lists them. By default the first.
        units : {"both", "model", "si"}
            Of a machine: columns in its units beside those of the model, or in place of them.

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        InvalidJob
            If there is no table of that name, or it has SI units alone and the result is of no machine.

        Examples
        --------
        >>> sweep = rattle.sweep(damping=[0.55, 0.6, 0.7], cells=16, iterations=101, progress=False)
        >>> sweep.rattle.to_table("change")[["change_kind", "change_from", "change_to"]].values.tolist()[0]
        ['death', 0.55, 0.6]
        """
        return table_of(self._dataset, name, units)

    def to_csv(
        self, path: str | Path, name: str | None = None, *, units: Literal["both", "model", "si"] = "both"
    ) -> None:
        """Write a table as CSV.

        Parameters
        ----------
        path : str or path
        name, units : str
            As for `to_table`.

        Raises
        ------
        InvalidJob
            If there is no table of that name.
        OSError
            If the file cannot be written.

        Examples
        --------
        >>> rattle.basin(cells=40, progress=False).rattle.to_csv("motions.csv")
        >>> from pathlib import Path
        >>> Path("motions.csv").read_text()[:16]
        'name,share,kind,'
        """
        self.to_table(name, units=units).to_csv(path, index=False)

    def _demand(self, what: str, *kinds: str) -> None:
        if self.kind not in kinds:
            raise InvalidJob(f"a result of kind {self.kind} has no {what}; those of kind {' and '.join(kinds)} have")

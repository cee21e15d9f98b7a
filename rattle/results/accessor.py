"""What a dataset of this project can do: ``dataset.rattle`` draws it, measures it, and lists what it holds."""

import json
from collections.abc import Collection
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from rattle.results.trajectories import TRAJECTORY, history_of
from rattle_kernels import Attractor, Oscillator
from worker.errors import InvalidJob
from worker.jobs.job import Job
from worker.kinds import KINDS
from worker.views import reading
from worker.views.tables import table_of

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@xr.register_dataset_accessor("rattle")
class Result:
    """A result of this project, as a dataset: of a basin, a sweep, an analysis or a trajectory.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of `rattle.open` or of a verb.
    """

    def __init__(self, dataset: xr.Dataset) -> None:
        if "request" not in dataset.attrs:
            raise InvalidJob("this dataset is no result of this project: it has no attribute `request`")
        self._dataset = dataset

    def __repr__(self) -> str:
        state = "complete" if self.complete else "incomplete"
        return f"<{self.kind} of {self.oscillator}, {state}>"

    @property
    def request(self) -> dict[str, Any]:
        """Request that the result answers, as JSON."""
        request: dict[str, Any] = json.loads(self._dataset.attrs["request"])
        return request

    @property
    def kind(self) -> str:
        """Kind of the job: basin, sweep, bifurcation, orbits, manifold, grazing_curve, or trajectory."""
        request = self.request
        return str(request.get("kind") or ("sweep" if "vary" in request else "basin"))

    @property
    def complete(self) -> bool:
        """Whether all of it is there."""
        return bool(self._dataset.attrs.get("complete", True))

    @cached_property
    def job(self) -> Job:
        """The job whose result this is."""
        if self.kind == TRAJECTORY:
            raise InvalidJob("a trajectory is no job: it is computed at once")
        return KINDS[self.kind].job_class.from_request(self.request)

    @property
    def oscillator(self) -> Oscillator:
        """Oscillator; of a sweep or a diagram, at the first value."""
        return history_of(self._dataset)[0] if self.kind == TRAJECTORY else self.job.oscillator

    @property
    def attractors(self) -> xr.Dataset:
        """What motions end in, with the shares: the part of the dataset on the dimension ``attractor``."""
        self._demand("attractors", "basin", "sweep")
        names = [name for name, array in self._dataset.variables.items() if "attractor" in array.dims]
        attractors: xr.Dataset = self._dataset[names].load()
        return attractors

    def catalogue(self) -> tuple[Attractor, ...]:
        """The attractors as `rattle_kernels` has them, for its functions."""
        self._demand("catalogue", "basin")
        return reading.attractors_of(self._dataset)

    def basin(self, **values: float) -> xr.Dataset:
        """One basin of a sweep, as if it had been opened alone; numbers and colours stay those of the sweep.

        Parameters
        ----------
        **values : float
            Of every swept parameter: ``sweep.rattle.basin(damping=0.6)``.

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        InvalidJob
            If a parameter is missing or not swept, or a value is not among those swept.
        """
        self._demand("basin", "sweep")
        return reading.basin_of(self._dataset, **values)

    def measures(self, tolerance: float = 1e-6) -> xr.Dataset:
        """Measures of each basin: integrity, entropies, uncertainty exponent, least disturbance.

        Parameters
        ----------
        tolerance : float
            Width of the bracket to which each least disturbance is narrowed.

        Returns
        -------
        xarray.Dataset
            As `worker.views.measures.measure_basins` describes it.

        Raises
        ------
        InvalidJob
            If it is of a sample, or has too few cells.
        """
        self._demand("measures", "basin", "sweep")
        from worker.views.measures import measure_basins

        return measure_basins(self._dataset, tolerance)

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
        """
        self._demand("least_disturbance", "basin")
        from rattle_kernels import least_disturbance

        job: Any = self.job
        found = least_disturbance(job.oscillator, self.catalogue(), self._dataset.solution, job.grid, tolerance)
        attributes = {"units": "1", "long_name": "smallest speed that leads from quiet to rattle"}
        return xr.DataArray(found.velocity, {"time": self._dataset.time}, ["time"], "least_disturbance", attributes)

    def proven_quiet(self) -> xr.DataArray:
        """Speed at each phase below which every departure falls quiet, by proof: ever lower bounces capture it.

        The array is over ``time``, and 0 where nothing is proven.
        """
        self._demand("proven_quiet", "basin")
        from rattle_kernels.impact_map.adiabatic_invariant import capture_bound
        from rattle_kernels.impact_map.chatter import fastest_below

        bound, phases = capture_bound(self.oscillator), self._dataset.time.values
        speeds = np.array([fastest_below(self.oscillator, bound, phase) for phase in phases])
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
        """
        self._demand("boundary_share", "basin")
        from rattle.results.curves import curves_of
        from rattle_kernels import boundary_share

        job: Any = self.job
        pieces = {each.label: each.pieces for each in curves_of(curves, curves.rattle.kind)}
        pieces["all together"] = tuple(piece for own in pieces.values() for piece in own)
        solution = self._dataset.solution.values
        return {name: float(boundary_share(solution, job.grid, own)) for name, own in pieces.items()}

    def overlay(self, *kinds: str, ax: "Axes | None" = None) -> "Axes":
        """Lay curves and marks over axes that show the (t, v) plane.

        Parameters
        ----------
        *kinds : str
            Of a basin: some of ``grazing``, ``preimages``, ``manifolds``, ``attractors``, ``saddles``; by default all.
            Of manifolds and grazing curves none: all of their curves are drawn.
        ax : matplotlib.axes.Axes, optional
            By default the current axes.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InvalidJob
            If an overlay is not known.
        """
        self._demand("overlay", "basin", "manifold", "grazing_curve")
        from rattle.results.drawing import draw_over

        return draw_over(self._dataset, self.kind, self.job, kinds, ax)

    def plot(self, ax: "Axes | None" = None, *, overlays: Collection[str] | None = None, legend: bool = True) -> Any:
        """Draw the result: cells in the colours of their motions, a diagram, curves, or Phi(t).

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw one basin. By default, and for everything else, on a new figure.
        overlays : collection of str, optional
            What is laid over basins: some of ``grazing``, ``preimages``, ``manifolds``, ``attractors``, ``saddles``; by
            default the grazing curve and the attractors.
        legend : bool
            Whether the motions are listed beside the basins.

        Returns
        -------
        matplotlib.axes.Axes or matplotlib.figure.Figure
            Axes of one basin, otherwise the figure.

        Raises
        ------
        InvalidJob
            If an overlay is not known for the model.
        """
        from rattle.results.drawing import draw_basin, draw_on_figure

        if self.kind == "basin":
            return draw_basin(self._dataset, ax, overlays, legend)
        if ax is not None:
            raise InvalidJob(f"a result of kind {self.kind} is drawn on a figure of its own: leave out ax")
        job = None if self.kind == TRAJECTORY else self.job
        return draw_on_figure(self._dataset, self.kind, job, overlays, legend)

    def plot_shares(self) -> "Figure":
        """Draw the share of each motion over the swept parameter: lines over one, maps over two.

        Returns
        -------
        matplotlib.figure.Figure

        """
        self._demand("plot_shares", "sweep")
        from rattle.results.drawing import draw_shares_of

        job: Any = self.job
        return draw_shares_of(self._dataset, job)

    def to_table(self, name: str | None = None) -> "pd.DataFrame":
        """What the result lists, as a table.

        Parameters
        ----------
        name : str, optional
            Which table, where there are several; a wrong one lists them. By default the first.

        Returns
        -------
        pandas.DataFrame

        """
        return table_of(self._dataset, name)

    def to_csv(self, path: str | Path, name: str | None = None) -> None:
        """Write a table as CSV.

        Parameters
        ----------
        path : str or path
        name : str, optional
            As for `to_table`.

        Raises
        ------
        InvalidJob
            If there is no table of that name.
        OSError
            If the file cannot be written.
        """
        self.to_table(name).to_csv(path, index=False)

    def _demand(self, what: str, *kinds: str) -> None:
        if self.kind not in kinds:
            raise InvalidJob(f"a result of kind {self.kind} has no {what}; those of kind {' and '.join(kinds)} have")

"""What a dataset of this project can do: ``dataset.rattle`` draws it, measures it, and lists what it holds."""

import json
from collections.abc import Collection, Iterable
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from rattle.trajectories import TRAJECTORY, history_of
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

    from worker.pictures.overlay import Overlay

_PANELS_ACROSS = 3
_SIZE = 10.0, 6.5


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

    def overlay(self, *kinds: str, ax: "Axes | None" = None) -> "Axes":
        """Lay curves and marks over axes that show the (t, v) plane.

        Parameters
        ----------
        *kinds : str
            Of a basin: ``grazing``, ``preimages``, ``manifolds``, ``attractors``, ``saddles``. Of manifolds and grazing
            curves none: all of their curves are drawn.
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
        import matplotlib.pyplot as plt

        from rattle.curves import curves_of
        from worker.pictures.overlay_kind import overlays_for

        axes = plt.gca() if ax is None else ax
        if self.kind == "basin":
            job: Any = self.job
            window = job.grid.velocity_start, job.grid.velocity_stop
            overlays: Iterable[Overlay] = overlays_for(kinds, job.oscillator, self.catalogue(), window)
        else:
            overlays = curves_of(self._dataset, self.kind)
        for each in overlays:
            each.draw(axes, axes.get_xlim()[0])
        return axes

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
        if self.kind == "basin":
            return self._plot_basin(ax, overlays, legend)
        if ax is not None:
            raise InvalidJob(f"a result of kind {self.kind} is drawn on a figure of its own: leave out ax")
        import matplotlib.pyplot as plt

        figure = plt.figure(figsize=(11.0, 4.5) if self.kind == TRAJECTORY else _SIZE, layout="constrained")
        if self.kind == "sweep":
            self._plot_basins(figure, overlays, legend)
        elif self.kind == TRAJECTORY:
            from worker.pictures.history_picture import draw_history

            draw_history(figure, *history_of(self._dataset))
        else:
            columns = {str(name): array.values for name, array in self._dataset.variables.items()}
            KINDS[self.kind].loaded_analysis.draw(self.job, columns, figure)
        return figure

    def _plot_basin(self, ax: "Axes | None", overlays: Collection[str] | None, legend: bool) -> "Axes":
        import matplotlib.pyplot as plt

        from worker.pictures.overlay_kind import USUAL_OVERLAYS

        if ax is None:
            ax = plt.figure(figsize=_SIZE, layout="constrained").add_subplot()
        chosen: Any = USUAL_OVERLAYS if overlays is None else overlays
        return reading.plot_basin(self._dataset, ax, legend=legend, overlays=chosen)

    def _plot_basins(self, figure: "Figure", overlays: Collection[str] | None, legend: bool) -> None:
        """One axes for each basin; of two swept parameters the first runs upwards, the last to the right."""
        from worker.pictures.picture import legend_patches

        job: Any = self.job
        across = job.sweep_shape[1] if len(job.sweep_shape) == 2 else min(_PANELS_ACROSS, job.basins)
        down = -(-job.basins // across)
        figure.set_size_inches(2.0 + 3.3 * across, 1.0 + 2.4 * down)
        axes = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False)
        places = axes[::-1] if len(job.sweep_shape) == 2 else axes
        for place in axes.flat[job.basins :]:
            place.set_axis_off()
        for number, place in zip(range(job.basins), places.flat, strict=False):
            values = job.values_of(number)
            self.basin(**values).rattle.plot(place, overlays=overlays, legend=False)
            place.label_outer()
            place.set_title(", ".join(f"{name} = {value:g}" for name, value in values.items()), fontsize="small")
        solutions = self._solutions()
        if legend and solutions:
            shares = self._dataset.share.mean([each.parameter for each in job.vary]).values
            labels = [f"{number}: {solution.name}" for number, solution in enumerate(solutions)]
            figure.legend(handles=legend_patches(solutions, shares, labels), loc="outside right upper", frameon=False)

    def _solutions(self) -> tuple[Attractor, ...]:
        """Motions of a sweep with the points of its first basin: enough for their names and colours."""
        job: Any = self.job
        return reading.attractors_of(self.basin(**job.values_of(0)))

    def plot_shares(self) -> "Figure":
        """Draw the share of each motion over the swept parameter: lines over one, maps over two.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InvalidJob
            If no basin is complete yet.
        """
        self._demand("plot_shares", "sweep")
        import matplotlib.pyplot as plt

        from worker.pictures.share_chart import draw_shares

        share = self._dataset.share.values if "share" in self._dataset else np.empty(0)
        if not np.isfinite(share).any():
            raise InvalidJob("no basin of the sweep is complete yet")
        figure = plt.figure(figsize=_SIZE, layout="constrained")
        job: Any = self.job
        draw_shares(figure, job, share, self._solutions())
        return figure

    def to_table(self, name: str | None = None) -> "pd.DataFrame":
        """What the result lists, as a table.

        Parameters
        ----------
        name : str, optional
            Which table, where there are several; a wrong one lists them. By default the first.

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        InvalidJob
            If there is no table of that name.
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

"""What draws a result: whole pictures, parts of them on axes of your own, and curves over what is there."""

from collections.abc import Collection
from typing import TYPE_CHECKING, Any

from rattle.results.described import Described
from rattle.results.trajectories import TRAJECTORY
from worker.errors import InvalidJob

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_CURVES = ("manifold", "grazing_curve")


class Plots(Described):
    """The part of the accessor that draws."""

    def overlay(self, *kinds: str, ax: "Axes | None" = None) -> "Axes":
        """Lay curves and marks over axes that show the (t, v) plane.

        Parameters
        ----------
        *kinds : str
            Of a basin: some of ``proven``, ``grazing``, ``preimages``, ``manifolds``, ``attractors``, ``saddles``; by
            default all that there are. Of manifolds and grazing curves none: all of their curves are drawn.
        ax : matplotlib.axes.Axes, optional
            By default the current axes.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InvalidJob
            If an overlay is not known, or nothing is proven.

        Examples
        --------
        >>> axes = rattle.basin(cells=40, progress=False).rattle.plot(overlays=[])
        >>> curves = rattle.grazing_curve(order=1, progress=False)
        >>> [line.get_label() for line in curves.rattle.overlay(ax=axes).lines]
        ['grazing curve', 'pre-image 1']
        """
        self._demand("overlay", "basin", *_CURVES)
        from rattle.results.drawing import draw_over

        return draw_over(self._dataset, self.kind, self.job, kinds, ax)

    def plot(self, ax: "Axes | None" = None, *, overlays: Collection[str] | None = None, legend: bool = True) -> Any:
        """Draw the result: cells in the colours of their motions, a diagram, curves, or Phi(t).

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw one basin. By default, and for everything else, on a new figure.
        overlays : collection of str, optional
            What is laid over basins: some of ``proven``, ``grazing``, ``preimages``, ``manifolds``, ``attractors``,
            ``saddles``; by default the grazing curve and the attractors. ``proven`` hatches what is not.
        legend : bool
            Whether the motions are listed beside the basins.

        Returns
        -------
        matplotlib.axes.Axes or matplotlib.figure.Figure
            Axes of one basin, otherwise the figure.

        Raises
        ------
        InvalidJob
            If an overlay is not known for the model, or nothing is proven.

        Examples
        --------
        >>> axes = rattle.basin(cells=40, progress=False).rattle.plot(overlays=["grazing"])
        >>> axes.get_ylabel()
        'velocity v of departure'
        """
        from rattle.results.drawing import draw_basin, draw_on_figure

        if self.kind == "basin":
            return draw_basin(self._dataset, ax, overlays, legend)
        if ax is not None:
            over = "or lay it over a basin with .rattle.overlay(ax=ax)" if self.kind in _CURVES else ""
            raise InvalidJob(
                f"a result of kind {self.kind} is drawn on a figure of its own: leave out ax {over}".rstrip()
            )
        job = None if self.kind == TRAJECTORY else self.job
        return draw_on_figure(self._dataset, self.kind, job, overlays, legend)

    def plot_shares(self, ax: "Axes | None" = None) -> "Figure | Axes":
        """Draw shares and expected loudness over the swept parameter: lines over one, maps over two.

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
        self._demand("plot_shares", "sweep")
        from rattle.results.drawing import draw_shares_of

        job: Any = self.job
        return draw_shares_of(self._dataset, job, ax)

"""What draws a result: whole pictures, parts of them on axes of your own, and curves over what is there."""

from collections.abc import Collection, Mapping
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

    def overlay(
        self, *kinds: str, ax: "Axes | None" = None, color: Any = None, linewidth: float | None = None
    ) -> "Axes":  # fmt: skip
        """Lay curves and marks over axes that show the (t, v) plane.

        Parameters
        ----------
        *kinds : str
            Of a basin: some of ``proven``, ``grazing``, ``preimages``, ``manifolds``, ``attractors``, ``saddles``; by
            default all that there are. Of manifolds and grazing curves none: all of their curves are drawn.
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

        return draw_over(self._dataset, self.kind, self.job, kinds, ax, color, linewidth)

    def plot(
        self, ax: "Axes | None" = None, *, overlays: Collection[str] | None = None, legend: bool = True,
        colors: Mapping[str, Any] | None = None, palette: str | None = None, title: str | None = None,
    ) -> Any:  # fmt: skip
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
        colors : dict, optional
            Colours of Matplotlib for some motions of basins, by name: ``{"permanent contact": "white"}``.
        palette : str, optional
            Of basins: ``"paper"`` or ``"colour_blind"``.
        title : str, optional
            Of the axes or the figure.

        Returns
        -------
        matplotlib.axes.Axes or matplotlib.figure.Figure
            Axes of one basin, otherwise the figure.

        Raises
        ------
        InvalidJob
            If an overlay is not known for the model, or nothing is proven; if a colour, a motion or a palette is not
            known, or colours are given for what has none.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> axes = basin.rattle.plot(overlays=["grazing"], colors={"P(1,1,0)": "orange"}, title="forty cells")
        >>> axes.get_ylabel(), axes.get_title()
        ('velocity v of departure', 'forty cells')
        """
        from rattle.results.drawing import draw_basin, draw_on_figure, paints_of

        if self.kind not in ("basin", "sweep") and (colors or palette):
            raise InvalidJob(f"colors and palette are of basins, and this is of kind {self.kind}")
        paints = paints_of(self._dataset, colors, palette)
        if self.kind == "basin":
            axes = draw_basin(self._dataset, ax, overlays, legend, paints)
            return axes if title is None else (axes.set_title(title), axes)[1]
        if ax is not None:
            over = "or lay it over a basin with .rattle.overlay(ax=ax)" if self.kind in _CURVES else ""
            raise InvalidJob(
                f"a result of kind {self.kind} is drawn on a figure of its own: leave out ax {over}".rstrip()
            )
        job = None if self.kind == TRAJECTORY else self.job
        figure = draw_on_figure(self._dataset, self.kind, job, overlays, legend, paints)
        if title is not None:
            figure.suptitle(title)
        return figure

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

"""The command that draws a store."""

from pathlib import Path
from typing import Annotated

import typer
from matplotlib.figure import Figure

from rattle.cli.console import Key, give_up
from rattle.results import opening
from worker.errors import InvalidJob, WorkerError
from worker.kinds import KINDS
from worker.pictures.figure_file import PictureFormat, new_figure, save_figure
from worker.pictures.overlay_kind import USUAL_OVERLAYS, OverlayKind, parse_overlays
from worker.pictures.printing import Printing
from worker.results.caption import caption_of
from worker.results.figure import figure_of_store
from worker.results.opening import is_address, levels_in
from worker.results.panel import Layer, Look
from worker.results.shares import draw_shares, shares_figure


def plot(
    store: Annotated[str, typer.Argument(help="Zarr store of any kind, or a service's address of one")],
    out_: Annotated[Path, typer.Option("--out", help="Picture to write: .png, .svg or .pdf")],
    layer: Annotated[Layer, typer.Option(help="Solutions, Hsu's group, period or step, or loudness")] = Layer.SOLUTION,
    shares: Annotated[bool, typer.Option("--shares", help="Shares over the swept parameter instead")] = False,
    overlay: Annotated[str, typer.Option(help=f"What lies over basins, of {','.join(OverlayKind)}")] = ",".join(
        USUAL_OVERLAYS
    ),
    overlay_key: Annotated[
        bool, typer.Option("--overlay-key", help="Name all that lies over basins, also marks and in other layers")
    ] = False,
    width: Annotated[
        float | None, typer.Option(help="In mm, 20 to 1200; of width and height alone the other follows")
    ] = None,
    height: Annotated[float | None, typer.Option(help="In mm")] = None,
    dpi: Annotated[int | None, typer.Option(help="Dots per inch, 30 to 1200; 110 by default")] = None,
    font_size: Annotated[float | None, typer.Option(help="Of ordinary letters, 4 to 36 points; 10 by default")] = None,
    editable: Annotated[bool, typer.Option("--editable", help="Text of an SVG or a PDF stays text")] = False,
    caption: Annotated[
        bool, typer.Option("--caption", help="Print a caption with parameters and what to cite, and put it in the file")
    ] = False,
    key: Key = None,
) -> None:
    """Draw a basin in the colours of its motions, a sweep side by side, or what an analysis has found."""
    try:
        printing = Printing(width, height, dpi, font_size, editable)
        overlays = parse_overlays(overlay)
        picture_format = PictureFormat.of_file(out_)
        look = Look(layer, overlays, overlay_key=overlay_key)
        if is_address(store):
            figure = figure_at_address(store, key, look, shares=shares)
        else:
            figure = shares_figure(store) if shares else figure_of_store(store, look)
        told = caption_of(opening.open(store, key=key), look) if caption else None
        save_figure(figure, out_, picture_format, printing, told)
        if told:
            typer.echo(told)
    except InvalidJob as error:
        give_up(str(error), 2)
    except WorkerError as error:
        give_up(str(error))
    except OSError as error:
        give_up(f"{out_} cannot be written: {error.strerror}")


def figure_at_address(address: str, key: str | None, look: Look, *, shares: bool) -> Figure:
    """Picture of a service's store: of the coarsest level of large basins, to fetch few chunks."""
    figure = new_figure()
    try:
        result = opening.open(address, key=key)
        if len(levels := levels_in(result)) > 1 and result.attrs["complete"]:
            result = opening.open(address, key=key, level=levels[-1].number)
        if shares:
            draw_shares(result, figure)
        else:
            KINDS[result.rattle.kind].draw(result, figure, look)
    except OSError as error:
        give_up(str(error))
    return figure

"""Commands that need no service: start one, draw a store."""

import errno
import signal
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from service.app import create_app
from service.cli.console import err, give_up, out
from service.cli.keys import opened_keys
from service.logs import write_logs
from service.server import Server, address, refusal_to_listen
from service.settings import Settings
from worker.analyses.picture import figure_of_store
from worker.errors import InvalidJob, WorkerError
from worker.pictures.figure_file import PictureFormat, save_figure
from worker.pictures.overlay_kind import USUAL_OVERLAYS, OverlayKind, parse_overlays
from worker.pictures.panel_picture import Layer
from worker.pictures.share_chart import shares_figure


def serve(
    host: Annotated[
        str | None, typer.Option(help="Address to listen on; any but loopback requires keys  [default: 127.0.0.1]")
    ] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on  [default: 8000]")] = None,
    data: Annotated[Path | None, typer.Option(help="Folder of database and results  [default: rattle-data]")] = None,
    workers: Annotated[int | None, typer.Option(min=1, help="Local worker processes  [default: 2]")] = None,
) -> None:
    """Start the service, its database and two local workers; Ctrl-C stops it, the next start resumes its jobs."""
    given = {"host": host, "port": port, "data": data, "workers": workers}
    settings = Settings(**{name: value for name, value in given.items() if value is not None})  # type: ignore[arg-type]
    _demand_keys(settings)
    _demand_port(settings)
    write_logs(settings.log_format, settings.log_level)
    err.print(f"starting on {address(settings.host, settings.port)}", highlight=False, soft_wrap=True)
    # Uvicorn stops gracefully, then raises the signal that it caught again: a service that was asked to stop has not
    # failed.
    for asked in (signal.SIGTERM, signal.SIGINT):
        signal.signal(asked, lambda *_: None)
    Server(create_app(settings), settings, on_ready=partial(_say_ready, settings)).run()


def _say_ready(settings: Settings, url: str) -> None:
    """Say where the service is and where its data are, on standard output: a program that starts it waits for that."""
    where = f"data in {settings.data.resolve()}"
    if settings.database_url or settings.store:
        where = f"results in {settings.results}"
    out.print(f"ready: {url}, {where}", markup=False, highlight=False, soft_wrap=True)


def _demand_port(settings: Settings) -> None:
    """Refuse to start where another program has the port, or it cannot be had."""
    error = refusal_to_listen(settings.host, settings.port)
    if error is None:
        return
    if error.errno == errno.EADDRINUSE:
        give_up(f"port {settings.port} of {settings.host} is in use: stop what uses it, or choose another by --port")
    give_up(f"nothing can listen on port {settings.port} of {settings.host}: {error.strerror}")


def _demand_keys(settings: Settings) -> None:
    """Refuse to start if keys are required and there is no valid one."""
    if not settings.keys_required:
        return
    if not _has_key(settings):
        why = "RATTLE_REQUIRE_KEYS is set" if settings.require_keys else f"{settings.host} is no loopback address"
        give_up(f"{why}, so callers need keys, and there is none: make one by `rattle keys add NAME`", 2)


def _has_key(settings: Settings) -> bool:
    if settings.database_url is None and not settings.database_file.exists():
        return False  # a command that is refused leaves no database behind
    with opened_keys(settings) as keys:
        live, _ = keys.live()
    return bool(live)


def plot(
    store: Annotated[str, typer.Argument(help="Zarr store of any kind, complete or not")],
    out_: Annotated[Path, typer.Option("--out", help="Picture to write: .png, .svg or .pdf")],
    layer: Annotated[Layer, typer.Option(help="Solutions, or Hsu's group, period or step")] = Layer.SOLUTION,
    shares: Annotated[bool, typer.Option("--shares", help="Shares over the swept parameter instead")] = False,
    overlay: Annotated[str, typer.Option(help=f"What lies over basins, of {','.join(OverlayKind)}")] = ",".join(
        USUAL_OVERLAYS
    ),
) -> None:
    """Draw a basin in the paper's colours, a sweep side by side, or what an analysis has found."""
    try:
        overlays = parse_overlays(overlay)
        picture_format = PictureFormat.of_file(out_)
        figure = shares_figure(store) if shares else figure_of_store(store, layer=layer, overlays=overlays)
        save_figure(figure, out_, picture_format)
    except InvalidJob as error:
        give_up(str(error), 2)
    except WorkerError as error:
        give_up(str(error))
    except OSError as error:
        give_up(f"{out_} cannot be written: {error.strerror}")

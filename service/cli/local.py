"""Commands that need no service: start one, draw a store."""

import signal
from pathlib import Path
from typing import Annotated

import typer
import uvicorn

from service.app import create_app
from service.cli.console import announce_compiling, err, give_up
from service.settings import Settings
from worker.analysis_kinds import ANALYSES, draw_analysis
from worker.analysis_store import kind_of_store
from worker.errors import WorkerError
from worker.panel_picture import Layer
from worker.picture import draw_basin
from worker.share_chart import draw_shares

_LOOPBACK = ("127.0.0.1", "::1", "localhost")


def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on; loopback only  [default: 127.0.0.1]")] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on  [default: 8000]")] = None,
    data: Annotated[Path | None, typer.Option(help="Folder of database and results  [default: rattle-data]")] = None,
    workers: Annotated[int | None, typer.Option(min=1, help="Local worker processes  [default: 2]")] = None,
) -> None:
    """Start the service, its database and two local workers; Ctrl-C stops it, the next start resumes its jobs."""
    given = {"host": host, "port": port, "data": data, "workers": workers}
    settings = Settings(**{name: value for name, value in given.items() if value is not None})  # type: ignore[arg-type]
    if settings.host not in _LOOPBACK:
        give_up(f"{settings.host} is no loopback address: the service has no log-in and listens on 127.0.0.1 only", 2)
    err.print(f"starting on http://{settings.host}:{settings.port}")
    announce_compiling()
    # Uvicorn stops gracefully, then raises the signal that it caught again: a service that was asked to stop has not
    # failed.
    for asked in (signal.SIGTERM, signal.SIGINT):
        signal.signal(asked, lambda *_: None)
    # A stream that a client holds open must not keep the service from stopping.
    uvicorn.run(
        create_app(settings), host=settings.host, port=settings.port, log_level="warning", timeout_graceful_shutdown=2
    )


def plot(
    store: Annotated[Path, typer.Argument(help="Zarr store of any kind, complete or not")],
    out_: Annotated[Path, typer.Option("--out", help="PNG to write")],
    layer: Annotated[Layer, typer.Option(help="Solutions, or Hsu's group, period or step")] = Layer.SOLUTION,
    shares: Annotated[bool, typer.Option("--shares", help="Shares over the swept parameter instead")] = False,
) -> None:
    """Draw a basin in the paper's colours, those of a sweep side by side, or what an analysis has found."""
    try:
        if kind_of_store(str(store)) in ANALYSES:
            draw_analysis(str(store), out_)
        elif shares:
            draw_shares(str(store), out_)
        else:
            draw_basin(str(store), out_, layer=layer)
    except WorkerError as error:
        give_up(str(error))
    except OSError as error:
        give_up(f"{out_} cannot be written: {error.strerror}")

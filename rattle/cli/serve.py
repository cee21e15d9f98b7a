"""The command that starts a service."""

import errno
import importlib.util
import logging
import signal
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from rattle.cli.console import Scheduler, give_up, out
from rattle.cli.keys import opened_keys
from service.app import create_app
from service.logs import write_logs
from service.server import Server, address, refusal_to_listen
from service.settings import Settings

_log = logging.getLogger("rattle.serve")


def _default(name: str) -> str:
    """Default of a setting, which the environment may replace."""
    return f"RATTLE_{name.upper()}, or {Settings.model_fields[name].default}"


def serve(
    host: Annotated[
        str | None,
        typer.Option(help="Address to listen on; any but loopback requires keys", show_default=_default("host")),
    ] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on", show_default=_default("port"))] = None,
    data: Annotated[
        Path | None, typer.Option(help="Folder of database and results", show_default=_default("data"))
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Local worker processes", show_default=_default("workers"))
    ] = None,
    scheduler: Scheduler = None,
) -> None:
    """Start the service, its database and two local workers; Ctrl-C stops it, the next start resumes its jobs.

    It prints `ready: `, its address and the folder of its data once it can compute.
    """
    given = {"host": host, "port": port, "data": data, "workers": workers, "scheduler": scheduler}
    settings = Settings(**{name: value for name, value in given.items() if value is not None})  # type: ignore[arg-type]
    _demand_extras(settings)
    _demand_keys(settings)
    _demand_port(settings)
    _demand_folder(settings)
    write_logs(settings.log_format, settings.log_level)
    _log.info("starting on %s", address(settings.host, settings.port))
    # Uvicorn stops gracefully, then raises the caught signal again. A service that was asked to stop has not failed.
    for asked in (signal.SIGTERM, signal.SIGINT):
        signal.signal(asked, lambda *_: None)
    Server(create_app(settings), settings, on_ready=partial(_say_ready, settings)).run()


def _demand_extras(settings: Settings) -> None:
    """Refuse to start if a package that the settings need is missing."""
    needed = (("postgres", "psycopg", settings.database.startswith("postgres")),
              ("s3", "obstore", settings.results.startswith("s3://")))  # fmt: skip
    for extra, module, is_needed in needed:
        if is_needed and importlib.util.find_spec(module) is None:
            give_up(f"these settings need {module}: pip install 'gear-rattle[{extra}]'", 2)


def _say_ready(settings: Settings, url: str) -> None:
    """Print where the service and its data are, on standard output: a program that starts it waits for this line."""
    where = f"data in {settings.data.resolve()}"
    if settings.database_url or settings.store:
        where = f"results in {settings.results}"
    out.print(f"ready: {url}, {where}", markup=False, highlight=False, soft_wrap=True)


def _demand_port(settings: Settings) -> None:
    """Refuse to start if the port is in use or not available."""
    error = refusal_to_listen(settings.host, settings.port)
    if error is None:
        return
    if error.errno == errno.EADDRINUSE:
        give_up(f"port {settings.port} of {settings.host} is in use: stop what uses it, or choose another by --port")
    give_up(f"nothing can listen on port {settings.port} of {settings.host}: {error.strerror}")


def _demand_folder(settings: Settings) -> None:
    """Refuse to start if the folder of database and results cannot be made."""
    try:
        settings.data.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        give_up(
            f"{settings.data} cannot hold database and results: {error.strerror}; choose another folder by --data", 2
        )


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

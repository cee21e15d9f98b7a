"""``rattle keys add | list | revoke``: the API keys of a service, in its database."""

import contextlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from rattle.cli.command import Command, Group
from rattle.cli.console import err, give_up, out
from service.records.engine import DatabaseError, open_database
from service.records.keys import InvalidKeyName, KeyRecord, Keys, KeyScope
from service.settings import Settings

Data = Annotated[
    Path | None, typer.Option(help="Folder of the service's database, unless RATTLE_DATABASE_URL names another")
]

keys = typer.Typer(
    name="keys", cls=Group, no_args_is_help=True, help="Make, list and revoke the API keys of a service."
)


@contextlib.contextmanager
def opened_keys(settings: Settings) -> Iterator[Keys]:
    """Keys of the service with these settings."""
    try:
        engine, sessions = open_database(settings.database)
    except (DatabaseError, OSError) as error:
        give_up(f"the database does not open: {str(error).splitlines()[0]}")
    try:
        yield Keys(sessions)
    finally:
        engine.dispose()


def _there(settings: Settings) -> bool:
    """Whether there is a database. One that is a file is made by `rattle keys add` and `rattle serve` alone."""
    return settings.database_url is not None or settings.database_file.exists()


def _records(settings: Settings) -> list[KeyRecord]:
    if not _there(settings):
        return []
    with opened_keys(settings) as here:
        return list(here.all())


def _settings(data: Path | None) -> Settings:
    return Settings() if data is None else Settings(data=data)


@keys.command(cls=Command)
def add(
    name: Annotated[str, typer.Argument(help="Name of its owner, shown in jobs and log lines")],
    scope: Annotated[list[KeyScope] | None, typer.Option(help="What it allows; read and submit by default")] = None,
    data: Data = None,
) -> None:
    """Make a key and print it once; from then on a service with this database requires keys."""
    scopes = scope or [KeyScope.READ, KeyScope.SUBMIT]
    with opened_keys(_settings(data)) as here:
        try:
            key = here.add(name, scopes)
        except InvalidKeyName as error:
            give_up(str(error), 2)
    err.print(f"the key of {name}, for {' and '.join(scopes)}; it is shown this once:", highlight=False)
    typer.echo(key)


@keys.command("list", cls=Command)
def list_keys(data: Data = None, as_json: Annotated[bool, typer.Option("--json", help="As JSON")] = False) -> None:
    """List all keys by their first characters, including revoked ones."""
    if as_json:
        typer.echo(json.dumps([_as_json(record) for record in _records(_settings(data))], indent=2))
        return
    table = Table("name", "key", "scopes", "created", "last used", "revoked")
    for record in _records(_settings(data)):
        moments = (record.created, record.last_used, record.revoked)
        cells = [f"{moment:%Y-%m-%d %H:%M}" if moment else "" for moment in moments]
        table.add_row(record.name, f"{record.prefix}...", record.scopes, *cells)
    out.print(table)


def _as_json(record: KeyRecord) -> dict[str, str | None]:
    moments = {name: getattr(record, name) for name in ("created", "last_used", "revoked")}
    dates = {name: moment.isoformat() if moment else None for name, moment in moments.items()}
    return {"name": record.name, "prefix": record.prefix, "scopes": record.scopes} | dates


@keys.command(cls=Command)
def revoke(
    which: Annotated[str, typer.Argument(help="The beginning of a key, or the name of all that are to be revoked")],
    data: Data = None,
) -> None:
    """Revoke keys; they stop working within two seconds."""
    settings = _settings(data)
    if not _there(settings):
        give_up(f"there is no database at {settings.database_file}, so there are no keys: name its folder by --data", 2)
    with opened_keys(settings) as here:
        revoked = here.revoke(which)
    if not revoked:
        give_up(f"no key that is not revoked begins with {which} or is called so: see `rattle keys list`", 2)
    for record in revoked:
        out.print(f"revoked {record.prefix}... of {record.name}", highlight=False)

"""``rattle certs DIR``: certificates for your own Dask cluster."""

from pathlib import Path
from typing import Annotated

import typer

from rattle.cli.console import give_up, out
from worker.cluster.certificates import make_certificates


def certs(
    folder: Annotated[Path, typer.Argument(help="Folder to write them to")],
    days: Annotated[int, typer.Option(min=1, max=3650, help="How long they are valid")] = 825,
) -> None:
    """Make certificates for the parts of a Dask cluster."""
    try:
        files = make_certificates(folder, days)
    except FileExistsError as error:
        give_up(f"{error.filename} is there already, and parts that run know that one: choose another folder", 2)
    except OSError as error:
        give_up(f"{folder} cannot be written: {error.strerror}")
    flags = f"--tls-ca-file {files.authority} --tls-cert {files.certificate} --tls-key {files.key} --no-dashboard"
    out.print(
        f"wrote {files.authority}, {files.certificate} and {files.key}, valid for {days} days; every part needs them:\n"
        f"  dask scheduler --protocol tls {flags}\n"
        f"  dask worker tls://HOST:8786 {flags}\n"
        f"  RATTLE_SCHEDULER=tls://HOST:8786 RATTLE_TLS_CA={files.authority} RATTLE_TLS_CERT={files.certificate} "
        f"RATTLE_TLS_KEY={files.key} rattle serve",
        highlight=False, soft_wrap=True,
    )  # fmt: skip

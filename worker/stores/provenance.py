"""Where a store comes from: its attributes by the CF conventions, and the versions that it was computed with."""

import json
import subprocess
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from rattle_kernels.numerics.fused_multiply_add import fuses_multiply_add
from worker.rounding import FUSED
from worker.stores import layout

CREATOR = "gear-rattle"
LICENSE = "CC0-1.0"
"""Of results, by its SPDX name: the program claims nothing on what others compute."""
REFERENCES = (
    "J. F. Mason, P. T. Piiroinen, R. E. Wilson, M. E. Homer, Basins of attraction in nonsmooth models of gear rattle, "
    "International Journal of Bifurcation and Chaos 19(1), 203-224 (2009), doi:10.1142/S021812740902283X"
)
_PACKAGES = ("gear-rattle", "numpy", "numba", "scipy", "zarr", "dask", "distributed")


def now() -> str:
    """Current time as text, for attributes."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def new_store_attributes(title: str, request: dict[str, Any], digest: str) -> dict[str, Any]:
    """Attributes of every new store: title, request, where it comes from, and time of creation.

    Only ``history``, the times, and what depends on versions and processor differ from one run of a request to another.
    Nobody's name is in a store: an export says whose it is.
    """
    begun = now()
    return {
        "Conventions": "CF-1.11",
        "title": title,
        "source": source(),
        "creator": CREATOR,
        "license": LICENSE,
        "references": REFERENCES,
        "history": f"{begun} begun by {source()}",
        "request": json.dumps(request),
        "request_sha256": digest,
        "layout_version": layout.LAYOUT_VERSION,
        "versions": versions(),
        "git_revision": _git_revision(),
        FUSED: fuses_multiply_add(),
        "started": begun,
        "finished": None,
        "complete": False,
    }


@cache
def source() -> str:
    """Name and version of the program that computes."""
    return f"gear-rattle {version('gear-rattle')}"


@cache
def versions() -> dict[str, str]:
    """Versions of the packages that results depend on."""
    return {package: version(package) for package in _PACKAGES}


@cache
def _git_revision() -> str | None:
    command = ["git", "-C", str(Path(__file__).parent), "rev-parse", "HEAD"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=5)
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()

"""Settings of the service: one class, read once, passed in. ``python -m service.settings`` prints them as a table."""

import re
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pydantic import Field, PositiveFloat, PositiveInt, field_validator

from service.logs import LogFormat
from worker.cluster.settings import ClusterSettings

_ORIGIN = re.compile(r"https?://[\w.:*\[\]-]+")
LOOPBACK = ("127.0.0.1", "::1", "localhost")


@dataclass(frozen=True)
class Quotas:
    """Limits on queued jobs, of all clients and of each, and on each client's queued and running cells or points."""

    queued: int
    queued_each: int
    places_each: int


class Settings(ClusterSettings):
    """Settings, from ``RATTLE_...`` environment variables or from options of ``rattle serve``."""

    data: Path = Field(Path("rattle-data"), description="Folder of the database and the results")
    database_url: str | None = Field(None, description="SQLAlchemy URL; SQLite in the data folder by default")
    store: str | None = Field(None, description="Folder of the Zarr stores; in the data folder by default")
    host: str = Field("127.0.0.1", description="Address to listen on; on any but loopback, keys are required")
    port: int = Field(8000, ge=0, le=65535, description="Port to listen on")
    require_keys: bool = Field(False, description="Require keys on loopback too, as behind a proxy")
    trusted_proxies: str | None = Field(
        None,
        description="Addresses or networks of proxies, with commas, whose X-Forwarded-For tells a client's address",
    )
    framed_by: str | None = Field(
        None,
        description="Origins, with spaces, whose pages may show the explorer in a frame, as at `/?embed=1`; none by "
        "default",
    )
    log_format: LogFormat = Field(LogFormat.PLAIN, description="Format of the log: plain or json")
    log_level: Literal["debug", "info", "warning", "error"] = Field("info", description="Lowest level that is logged")

    concurrent_jobs: int = Field(
        4, ge=0, description="Most jobs that one replica runs at a time; at 0 it runs none and only answers"
    )
    keep_days: PositiveFloat | None = Field(
        None,
        description="Days after which a result that nobody reads is deleted with its job; kept for ever by default",
    )
    keep_gb: PositiveFloat | None = Field(
        None, description="Gigabytes that results of ended jobs may take; beyond, the longest unread are deleted"
    )
    max_queued: PositiveInt = Field(10_000, description="Most queued jobs")
    max_queued_each: PositiveInt = Field(1_000, description="Most queued jobs of one client")
    max_places_each: PositiveInt = Field(
        2_000_000_000, description="Most cells or points, over all basins, that one client has queued and running"
    )
    max_connections: PositiveInt = Field(500, description="Most connections at a time; requests on others get 503")
    max_body_bytes: PositiveInt = Field(1_048_576, description="Largest request body")
    max_cells: PositiveInt = Field(25_000_000, description="Most cells of one basin, or points of a sample")
    max_iterations: PositiveInt = Field(10_000_019, description="Largest number of iterations k")
    max_samples: PositiveInt = Field(100_000, description="Most samples of one trajectory, not counting contacts")
    max_contacts: PositiveInt = Field(20_000, description="Contacts after which a trajectory is truncated")
    max_applications: PositiveInt = Field(100_000_000_000, description="Most cells times k of one basin")
    max_basins: PositiveInt = Field(10_000, description="Most basins of a sweep, or machines of a chart")
    max_sweep_applications: PositiveInt = Field(1_000_000_000_000, description="Most cells times k of a whole sweep")

    max_values: PositiveInt = Field(1_000_000, description="Most values of the parameter of a bifurcation diagram")
    max_forcing_terms: PositiveInt = Field(
        3_200_000, description="Most values times harmonics times their highest order, of one job"
    )
    max_table_rows: PositiveInt = Field(100_000, description="Most rows of a table sent as JSON or CSV")
    max_hours: PositiveFloat = Field(
        100.0, description="Longest time that a job may be expected to take, by the measured speed of this machine"
    )
    max_diagram_applications: PositiveInt = Field(10_000_000_000, description="Most impacts of a bifurcation diagram")
    max_diagram_points: PositiveInt = Field(20_000_000, description="Most departures that a bifurcation diagram stores")
    max_orbit_starts: PositiveInt = Field(1_000_000, description="Most cells times largest n+ of an orbit search")
    max_branch_points: PositiveInt = Field(20_000, description="Most points of a branch or curve in each direction")
    max_arclength: PositiveInt = Field(10_000, description="Largest arclength of a branch of a manifold")
    max_curve_points: PositiveInt = Field(
        2_000_000, description="Most points of a branch, or of an order of pre-images"
    )
    max_order: PositiveInt = Field(16, description="Highest order of pre-images of the grazing curve")

    @field_validator("framed_by")
    @classmethod
    def _are_origins(cls, value: str | None) -> str | None:
        if value is not None and not (value.split() and all(map(_ORIGIN.fullmatch, value.split()))):
            raise ValueError("give origins with spaces between them, as in https://wiki.example.org")
        return value

    @property
    def database(self) -> str:
        """SQLAlchemy URL of the job records."""
        return self.database_url or f"sqlite:///{self.database_file}"

    @property
    def database_file(self) -> Path:
        """File of the database, unless it has a URL."""
        return (self.data / "jobs.sqlite").resolve()

    @property
    def keys_required(self) -> bool:
        """Whether callers need a key even while the database holds none."""
        return self.require_keys or self.host not in LOOPBACK

    @property
    def deletes_results(self) -> bool:
        """Whether results are deleted at some time without being asked."""
        return self.keep_days is not None or self.keep_gb is not None

    @property
    def quotas(self) -> Quotas:
        """Quotas beyond which a submission is refused."""
        return Quotas(self.max_queued, self.max_queued_each, self.max_places_each)

    @property
    def results(self) -> str:
        """Folder of the Zarr stores."""
        return self.store or str((self.data / "results").resolve())


def as_markdown() -> str:
    """Table of all settings: variable, default, meaning."""
    lines = ["| variable | default | meaning |", "|---|---|---|"]
    for name, field in Settings.model_fields.items():
        default = "" if field.default is None else f"`{field.default}`"
        lines.append(f"| `RATTLE_{name.upper()}` | {default} | {field.description} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.stdout.write(as_markdown())

"""Settings of the service: one class, read once, passed in."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pydantic import Field, PositiveFloat, PositiveInt, model_validator
from pydantic_settings import BaseSettings, SettingsConfigDict

from service.logs import LogFormat
from worker.cluster.certificates import Certificates

LOOPBACK = ("127.0.0.1", "::1", "localhost")


@dataclass(frozen=True)
class Quotas:
    """The most jobs that wait, of all and of each submitter, and the most cells or points a submitter has under way."""

    queued: int
    queued_each: int
    places_each: int


class Settings(BaseSettings):
    """What can be set by ``RATTLE_...`` variables of the environment, or by options of ``rattle serve``."""

    model_config = SettingsConfigDict(env_prefix="RATTLE_", extra="ignore")

    data: Path = Field(Path("rattle-data"), description="Folder of the database and the results")
    database_url: str | None = Field(None, description="SQLAlchemy URL; SQLite in the data folder by default")
    store: str | None = Field(None, description="Folder of the Zarr stores; in the data folder by default")
    scheduler: str | None = Field(None, description="Address of a Dask scheduler; an embedded cluster by default")
    tls_ca: Path | None = Field(None, description="Certificate of the authority that a tls:// scheduler trusts")
    tls_cert: Path | None = Field(None, description="Certificate to show it")
    tls_key: Path | None = Field(None, description="Key of that certificate")
    workers: PositiveInt = Field(2, description="Worker processes of the embedded cluster")
    host: str = Field("127.0.0.1", description="Address to listen on; any but loopback demands keys")
    port: int = Field(8000, ge=0, le=65535, description="Port to listen on")
    require_keys: bool = Field(False, description="Demand keys also on loopback, as behind a proxy")
    log_format: LogFormat = Field(LogFormat.PLAIN, description="Lines of the log: plain, or json")
    log_level: Literal["debug", "info", "warning", "error"] = Field("info", description="Least level that is logged")

    concurrent_jobs: int = Field(4, ge=0, description="Most jobs that one replica runs at once; 0: it only answers")
    max_queued: PositiveInt = Field(10_000, description="Most jobs that wait")
    max_queued_each: PositiveInt = Field(1_000, description="Most jobs of one submitter that wait")
    max_places_each: PositiveInt = Field(
        2_000_000_000, description="Most cells or points, of all basins, that one submitter has waiting and running"
    )
    max_connections: PositiveInt = Field(500, description="Most connections at a time")
    request_seconds: PositiveFloat = Field(30.0, description="Longest time that a request may take to arrive")
    max_body_bytes: PositiveInt = Field(1_048_576, description="Largest request body")
    max_cells: PositiveInt = Field(25_000_000, description="Most cells, or points of a sample, of one basin")
    max_iterations: PositiveInt = Field(10_000_019, description="Largest k")
    max_samples: PositiveInt = Field(100_000, description="Most samples of one trajectory, contacts aside")
    max_contacts: PositiveInt = Field(20_000, description="Contacts at which a trajectory is truncated")
    max_applications: PositiveInt = Field(100_000_000_000, description="Most cells times k of one basin")
    max_basins: PositiveInt = Field(10_000, description="Most basins of a sweep")
    max_sweep_applications: PositiveInt = Field(1_000_000_000_000, description="Most cells times k of a whole sweep")

    max_diagram_applications: PositiveInt = Field(10_000_000_000, description="Most impacts of a bifurcation diagram")
    max_diagram_points: PositiveInt = Field(20_000_000, description="Most departures that a bifurcation diagram keeps")
    max_orbit_starts: PositiveInt = Field(1_000_000, description="Most cells times greatest n+ of an orbit search")
    max_branch_points: PositiveInt = Field(20_000, description="Most points each way of a branch or a curve")
    max_arclength: PositiveInt = Field(10_000, description="Greatest arclength of a branch of a manifold")
    max_curve_points: PositiveInt = Field(
        2_000_000, description="Most points of a branch, or of an order of pre-images"
    )
    max_order: PositiveInt = Field(16, description="Highest order of pre-images of the grazing curve")

    @model_validator(mode="after")
    def _certificates_are_whole(self) -> "Settings":
        given = [each is not None for each in (self.tls_ca, self.tls_cert, self.tls_key)]
        encrypted = (self.scheduler or "").startswith("tls://")
        if any(given) and not (all(given) and encrypted) or encrypted and not all(given):
            raise ValueError(
                "RATTLE_TLS_CA, RATTLE_TLS_CERT and RATTLE_TLS_KEY belong to a tls:// scheduler, all three: "
                "`rattle certs` makes them"
            )
        return self

    @property
    def certificates(self) -> Certificates | None:
        """Certificates for the scheduler, where there are any."""
        if self.tls_ca is None or self.tls_cert is None or self.tls_key is None:
            return None
        return Certificates(self.tls_ca, self.tls_cert, self.tls_key)

    @property
    def database(self) -> str:
        """SQLAlchemy URL of the job records."""
        return self.database_url or f"sqlite:///{self.database_file}"

    @property
    def database_file(self) -> Path:
        """Where the database lies, unless it has a URL."""
        return (self.data / "jobs.sqlite").resolve()

    @property
    def keys_demanded(self) -> bool:
        """Whether callers need a key even while there is none."""
        return self.require_keys or self.host not in LOOPBACK

    @property
    def quotas(self) -> Quotas:
        """What submissions are refused beyond."""
        return Quotas(self.max_queued, self.max_queued_each, self.max_places_each)

    @property
    def results(self) -> str:
        """Folder of the Zarr stores."""
        return self.store or str((self.data / "results").resolve())

"""Settings of the service: one class, read once, passed in."""

from pathlib import Path

from pydantic import Field, PositiveInt
from pydantic_settings import BaseSettings, SettingsConfigDict


class Settings(BaseSettings):
    """What can be set by ``RATTLE_...`` variables of the environment, or by options of ``rattle serve``."""

    model_config = SettingsConfigDict(env_prefix="RATTLE_", extra="ignore")

    data: Path = Field(Path("rattle-data"), description="Folder of the database and the results")
    database_url: str | None = Field(None, description="SQLAlchemy URL; SQLite in the data folder by default")
    store: str | None = Field(None, description="Folder of the Zarr stores; in the data folder by default")
    scheduler: str | None = Field(None, description="Address of a Dask scheduler; an embedded cluster by default")
    workers: PositiveInt = Field(2, description="Worker processes of the embedded cluster")
    host: str = Field("127.0.0.1", description="Address to listen on: loopback only, as there is no log-in")
    port: int = Field(8000, ge=0, le=65535, description="Port to listen on")

    max_body_bytes: PositiveInt = Field(1_048_576, description="Largest request body")
    max_cells: PositiveInt = Field(25_000_000, description="Most cells, or points of a sample, of one basin")
    max_iterations: PositiveInt = Field(1_000_003, description="Largest k")
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

    @property
    def database(self) -> str:
        """SQLAlchemy URL of the job records."""
        return self.database_url or f"sqlite:///{(self.data / 'jobs.sqlite').resolve()}"

    @property
    def results(self) -> str:
        """Folder of the Zarr stores."""
        return self.store or str((self.data / "results").resolve())

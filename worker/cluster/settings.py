"""Settings of the Dask cluster, from the environment: shared by the service and the package `rattle`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import Field, PositiveInt, ValidationError, model_validator
from pydantic_settings import BaseSettings, SettingsConfigDict

from worker.errors import InvalidSettings


@dataclass(frozen=True)
class Certificates:
    """Files that a part of a cluster needs: the authority's certificate, its own certificate, and its key."""

    authority: Path
    certificate: Path
    key: Path


class ClusterSettings(BaseSettings):
    """Where tasks run, from ``RATTLE_...`` environment variables.

    Raises
    ------
    InvalidSettings
        Naming each variable at fault.
    """

    model_config = SettingsConfigDict(env_prefix="RATTLE_", extra="ignore")

    scheduler: str | None = Field(None, description="Address of a Dask scheduler; an embedded cluster by default")
    tls_ca: Path | None = Field(None, description="Certificate of the authority that a tls:// scheduler trusts")
    tls_cert: Path | None = Field(None, description="Certificate that this side shows to the scheduler")
    tls_key: Path | None = Field(None, description="Key of that certificate")
    workers: PositiveInt = Field(2, description="Worker processes of the embedded cluster")

    def __init__(self, **given: Any) -> None:
        try:
            super().__init__(**given)
        except ValidationError as error:
            raise InvalidSettings("; ".join(_fault(item, given) for item in error.errors())) from None

    @model_validator(mode="after")
    def _certificates_are_complete(self) -> "ClusterSettings":
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
        """Certificates for the scheduler; None without TLS."""
        if self.tls_ca is None or self.tls_cert is None or self.tls_key is None:
            return None
        return Certificates(self.tls_ca, self.tls_cert, self.tls_key)


def _fault(item: Any, given: dict[str, Any]) -> str:
    """What is wrong with one setting, named as it was given: as an argument, or as a variable."""
    message = item["msg"].removeprefix("Value error, ")
    if not item["loc"]:
        return str(message)
    name = str(item["loc"][0])
    return f"{name if name in given else f'RATTLE_{name.upper()}'}: {message}, not {item['input']!r}"

"""Keys as the database holds them: never the key itself, only what is needed to recognise it."""

from datetime import datetime
from enum import StrEnum

from sqlalchemy import DateTime, String
from sqlalchemy.orm import Mapped, mapped_column

from service.records.job_record import Base


class KeyScope(StrEnum):
    """Scope of a key."""

    READ = "read"
    """Read jobs, results, pictures, stores and metrics."""
    SUBMIT = "submit"
    """Submit jobs and trajectories; cancel and delete one's own jobs."""
    ADMIN = "admin"
    """Everything, including other callers' jobs."""


class KeyRecord(Base):
    """One key. A name may have several, so that a key can be replaced without interruption."""

    __tablename__ = "keys"

    number: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    name: Mapped[str] = mapped_column(String(64), index=True)
    # First characters of the key, by which it is looked up and named.
    prefix: Mapped[str] = mapped_column(String(16), unique=True)
    # SHA-256 of the whole key. A key has 256 random bits, so a slow hash would gain nothing.
    digest: Mapped[str] = mapped_column(String(64))
    # Separated by spaces, as in RFC 6749.
    scopes: Mapped[str] = mapped_column(String(64))
    created: Mapped[datetime] = mapped_column(DateTime(timezone=True))
    revoked: Mapped[datetime | None] = mapped_column(DateTime(timezone=True))
    last_used: Mapped[datetime | None] = mapped_column(DateTime(timezone=True))

"""Keys as the database holds them: never the key itself, only what is needed to know it again."""

from datetime import datetime
from enum import StrEnum

from sqlalchemy import DateTime, String
from sqlalchemy.orm import Mapped, mapped_column

from service.records.job_record import Base


class KeyScope(StrEnum):
    """What a key allows."""

    READ = "read"
    """To look: jobs, results, pictures, stores, metrics."""
    SUBMIT = "submit"
    """To have something computed, and to stop and delete one's own jobs."""
    ADMIN = "admin"
    """All of it, and other people's jobs."""


class KeyRecord(Base):
    """One key. A name may have several, so that one can be replaced without a gap."""

    __tablename__ = "keys"

    number: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    name: Mapped[str] = mapped_column(String(64), index=True)
    # The beginning of the key, by which it is found and spoken of.
    prefix: Mapped[str] = mapped_column(String(16), unique=True)
    # SHA-256 of the whole: a key is 256 random bits, which no dictionary holds, so that a slow hash would gain nothing.
    digest: Mapped[str] = mapped_column(String(64))
    # Separated by blanks, as in RFC 6749.
    scopes: Mapped[str] = mapped_column(String(64))
    created: Mapped[datetime] = mapped_column(DateTime(timezone=True))
    revoked: Mapped[datetime | None] = mapped_column(DateTime(timezone=True))
    last_used: Mapped[datetime | None] = mapped_column(DateTime(timezone=True))

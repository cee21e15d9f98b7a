"""Keys: adding, listing and revoking them, and finding the caller that a key belongs to.

The database never holds the key itself, only what is needed to recognise it.
"""

import hashlib
import hmac
import re
import secrets
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from enum import StrEnum

from sqlalchemy import DateTime, String, func, or_, select, update
from sqlalchemy.orm import Mapped, Session, mapped_column

from service.records.engine import to_read
from service.records.job_record import Base

LOCAL = "local"
"""Name of all callers if no keys are required."""
_MARK = "rattle_"
_PREFIX = len(_MARK) + 8
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._@-]{0,63}")
# A revoked key is refused after this long, in every replica.
_REFRESH_SECONDS = 2.0
_NOTE_USE_SECONDS = 60.0


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


class InvalidKeyName(ValueError):
    """A name that a key cannot have."""


@dataclass(frozen=True)
class Caller:
    """Sender of a request: the name of its key, and the scopes of that key."""

    name: str
    scopes: frozenset[KeyScope]

    def may(self, scope: KeyScope) -> bool:
        """Whether the caller's key has this scope."""
        return scope in self.scopes or KeyScope.ADMIN in self.scopes


LOCAL_CALLER = Caller(LOCAL, frozenset({KeyScope.ADMIN}))
"""The caller if no keys are required."""


def _digest(key: str) -> str:
    return hashlib.sha256(key.encode()).hexdigest()


def _now() -> datetime:
    return datetime.now(UTC)


class Keys:
    """The keys of a service's database.

    Parameters
    ----------
    sessions : callable
        Makes database sessions.
    """

    def __init__(self, sessions: Callable[[], Session]) -> None:
        self._sessions = sessions

    def add(self, name: str, scopes: Iterable[KeyScope]) -> str:
        """Make a key. It is returned only once and stored nowhere.

        Raises
        ------
        InvalidKeyName
        """
        if not _NAME.fullmatch(name) or name == LOCAL:
            raise InvalidKeyName(
                f"{name!r} cannot name a key: use up to 64 letters, digits and . _ @ -, and not {LOCAL!r}, "
                "which is what callers without a key are called"
            )
        key = _MARK + secrets.token_urlsafe(32)
        with self._sessions() as session:
            session.add(
                KeyRecord(
                    name=name,
                    prefix=key[:_PREFIX],
                    digest=_digest(key),
                    created=_now(),
                    scopes=" ".join(scope for scope in KeyScope if scope in set(scopes)),
                )  # fmt: skip
            )
            session.commit()
        return key

    def all(self) -> Sequence[KeyRecord]:
        """All keys, revoked ones too, oldest first."""
        with to_read(self._sessions()) as session:
            return session.scalars(select(KeyRecord).order_by(KeyRecord.number)).all()

    def revoke(self, which: str) -> list[KeyRecord]:
        """Revoke the key with this prefix, or all keys of this name, and return those that were valid until now."""
        with self._sessions() as session:
            live = select(KeyRecord).where(
                or_(KeyRecord.name == which, KeyRecord.prefix == which[:_PREFIX]), KeyRecord.revoked.is_(None)
            )
            found = list(session.scalars(live))
            for record in found:
                record.revoked = _now()
            session.commit()
        return found

    def live(self) -> tuple[list[KeyRecord], bool]:
        """Keys that are not revoked, and whether any key exists."""
        with to_read(self._sessions()) as session:
            live = list(session.scalars(select(KeyRecord).where(KeyRecord.revoked.is_(None))))
            return live, bool(live) or bool(session.scalar(select(func.count()).select_from(KeyRecord)))

    def note_use(self, numbers: Iterable[int]) -> None:
        """Record that keys have just been used."""
        with self._sessions() as session:
            session.execute(update(KeyRecord).where(KeyRecord.number.in_(numbers)).values(last_used=_now()))
            session.commit()


class KeyRing:
    """The keys as this process read them last, at most two seconds ago. Looking up a caller needs no query.

    Guarantees. Keys are required if the settings say so, or if the database holds any key, even a revoked one. So
    revoking the last key does not open the service. The time to refuse a key does not depend on how much of it is
    correct.

    Parameters
    ----------
    keys : Keys
    required : bool
        Whether keys are required even if the database holds none.
    """

    def __init__(self, keys: Keys, required: bool) -> None:
        self._keys, self._required = keys, required
        self._known: dict[str, KeyRecord] = {}
        self._any = True
        self._refreshed = self._noted = -_NOTE_USE_SECONDS
        self._used: set[int] = set()

    @property
    def stale(self) -> bool:
        """Whether the keys should be read again."""
        return time.monotonic() - self._refreshed > _REFRESH_SECONDS

    def refresh(self) -> None:
        """Read the keys again, and record once a minute which ones have been used."""
        if self._used and time.monotonic() - self._noted > _NOTE_USE_SECONDS:
            used, self._used, self._noted = self._used, set(), time.monotonic()
            self._keys.note_use(used)
        live, self._any = self._keys.live()
        self._known = {record.prefix: record for record in live}
        self._refreshed = time.monotonic()

    @property
    def required(self) -> bool:
        """Whether callers need a key."""
        return self._required or self._any

    def caller(self, key: str) -> Caller | None:
        """Caller that this key belongs to; None if the key is unknown or revoked."""
        record = self._known.get(key[:_PREFIX])
        given = _digest(key)
        if record is None or not hmac.compare_digest(record.digest, given):
            return None
        self._used.add(record.number)
        return Caller(record.name, frozenset(KeyScope(scope) for scope in record.scopes.split()))

"""Keys: making, listing, revoking, and knowing whose a key is."""

import hashlib
import hmac
import re
import secrets
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

from sqlalchemy import func, or_, select, update
from sqlalchemy.orm import Session

from service.records.engine import to_read
from service.records.key_record import KeyRecord, KeyScope

LOCAL = "local"
"""Who submits where the doors are open."""
_MARK = "rattle_"
_PREFIX = len(_MARK) + 8
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._@-]{0,63}")
# A revoked key opens nothing after this long, in any replica.
_LOOK_AGAIN_SECONDS = 2.0
_NOTE_USE_SECONDS = 60.0


class InvalidKeyName(ValueError):
    """A name that no key can have."""


@dataclass(frozen=True)
class Caller:
    """Who speaks: the name of a key, and what it allows."""

    name: str
    scopes: frozenset[KeyScope]

    def may(self, scope: KeyScope) -> bool:
        """Whether the caller's key allows this."""
        return scope in self.scopes or KeyScope.ADMIN in self.scopes


ANYONE_HERE = Caller(LOCAL, frozenset({KeyScope.ADMIN}))
"""The caller where the doors are open."""


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
        """Make a key. It is told this once and kept nowhere.

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
        """Every key there ever was, oldest first."""
        with to_read(self._sessions()) as session:
            return session.scalars(select(KeyRecord).order_by(KeyRecord.number)).all()

    def revoke(self, which: str) -> list[KeyRecord]:
        """Revoke the key of that prefix, or all keys of that name; returns those that were live until now."""
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
        """Keys that open something, and whether there ever was any."""
        with to_read(self._sessions()) as session:
            live = list(session.scalars(select(KeyRecord).where(KeyRecord.revoked.is_(None))))
            return live, bool(live) or bool(session.scalar(select(func.count()).select_from(KeyRecord)))

    def note_use(self, numbers: Iterable[int]) -> None:
        """Note that keys have been used just now."""
        with self._sessions() as session:
            session.execute(update(KeyRecord).where(KeyRecord.number.in_(numbers)).values(last_used=_now()))
            session.commit()


class KeyRing:
    """The keys as this process saw them last, at most two seconds ago: looking a caller up asks nobody.

    Guarantees. Keys are demanded where the settings say so, or where the database holds any key, also a revoked one: to
    revoke the last key opens no door. What an unknown key costs does not depend on how much of it is right.

    Parameters
    ----------
    keys : Keys
    demanded : bool
        Whether keys are demanded also while there are none.
    """

    def __init__(self, keys: Keys, demanded: bool) -> None:
        self._keys, self._demanded = keys, demanded
        self._known: dict[str, KeyRecord] = {}
        self._any = True
        self._looked = self._noted = -_NOTE_USE_SECONDS
        self._used: set[int] = set()

    @property
    def stale(self) -> bool:
        """Whether it is time to look again."""
        return time.monotonic() - self._looked > _LOOK_AGAIN_SECONDS

    def look(self) -> None:
        """Look at the database, and note there once a minute which keys have been used."""
        if self._used and time.monotonic() - self._noted > _NOTE_USE_SECONDS:
            used, self._used, self._noted = self._used, set(), time.monotonic()
            self._keys.note_use(used)
        live, self._any = self._keys.live()
        self._known = {record.prefix: record for record in live}
        self._looked = time.monotonic()

    @property
    def demanded(self) -> bool:
        """Whether callers need a key."""
        return self._demanded or self._any

    def caller(self, key: str) -> Caller | None:
        """Whose key this is, None where it is nobody's."""
        record = self._known.get(key[:_PREFIX])
        given = _digest(key)
        if record is None or not hmac.compare_digest(record.digest, given):
            return None
        self._used.add(record.number)
        return Caller(record.name, frozenset(KeyScope(scope) for scope in record.scopes.split()))

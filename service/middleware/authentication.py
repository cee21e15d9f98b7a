"""The doors: who may come in, and what for, before anything else is looked at.

Everything is closed unless it is named here as open, so a new route is guarded without a word about it.
"""

import asyncio
import re

from anyio import to_thread
from sqlalchemy.exc import SQLAlchemyError
from starlette.responses import Response
from starlette.types import ASGIApp, Receive, Scope, Send

from service.errors import DATABASE_FAILED, problem
from service.records.key_record import KeyScope
from service.records.keys import ANYONE_HERE, Caller, KeyRing
from service.settings import LOOPBACK

OPEN_PATHS = frozenset({"/healthz", "/readyz", "/docs", "/docs/oauth2-redirect", "/redoc", "/openapi.json"})
"""What answers without a key: whether the service lives, and the description of its API."""
_PAGE, _PAGE_FILES = "/", "/explorer/"
_READING = ("GET", "HEAD", "OPTIONS")
_HOST = re.compile(rb"(\[[^\]]*\]|[^:]*)(:\d*)?")


def demanded_scope(method: str) -> KeyScope:
    """What a request needs to be allowed."""
    return KeyScope.READ if method in _READING else KeyScope.SUBMIT


class Doors:
    """ASGI middleware that lets in whoever has a key for what he asks, and everyone where no keys are demanded.

    Parameters
    ----------
    app : ASGI application
        Its ``state.key_ring`` is a `KeyRing`.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app
        self._looking = asyncio.Lock()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        if not _is_open(scope["path"]):
            answer = await self._decide(scope)
            if isinstance(answer, Response):
                await answer(scope, receive, send)
                return
            scope.setdefault("state", {})["caller"] = answer
        await self.app(scope, receive, send)

    async def _decide(self, scope: Scope) -> Caller | Response:
        """The caller, or what he is told in place of an answer."""
        ring: KeyRing = scope["app"].state.key_ring
        try:
            async with self._looking:
                if ring.stale:
                    await to_thread.run_sync(ring.look)
        except SQLAlchemyError:
            return problem(503, *DATABASE_FAILED, scope["path"])
        headers = dict(scope["headers"])
        if not ring.demanded:
            return ANYONE_HERE if _names_loopback(headers.get(b"host", b"")) else _misdirected(scope["path"])
        return _holder(ring, headers.get(b"authorization"), scope)


def _is_open(path: str) -> bool:
    """Whether what lies there is for everyone: the page holds nothing but the field for the key."""
    return path in OPEN_PATHS or path == _PAGE or path.startswith(_PAGE_FILES)


def _holder(ring: KeyRing, given: bytes | None, scope: Scope) -> Caller | Response:
    if given is None:
        detail = "this service demands a key: send the header `authorization: Bearer KEY`"
        return _unauthorized("key-required", detail, scope, "")
    scheme, _, key = given.decode("latin-1").partition(" ")
    caller = ring.caller(key.strip()) if scheme.lower() == "bearer" else None
    if caller is None:
        detail = "this is no key of this service, or it has been revoked; its keeper makes one by `rattle keys add`"
        return _unauthorized("key-unknown", detail, scope, ', error="invalid_token"')
    needed = demanded_scope(scope["method"])
    if not caller.may(needed):
        has = " and ".join(sorted(caller.scopes)) or "nothing"
        detail = f"this needs the scope {needed}; the key of {caller.name} has {has}"
        challenge = f'Bearer realm="gear-rattle", error="insufficient_scope", scope="{needed}"'
        return problem(403, "scope-missing", detail, scope["path"], headers={"www-authenticate": challenge})
    return caller


def _unauthorized(kind: str, detail: str, scope: Scope, error: str) -> Response:
    challenge = f'Bearer realm="gear-rattle"{error}'
    return problem(401, kind, detail, scope["path"], headers={"www-authenticate": challenge})


def _names_loopback(host: bytes) -> bool:
    """Whether a request was meant for this machine; a web page that has its own name point here says that name."""
    match = _HOST.fullmatch(host)
    return match is not None and match[1].strip(b"[]").decode("latin-1").lower() in LOOPBACK


def _misdirected(path: str) -> Response:
    detail = "without keys this service answers to localhost, 127.0.0.1 and [::1] only, and the Host header is another"
    return problem(421, "misdirected-request", detail, path)

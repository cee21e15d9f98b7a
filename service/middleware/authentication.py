"""Authentication by key, before anything else handles the request.

Every path that is not listed here as open needs a key, so a new route is protected without further code.
"""

import asyncio
import re

from anyio import to_thread
from starlette.responses import Response
from starlette.types import ASGIApp, Receive, Scope, Send

from service.middleware.of_http import OfHttp
from service.problems import database_problem, problem
from service.records.engine import DatabaseError
from service.records.keys import LOCAL_CALLER, Caller, KeyRing, KeyScope
from service.settings import LOOPBACK

OPEN_PATHS = frozenset({"/healthz", "/readyz", "/docs", "/openapi.json"})
"""Paths that need no key: health, and the description of the API."""
_PAGE, _PAGE_FILES = "/", ("/explorer/", "/docs/")
_READING = ("GET", "HEAD", "OPTIONS")
_HOST = re.compile(rb"(\[[^\]]*\]|[^:]*)(:\d*)?")


def required_scope(method: str) -> KeyScope:
    """Scope that a request of this method requires."""
    return KeyScope.READ if method in _READING else KeyScope.SUBMIT


class Authentication(OfHttp):
    """ASGI middleware that passes a request on if its key allows it, or if no keys are required.

    Parameters
    ----------
    app : ASGI application
        Its ``state.key_ring`` is a `KeyRing`.
    """

    def __init__(self, app: ASGIApp) -> None:
        super().__init__(app)
        self._refreshing = asyncio.Lock()

    async def answer(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""
        if not _is_open(scope["path"]):
            caller = await self._authenticate(scope)
            if isinstance(caller, Response):
                await caller(scope, receive, send)
                return
            scope.setdefault("state", {})["caller"] = caller
        await self.app(scope, receive, send)

    async def _authenticate(self, scope: Scope) -> Caller | Response:
        """Identify the caller of a request, or return the response that refuses it."""
        ring: KeyRing = scope["app"].state.key_ring
        try:
            async with self._refreshing:
                if ring.stale:
                    await to_thread.run_sync(ring.refresh)
        except DatabaseError as error:
            return database_problem(error, scope["path"])
        headers = dict(scope["headers"])
        if not ring.required:
            return LOCAL_CALLER if _names_loopback(headers.get(b"host", b"")) else _misdirected(scope["path"])
        return _caller_of(ring, headers.get(b"authorization"), scope)


def _is_open(path: str) -> bool:
    """Whether a path needs no key. The page is open: it contains only the field for the key."""
    return path in OPEN_PATHS or path == _PAGE or path.startswith(_PAGE_FILES)


def _caller_of(ring: KeyRing, authorization: bytes | None, scope: Scope) -> Caller | Response:
    if authorization is None:
        detail = "this service requires a key: send the header `authorization: Bearer KEY`"
        return _unauthorized("key-required", detail, scope, "")
    scheme, _, key = authorization.decode("latin-1").partition(" ")
    caller = ring.caller(key.strip()) if scheme.lower() == "bearer" else None
    if caller is None:
        detail = "this key is unknown or has been revoked; the service's operator can make one with `rattle keys add`"
        return _unauthorized("key-unknown", detail, scope, ', error="invalid_token"')
    needed = required_scope(scope["method"])
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
    """Whether the Host header names this machine. A web page whose domain resolves to loopback sends its own name."""
    match = _HOST.fullmatch(host)
    return match is not None and match[1].strip(b"[]").decode("latin-1").lower() in LOOPBACK


def _misdirected(path: str) -> Response:
    detail = "without keys this service answers only where the Host header is localhost, 127.0.0.1 or [::1]"
    return problem(421, "misdirected-request", detail, path)

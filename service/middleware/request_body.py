"""Request bodies: read whole within a limit, announced or not, and refused where JSON is not plain.

JSON allows a key to stand twice in an object, and readers differ on which one counts; here neither does.
"""

import json
from typing import Any

from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.errors import problem

_WITHOUT_BODY = ("GET", "HEAD", "OPTIONS", "TRACE")


class _StandsTwice(Exception):
    """A key does, in one object."""


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    read: dict[str, Any] = {}
    for key, value in pairs:
        if key in read:
            raise _StandsTwice(key)
        read[key] = value
    return read


class RequestBody:
    """ASGI middleware that answers 413 as soon as a body is, or proves to be, too large.

    Parameters
    ----------
    app : ASGI application
    most : int
        Bytes.
    """

    def __init__(self, app: ASGIApp, most: int) -> None:
        self.app, self.most = app, most

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""
        if scope["type"] != "http" or scope["method"] in _WITHOUT_BODY:
            await self.app(scope, receive, send)
            return
        headers = dict(scope["headers"])
        body = await self._read(headers, receive)
        refusal = self._too_large(scope["path"]) if body is None else _not_plain(body, headers, scope["path"])
        if refusal is not None:
            await refusal(scope, receive, send)
            return
        passed = False

        async def replay() -> Message:
            nonlocal passed
            if passed:
                return await receive()
            passed = True
            return {"type": "http.request", "body": body, "more_body": False}

        await self.app(scope, replay, send)

    async def _read(self, headers: dict[bytes, bytes], receive: Receive) -> bytes | None:
        """The body; None where it is too large."""
        announced = headers.get(b"content-length", b"0")
        if announced.isdigit() and int(announced) > self.most:
            return None
        body = bytearray()
        more = True
        while more:
            # A client that leaves sends no more: what is there is passed on, and its answer goes nowhere.
            message = await receive()
            body += message.get("body", b"")
            more = message.get("more_body", False)
            if len(body) > self.most:
                return None
        return bytes(body)

    def _too_large(self, path: str) -> Response:
        # The rest of the body is not waited for: the connection ends with the answer.
        detail = f"a request body may have at most {self.most} bytes"
        return problem(413, "body-too-large", detail, path, headers={"connection": "close"})


def _not_plain(body: bytes, headers: dict[bytes, bytes], path: str) -> Response | None:
    """Refusal of JSON that is nested too deeply or has a key twice; what is no JSON is refused by who reads it."""
    kind = headers.get(b"content-type", b"").split(b";")[0].strip().lower()
    if kind != b"application/json" and not kind.endswith(b"+json"):
        return None
    try:
        json.loads(body, object_pairs_hook=_once)
    except _StandsTwice as error:
        message = f"the key {error.args[0]!r} stands twice in one object: which one is meant?"
        errors = [{"location": ["body"], "message": message}]
        return problem(422, "invalid-request", f"body: {message}", path, errors)
    except RecursionError:
        return problem(400, "malformed-request", "body: nested too deeply to be any request", path)
    except ValueError:
        return None
    return None

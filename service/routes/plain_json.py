"""JSON bodies of requests: of bounded size, parsed once, and refused if a key is repeated.

JSON allows a key to occur twice in an object, and parsers differ on which one counts. Such a body is refused here.
"""

import json
from collections.abc import AsyncGenerator, Callable, Coroutine
from functools import partial
from typing import Any

from fastapi import HTTPException, Request, Response
from fastapi.routing import APIRoute

from service.answers.request_checks import RequestChecks
from service.problems import MalformedBody
from worker.errors import FieldPath

_MOST_KEYS = 1000
# Larger bodies are parsed in a thread.
_SMALL_BYTES = 8192
# As many of the largest are held at a time, until they are answered.
_LARGE_BODIES = 16
# A whole number of more is read as a float, infinite if need be: nothing of a request is so large.
_MOST_DIGITS, _UNREADABLE_DIGITS = 300, 4300


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    result = dict(pairs)
    if len(pairs) > _MOST_KEYS:
        raise MalformedBody(422, f"an object has {len(pairs)} keys, and no request has more than {_MOST_KEYS}")
    if len(result) < len(pairs):
        names = [key for key, _ in pairs]
        key = next(key for number, key in enumerate(names) if key in names[:number])
        raise MalformedBody(422, f"the key {key!r} stands twice in one object: which one is meant?")
    return result


def _whole(text: str) -> int | float:
    if len(text) > _UNREADABLE_DIGITS:
        raise MalformedBody(400, f"error parsing the body: a whole number has {len(text)} digits")
    return int(text) if len(text) <= _MOST_DIGITS else float(text)


def _place_of_half(value: Any) -> FieldPath | None:
    """Place of the first text that cannot be encoded. A name that cannot be is not told: its object is the place."""
    if isinstance(value, str):
        return None if _is_whole(value) else ()
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for name, each in items:
        if isinstance(name, str) and not _is_whole(name):
            return ()
        if (place := _place_of_half(each)) is not None:
            return (name, *place)
    return None


def _is_whole(text: str) -> bool:
    return text.isascii() or not any("\ud800" <= letter <= "\udfff" for letter in text)


def parse_body(body: bytes) -> Any:
    """JSON of a body, in which every text is Unicode and no whole number endless.

    Parameters
    ----------
    body : bytes

    Returns
    -------
    object

    Raises
    ------
    MalformedBody
        If it is no UTF-8, nests too deeply, repeats a key of an object, has too many keys, or has half a character.
    json.JSONDecodeError
    """
    try:
        value = json.loads(body.decode("utf-8-sig", "surrogatepass"), object_pairs_hook=_unique, parse_int=_whole)
        # Half a character of UTF-16, as \ud800 is, can be neither stored nor sent.
        if b"\\u" in body or not body.isascii():
            json.dumps(value, ensure_ascii=False).encode()
    except RecursionError:
        raise MalformedBody(400, "nested too deeply to be any request") from None
    except UnicodeDecodeError as error:
        raise MalformedBody(400, f"not UTF-8 at byte {error.start}") from None
    except UnicodeEncodeError:
        message = "a text holds half of a surrogate pair: escape both halves, or write UTF-8"
        raise MalformedBody(422, message, _place_of_half(value) or ()) from None
    return value


class HeldBodies:
    """Bytes of all bodies of requests that are not answered yet. It must be used from one event loop."""

    size = 0


class _PlainJsonRequest(Request):
    size = 0

    async def stream(self) -> AsyncGenerator[bytes]:
        most: int = self.app.state.settings.max_body_bytes
        held: HeldBodies = self.app.state.bodies
        async for chunk in super().stream():
            self.size += len(chunk)
            held.size += len(chunk)
            # The rest of the body is not read: the connection closes after the response.
            if self.size > most:
                raise HTTPException(413, f"a request body may have at most {most} bytes", {"connection": "close"})
            # Small bodies are taken all the same: large ones that do not end keep nobody else from submitting.
            if held.size > _LARGE_BODIES * most and self.size > _SMALL_BYTES:
                message = f"bodies of requests take {_LARGE_BODIES * most} bytes already: try again in a second"
                raise HTTPException(503, message, {"connection": "close", "retry-after": "1"})
            yield chunk

    async def json(self) -> Any:
        body = await self.body()
        if len(body) <= _SMALL_BYTES:
            return parse_body(body)
        checks: RequestChecks = self.app.state.checks
        return await checks.run(partial(parse_body, body))


class PlainJsonRoute(APIRoute):
    """Route with a JSON body of bounded size, in which no key occurs twice."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Handler of the route, as FastAPI calls it."""
        handle = super().get_route_handler()

        async def handle_plain_json(request: Request) -> Response:
            plain = _PlainJsonRequest(request.scope, request.receive)
            try:
                return await handle(plain)
            finally:
                plain.app.state.bodies.size -= plain.size

        return handle_plain_json

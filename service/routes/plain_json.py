"""JSON bodies of requests: of bounded size, parsed once, and refused if a key is repeated.

JSON allows a key to occur twice in an object, and parsers differ on which one counts. Such a body is refused here.
"""

import json
from collections.abc import AsyncGenerator, Callable, Coroutine
from typing import Any

from fastapi import HTTPException, Request, Response
from fastapi.routing import APIRoute

from service.problems import MalformedBody


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for key, value in pairs:
        if key in result:
            raise MalformedBody(422, f"the key {key!r} stands twice in one object: which one is meant?")
        result[key] = value
    return result


class _PlainJsonRequest(Request):
    async def stream(self) -> AsyncGenerator[bytes]:
        most, size = self.app.state.settings.max_body_bytes, 0
        async for chunk in super().stream():
            size += len(chunk)
            if size > most:
                # The rest of the body is not read: the connection closes after the response.
                raise HTTPException(413, f"a request body may have at most {most} bytes", {"connection": "close"})
            yield chunk

    async def json(self) -> Any:
        try:
            return json.loads(await self.body(), object_pairs_hook=_unique)
        except RecursionError:
            raise MalformedBody(400, "nested too deeply to be any request") from None


class PlainJsonRoute(APIRoute):
    """Route with a JSON body of bounded size, in which no key occurs twice."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Handler of the route, as FastAPI calls it."""
        handle = super().get_route_handler()

        async def handle_plain_json(request: Request) -> Response:
            return await handle(_PlainJsonRequest(request.scope, request.receive))

        return handle_plain_json

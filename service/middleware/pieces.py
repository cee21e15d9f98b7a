"""Long answers in pieces, so that compressing and sending one does not keep the event loop from all others."""

import asyncio

from starlette.types import Message, Receive, Scope, Send

from service.middleware.of_http import OfHttp

_LONG_BYTES, _PIECE_BYTES = 1 << 18, 1 << 16
# A client that takes longer for one piece has gone, or means to hold the answer in memory.
_SECONDS_FOR_A_PIECE = 30.0


class Pieces(OfHttp):
    """ASGI middleware that sends long bodies piece by piece."""

    async def answer(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, and its answer back in pieces."""

        async def send_pieces(message: Message) -> None:
            body = message.get("body", b"")
            if message["type"] != "http.response.body" or len(body) <= _LONG_BYTES:
                await send(message)
                return
            for begin in range(0, len(body), _PIECE_BYTES):
                last = begin + _PIECE_BYTES >= len(body)
                piece = {
                    "type": "http.response.body",
                    "body": body[begin : begin + _PIECE_BYTES],
                    "more_body": not last or message.get("more_body", False),
                }
                async with asyncio.timeout(_SECONDS_FOR_A_PIECE):
                    await send(piece)
                await asyncio.sleep(0)

        await self.app(scope, receive, send_pieces)

"""Requests as the routes take them: HEAD as GET, and the encodings of an answer as their weights say."""

from starlette.types import Message, Receive, Scope, Send

from service.middleware.of_http import OfHttp

# A stream has no end, so its head is all that could be waited for.
_STREAM = "/events"


class PlainRequests(OfHttp):
    """ASGI middleware that passes HEAD on as GET, and gzip only where it is accepted.

    The server sends no body in answer to HEAD. Starlette takes ``gzip;q=0`` for a wish.
    """

    async def answer(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on."""
        scope["headers"] = [_as_understood(name, value) for name, value in scope["headers"]]
        if scope["method"] != "HEAD" or scope["path"].endswith(_STREAM):
            await self.app(scope, receive, send)
            return
        as_get = {**scope, "method": "GET"}

        async def send_head(message: Message) -> None:
            # What the route is called is told to the middleware outside.
            scope.update({name: as_get[name] for name in ("route",) if name in as_get})
            await send(message)

        await self.app(as_get, receive, send_head)


def _as_understood(name: bytes, value: bytes) -> tuple[bytes, bytes]:
    if name.lower() != b"accept-encoding":
        return name, value
    return name, b"gzip" if accepts_gzip(value.decode("latin-1")) else b"identity"


def accepts_gzip(accepted: str) -> bool:
    """Whether a header Accept-Encoding accepts gzip (RFC 9110, section 12.5.3).

    Parameters
    ----------
    accepted : str

    Returns
    -------
    bool

    Examples
    --------
    >>> [accepts_gzip(each) for each in ("gzip, br", "gzip;q=0", "*;q=0.5", "identity", "")]
    [True, False, True, False, False]
    """
    weights = {}
    for each in accepted.lower().split(","):
        coding, *parameters = (part.strip() for part in each.split(";"))
        weight = next((part[2:] for part in parameters if part.startswith("q=")), "1")
        weights[coding] = weight.strip("0.") != ""
    return weights.get("gzip", weights.get("x-gzip", weights.get("*", False)))

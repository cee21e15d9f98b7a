"""Headers that restrict what browsers do with responses."""

from starlette.datastructures import MutableHeaders
from starlette.types import Message, Receive, Scope, Send

from service.middleware.of_http import OfHttp

_NOTHING = "default-src 'none'; frame-ancestors 'none'"
# The page of the API loads only its own files. Swagger UI sets `style` attributes and draws icons from data.
_DOCS = (
    "default-src 'self'; img-src 'self' data:; style-src 'self' 'unsafe-inline'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
# The explorer loads only its own files. It creates pictures itself (blob, data) and uses no `style` attributes.
_EXPLORER = (
    "default-src 'self'; img-src 'self' blob: data:; style-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
_PAGES = {"/": _EXPLORER, "/docs": _DOCS}


def _policy_of(scope: Scope) -> str:
    policy, framed_by = _PAGES.get(scope["path"], _NOTHING), scope["app"].state.settings.framed_by
    if policy is _EXPLORER and framed_by is not None:
        return policy.replace("frame-ancestors 'none'", f"frame-ancestors {framed_by}")
    return policy


class SecurityHeaders(OfHttp):
    """ASGI middleware that adds the security headers to every response.

    Responses are private: shared caches do not store them. A client's own cache may store a response that has an ETag,
    and revalidates it.
    """

    async def answer(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on and add the headers to its response."""

        async def send_guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                headers["x-content-type-options"] = "nosniff"
                headers["referrer-policy"] = "no-referrer"
                # A page that is a result says itself what it needs.
                headers.setdefault("content-security-policy", _policy_of(scope))
                headers.setdefault("cache-control", "private, no-cache" if "etag" in headers else "no-store")
            await send(message)

        await self.app(scope, receive, send_guarded)

"""The frame of a middleware of this service."""

from abc import ABC, abstractmethod

from starlette.types import ASGIApp, Receive, Scope, Send


class OfHttp(ABC):
    """ASGI middleware for requests of HTTP; all else passes by.

    Parameters
    ----------
    app : ASGI application
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or pass on."""
        await (self.answer if scope["type"] == "http" else self.app)(scope, receive, send)

    @abstractmethod
    async def answer(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, and its answer back."""

"""Uvicorn, with connections that are bounded, a word when it is ready, and streams that end when it stops."""

import asyncio
import socket
from collections.abc import Callable
from functools import partial

import uvicorn
from fastapi import FastAPI

from service.middleware.bounded_connection import BoundedConnection, Bounds
from service.settings import Settings

_STOP_SECONDS = 2


def address(host: str, port: int) -> str:
    """Address of what listens on a host's port."""
    return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"


def refusal_to_listen(host: str, port: int) -> OSError | None:
    """Why nothing can listen on a host's port, as where another program does; None where it can.

    Asked before anything is started, as a service takes long to find it out for itself.
    """
    try:
        for family, kind, protocol, _, place in socket.getaddrinfo(host, port, type=socket.SOCK_STREAM):
            with socket.socket(family, kind, protocol) as listener:
                # As the server does: what was closed a moment ago is no hindrance.
                listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                if family == socket.AF_INET6:
                    listener.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
                listener.bind(place)
                listener.listen()
    except OSError as error:
        return error
    return None


class Server(uvicorn.Server):
    """A server of one application.

    Parameters
    ----------
    app : FastAPI
    settings : Settings
    on_ready : callable, optional
        Called with the service's address, once, when database, scheduler and workers answer.
    """

    def __init__(self, app: FastAPI, settings: Settings, on_ready: Callable[[str], None] | None = None) -> None:
        bounds = Bounds(settings.max_connections, settings.request_seconds, settings.max_body_bytes)
        super().__init__(
            uvicorn.Config(
                app, host=settings.host, port=settings.port, ws="none", lifespan="on",
                http=partial(BoundedConnection, bounds),  # type: ignore[arg-type]
                log_config=None, access_log=False, server_header=False, proxy_headers=False,
                timeout_graceful_shutdown=_STOP_SECONDS,
            )
        )  # fmt: skip
        self._app, self._on_ready = app, on_ready
        self._getting_ready: asyncio.Task[None] | None = None

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start to listen, and say so once everything that is needed answers."""
        await super().startup(sockets)
        if self._on_ready is not None:
            self._getting_ready = asyncio.create_task(self._say_when_ready(self._on_ready))

    async def _say_when_ready(self, say: Callable[[str], None]) -> None:
        await self._app.state.probes.until_ready()
        # The port as it is: port 0 asks for any that is free.
        say(address(self.config.host, self.servers[0].sockets[0].getsockname()[1]))

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Stop; streams of events end first, and their clients come back with where they were."""
        if self._getting_ready is not None:
            self._getting_ready.cancel()
        self._app.state.feed.close()
        await super().shutdown(sockets)

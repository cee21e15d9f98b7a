"""Uvicorn with its own limits. It says when it is ready, and ends streams when the service stops."""

import asyncio
import socket
import sys
from collections.abc import Callable

import uvicorn
from fastapi import FastAPI

from service.bounded_connection import BoundedConnection
from service.settings import Settings

_STOP_SECONDS = 2
# Threads that check requests compute in Python. The event loop waits for some turns of theirs whenever it wakes up.
_TURN_SECONDS = 0.001


def address(host: str, port: int) -> str:
    """URL of a server on a host's port."""
    return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"


def refusal_to_listen(host: str, port: int) -> OSError | None:
    """The error of listening on a host's port, for example because another program does; None if the port is free.

    Checked before anything is started, because the service itself would notice much later.
    """
    try:
        for family, kind, protocol, _, place in socket.getaddrinfo(host, port, type=socket.SOCK_STREAM):
            with socket.socket(family, kind, protocol) as listener:
                # As the server does: a socket closed a moment ago is no obstacle.
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

    It limits the size of request heads and the number of connections. Slow clients are left to the proxy: see
    `docs/operations/README.md`.

    Parameters
    ----------
    app : FastAPI
    settings : Settings
    on_ready : callable, optional
        Called with the service's address, once, when database, scheduler and workers answer.
    """

    def __init__(self, app: FastAPI, settings: Settings, on_ready: Callable[[str], None] | None = None) -> None:
        super().__init__(
            uvicorn.Config(
                app, host=settings.host, port=settings.port, ws="none", lifespan="on",
                http=BoundedConnection, limit_concurrency=settings.max_connections,
                log_config=None, access_log=False, server_header=False,
                proxy_headers=settings.trusted_proxies is not None, forwarded_allow_ips=settings.trusted_proxies or "",
                timeout_graceful_shutdown=_STOP_SECONDS,
            )
        )  # fmt: skip
        self._app, self._on_ready = app, on_ready
        self._getting_ready: asyncio.Task[None] | None = None

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start to listen, and call `on_ready` once everything needed is ready."""
        sys.setswitchinterval(_TURN_SECONDS)
        await super().startup(sockets)
        if self._on_ready is not None:
            self._getting_ready = asyncio.create_task(self._say_when_ready(self._on_ready))

    async def _say_when_ready(self, say: Callable[[str], None]) -> None:
        await self._app.state.probes.until_ready()
        # The actual port: port 0 requests any free one.
        say(address(self.config.host, self.servers[0].sockets[0].getsockname()[1]))

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Stop. Event streams end first; their clients reconnect and continue where they were."""
        if self._getting_ready is not None:
            self._getting_ready.cancel()
        self._app.state.feed.close()
        await super().shutdown(sockets)

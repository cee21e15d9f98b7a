"""HTTP connections that hold a bounded part of the service's memory for a bounded time.

Uvicorn waits for ever for a request that never ends, keeps as many headers as are sent, and holds what nobody reads.
Here a request has to arrive whole within some time, its head within a size, an answer has to be read at some pace, and
there are only so many connections. Memory is then at most (connections) x (largest body + largest answer).
"""

import asyncio
from dataclasses import dataclass
from typing import Any

from uvicorn.protocols.http.httptools_impl import STATUS_LINE, HttpToolsProtocol

from service.errors import problem

_HEAD_BYTES = 65_536
# Chunks of one byte take six on the wire.
_BYTES_A_BYTE = 8
# Requests sent ahead of their answers: uvicorn reads on with every answer, however many wait already.
_PIPELINED = 64
_READ_SECONDS = 30.0
_READ_BYTES = 32_768


@dataclass(frozen=True)
class Bounds:
    """Of a connection; and of all of them, how many there may be."""

    connections: int
    request_seconds: float
    body_bytes: int


class BoundedConnection(HttpToolsProtocol):
    """One connection.

    Parameters
    ----------
    bounds : Bounds
    options : Any
        As uvicorn gives them.
    """

    def __init__(self, bounds: Bounds, **options: Any) -> None:
        super().__init__(**options)
        self.bounds = bounds
        self._deadline: asyncio.TimerHandle | None = None
        self._reading: asyncio.TimerHandle | None = None
        self._received, self._head_ended = 0, False

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Take a connection, or say that there are too many."""
        super().connection_made(transport)
        if len(self.connections) > self.bounds.connections:
            self._refuse(503, "too-many-connections", "the service has as many connections as it can; try again later")
        else:
            self._await_request()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget a connection."""
        for timer in (self._deadline, self._reading):
            if timer is not None:
                timer.cancel()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Take what has come, as long as the request is within its bounds."""
        if self.transport.is_closing():
            return
        if self._deadline is None:
            self._await_request()
        self._received += len(data)
        if self._received > _HEAD_BYTES + _BYTES_A_BYTE * self.bounds.body_bytes:
            self._refuse(413, "body-too-large", f"a request body may have at most {self.bounds.body_bytes} bytes")
            return
        super().data_received(data)
        # What has come at once may hold a whole head and a part of the body: only what is still no head is too large.
        if not self._head_ended and self._received > _HEAD_BYTES:
            self._refuse(431, "head-too-large", f"the head of a request may have at most {_HEAD_BYTES} bytes")

    def on_message_begin(self) -> None:
        """Begin a request, also one that came with the end of another."""
        super().on_message_begin()
        if self._deadline is None:
            self._await_request()

    def on_headers_complete(self) -> None:
        """End a head."""
        self._head_ended = True
        super().on_headers_complete()
        if len(self.pipeline) > _PIPELINED:
            raise RuntimeError("the parser stops at whatever is raised here, and the request is refused")

    def on_message_complete(self) -> None:
        """End a request."""
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None
        self._received, self._head_ended = 0, False
        super().on_message_complete()

    def _await_request(self) -> None:
        self._deadline = self.loop.call_later(self.bounds.request_seconds, self._too_slow)

    def _too_slow(self) -> None:
        self._refuse(408, "too-slow", f"a request has to arrive within {self.bounds.request_seconds:g} s")

    def send_400_response(self, msg: str) -> None:
        """Refuse what is no HTTP."""
        self._refuse(400, "malformed-request", "this is no HTTP request")

    def _refuse(self, status: int, kind: str, detail: str) -> None:
        if self.transport.is_closing():
            return
        if self.cycle is not None and not self.cycle.response_complete:
            if self.cycle.response_started:
                self.transport.abort()  # an answer is under way: nothing can be said in the middle of it
                return
            self.cycle.disconnected = True
            self.cycle.message_event.set()
        response = problem(status, kind, detail, "")
        head = [*self.server_state.default_headers, *response.raw_headers, (b"connection", b"close")]
        lines = [name + b": " + value + b"\r\n" for name, value in head]
        self.transport.write(STATUS_LINE[status] + b"".join(lines) + b"\r\n" + bytes(response.body))
        self._end()

    def _end(self) -> None:
        """Close, and at the latest after some time also where nobody reads what is left to say."""
        self.transport.close()
        self.loop.call_later(_READ_SECONDS, self.transport.abort)

    def timeout_keep_alive_handler(self) -> None:
        """Close a connection that nobody has used for a while."""
        if not self.transport.is_closing():
            self._end()

    def pause_writing(self) -> None:
        """Wait for the client to read."""
        super().pause_writing()
        self._watch_reader(self.transport.get_write_buffer_size())

    def resume_writing(self) -> None:
        """Go on: the client has read."""
        if self._reading is not None:
            self._reading.cancel()
            self._reading = None
        super().resume_writing()

    def _watch_reader(self, waiting: int) -> None:
        self._reading = self.loop.call_later(_READ_SECONDS, self._look_at_reader, waiting)

    def _look_at_reader(self, waiting: int) -> None:
        left = self.transport.get_write_buffer_size()
        if left > waiting - _READ_BYTES:
            self.transport.abort()
        else:
            self._watch_reader(left)

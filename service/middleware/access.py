"""One log line and one observation of the metrics for every response."""

import logging
import time

from starlette.types import Message, Receive, Scope, Send

from service.logs import ACCESS_LOG
from service.middleware import metrics
from service.middleware.of_http import OfHttp

_log = logging.getLogger(ACCESS_LOG)
# Monitors request these every few seconds: liveness, readiness and metrics.
_ROUTINE = frozenset({"/healthz", "/readyz", "/metrics"})
_METHODS = ("GET", "HEAD", "POST", "DELETE", "PUT", "PATCH", "OPTIONS")


class Access(OfHttp):
    """ASGI middleware that records each request with its caller and its response."""

    async def answer(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on and record its response."""
        begin = time.perf_counter()
        status = 0

        async def send_observed(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                _observe(scope, status, time.perf_counter() - begin)
            await send(message)

        try:
            await self.app(scope, receive, send_observed)
        except Exception:
            if not status:
                status = 500
                _observe(scope, status, time.perf_counter() - begin)
            raise
        finally:
            _write(scope, status, time.perf_counter() - begin)


def _observe(scope: Scope, status: int, seconds: float) -> None:
    # Labels must be few: route templates and known methods, not the paths and methods that clients send.
    route = getattr(scope.get("route"), "path", "none")
    metrics.record_answer(scope["method"] if scope["method"] in _METHODS else "other", route, status, seconds)


def _write(scope: Scope, status: int, seconds: float) -> None:
    level = logging.DEBUG if scope["path"] in _ROUTINE else logging.INFO
    if not _log.isEnabledFor(level):
        return
    caller = scope.get("state", {}).get("caller")
    # The path as sent, percent-encoded: a line break in it does not end the log line.
    path = scope.get("raw_path", b"").decode("latin-1")
    fields = {
        "method": scope["method"], "path": path, "status": status, "milliseconds": round(1000 * seconds, 1),
        "key": caller.name if caller else None, "client": scope["client"][0] if scope.get("client") else None,
    }  # fmt: skip
    who = fields["key"] or "nobody"
    _log.log(level, "%s %s %s %d in %.1f ms", who, fields["method"], path, status, fields["milliseconds"], extra=fields)

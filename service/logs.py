"""Log lines that say which job they are about: readable ones, or JSON, one object a line."""

import contextlib
import contextvars
import json
import logging
import logging.config
import threading
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from enum import StrEnum

_job: contextvars.ContextVar[str | None] = contextvars.ContextVar("job", default=None)
ACCESS_LOG = "rattle.access"
_LATE_SECONDS = 0.25
_FIELDS = ("method", "path", "status", "milliseconds", "key", "client")


class LogFormat(StrEnum):
    """How lines are written."""

    PLAIN = "plain"
    JSON = "json"


@contextlib.contextmanager
def about_job(job_id: str) -> Iterator[None]:
    """All that this thread logs in the meantime is about a job."""
    token = _job.set(job_id)
    try:
        yield
    finally:
        _job.reset(token)


class _Plain(logging.Formatter):
    def __init__(self) -> None:
        super().__init__("%(asctime)s %(levelname)s %(name)s: %(message)s")

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802
        job = _job.get()
        return super().formatMessage(record) + (f" [job {job}]" if job else "")


class _Json(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        line = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
            "job": _job.get(),
        }
        line |= {field: getattr(record, field) for field in _FIELDS if hasattr(record, field)}
        if record.exc_info:
            line["traceback"] = self.formatException(record.exc_info)
        return json.dumps({name: value for name, value in line.items() if value is not None})


class _Gathering(logging.StreamHandler):
    """Writes the lines of answers a quarter of a second late, many at once, and all others with those before them.

    To write each by itself would give up Python's lock in the loop that answers, three hundred times a second.
    """

    def __init__(self) -> None:
        super().__init__()
        self._lines: list[str] = []
        threading.Thread(target=self._write_now_and_then, name="rattle-log", daemon=True).start()

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a line, and write what is kept unless it is that of an answer."""
        try:
            self._lines.append(self.format(record) + self.terminator)
            if record.name != ACCESS_LOG:
                self.flush()
        except Exception:
            self.handleError(record)

    def flush(self) -> None:
        """Write what is kept, in order.

        Under the handler's own lock, which whoever logs has already: with another one beside it, a line that came while
        the thread wrote would stop both for ever.
        """
        self.acquire()
        try:
            lines, self._lines = self._lines, []
            if lines:
                self.stream.write("".join(lines))
            super().flush()
        finally:
            self.release()

    def _write_now_and_then(self) -> None:
        while True:
            time.sleep(_LATE_SECONDS)
            self.flush()


def write_logs(form: LogFormat, level: str) -> None:
    """Write to standard error what this service logs from some level on, and what is wrong with what it uses."""
    handler = _Gathering()
    handler.setFormatter(_Json() if form is LogFormat.JSON else _Plain())
    logging.basicConfig(handlers=[handler], level=logging.WARNING, force=True)
    logging.getLogger("rattle").setLevel(level.upper())
    # What clients send that is no HTTP is answered, and no fault of ours.
    logging.getLogger("uvicorn.error").setLevel(logging.ERROR)

"""Requests that are too large are refused before anything is done that takes time in proportion to them."""

from typing import Any, Protocol

from service.errors import LimitExceeded
from service.settings import Settings
from worker.job import Job


class JobRequest(Protocol):
    """A request for a job, of any kind."""

    def sizes(self) -> tuple[tuple[str, float, str], ...]:
        """What is large about the request: in words, how large, and the setting that bounds it."""

    def to_job(self) -> Job:
        """Job that it asks for."""


def check_size(request: JobRequest, settings: Settings) -> None:
    """Refuse a request that exceeds a limit.

    Raises
    ------
    LimitExceeded
        Naming the limit, by its setting.
    """
    for what, size, limit in request.sizes():
        most: Any = getattr(settings, limit)
        if size > most:
            raise LimitExceeded(f"{size} {what} are more than the limit of {most} (RATTLE_{limit.upper()})")

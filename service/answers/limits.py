"""Refuses requests that are too large, before any work that grows with their size."""

from functools import partial
from typing import Any

from service.errors import LimitExceeded
from service.settings import Settings
from worker.jobs.job import Job


def job_from(job_class: type[Job], body: dict[str, Any], settings: Settings) -> Job:
    """Job that a body describes, if it is within the limits.

    Parameters
    ----------
    job_class : type
        Class of the job's kind.
    body : dict
        Request as JSON.
    settings : Settings

    Returns
    -------
    Job

    Raises
    ------
    InvalidJob, OutsideDomain, LimitExceeded
        Naming the field at fault, or the limit.
    """
    return job_class.from_request(body, partial(_check_size, settings=settings))


def _check_size(job: Job, settings: Settings) -> None:
    for what, size, limit in job.sizes():
        most: Any = getattr(settings, limit)
        if size > most:
            raise LimitExceeded(f"{size} {what} are more than the limit of {most} (RATTLE_{limit.upper()})")

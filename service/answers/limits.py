"""Refuses requests that are too large, before any work that grows with their size."""

from functools import partial
from typing import Any

from service.errors import LimitExceeded
from service.models.machines import in_model
from service.settings import Settings
from worker.estimate import estimate
from worker.jobs.job import Job
from worker.machine_series import settled_with_machine


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
    body = in_model(body, job_class)
    job = settled_with_machine(job_class.from_request(body, partial(_check_size, settings=settings)))
    expected = estimate(job, settings.workers, measuring=False)  # nothing is compiled while a client waits
    if expected.seconds > 3600.0 * settings.max_hours:
        most = f"the limit of {settings.max_hours:g} hours (RATTLE_MAX_HOURS)"
        raise LimitExceeded(f"this takes {expected} on {settings.workers} workers: more than {most}")
    return job


def settled_job(job_class: type[Job], body: dict[str, Any], settings: Settings) -> Job:
    """As `job_from`, with all computed that its record needs, and without the values of ranges.

    Parameters
    ----------
    job_class : type
    body : dict
    settings : Settings

    Returns
    -------
    Job

    Raises
    ------
    InvalidJob, OutsideDomain, LimitExceeded
    """
    job = job_from(job_class, body, settings)
    assert job.digest
    # A million values take 50 MB. They are made anew where they are needed.
    job.__dict__.pop("vary", None)
    return job


def _check_size(job: Job, settings: Settings) -> None:
    for what, size, limit in job.sizes():
        most: Any = getattr(settings, limit)
        if size > most:
            raise LimitExceeded(f"{size} {what} are more than the limit of {most} (RATTLE_{limit.upper()})")

"""What routes are given: the settings, the job records, the runner."""

from typing import Annotated

from fastapi import Depends, Request

from service.jobs import Jobs
from service.runner import Runner
from service.settings import Settings


def _settings(request: Request) -> Settings:
    settings: Settings = request.app.state.settings
    return settings


def _jobs(request: Request) -> Jobs:
    jobs: Jobs = request.app.state.jobs
    return jobs


def _runner(request: Request) -> Runner:
    runner: Runner = request.app.state.runner
    return runner


def _submitter() -> str:
    return LOCAL


LOCAL = "local"
"""Who submits where the doors are open."""
SettingsHere = Annotated[Settings, Depends(_settings)]
JobsHere = Annotated[Jobs, Depends(_jobs)]
RunnerHere = Annotated[Runner, Depends(_runner)]
SubmitterHere = Annotated[str, Depends(_submitter)]


def problems(**details: str) -> dict[int | str, dict[str, object]]:
    """Declare problem documents a route can answer with: ``problems(s404="no such job")``."""
    return {
        int(status[1:]): {"description": detail, "content": {"application/problem+json": {"schema": _PROBLEM}}}
        for status, detail in details.items()
    }


_PROBLEM = {"$ref": "#/components/schemas/Problem"}

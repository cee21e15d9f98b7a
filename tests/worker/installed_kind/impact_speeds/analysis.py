from typing import Literal

import numpy as np
from impact_speeds.job import ImpactSpeedsJob
from pydantic import Field

from rattle_kernels import time_history
from worker.analyses.analysis import Analysis, AnalysisView, Piece, ready_of
from worker.progress import Stage
from worker.stores.layout import Variable

NOTHING = {"impact_time": np.empty(0), "wall": np.empty(0, np.int8), "impact_speed": np.empty(0)}


class ImpactSpeedsView(AnalysisView):
    """Summary of the impacts of a motion."""

    kind: Literal["impact_speeds"]
    impacts: int
    fastest: float = Field(description="Speed of the hardest")


def follow(oscillator, phase, speed, periods, *, pause):
    """Impacts of the motion."""
    pause()
    contacts = time_history(oscillator, phase, oscillator.half_backlash, -speed, periods=float(periods)).contacts
    return {"impact_time": contacts.time, "wall": contacts.wall.astype(np.int8), "impact_speed": contacts.speed}


def plan(job, parts):
    """One piece."""
    piece = Piece("impacts", follow, (job.oscillator, job.phase, job.speed, job.periods))
    return ready_of(Stage.SEARCHING, [piece], parts)


def layout(job):
    """An impact a row."""
    return (
        Variable("impact_time", ("impact",), np.float64, np.inf, "when"),
        Variable("wall", ("impact",), np.int8, 0, "which"),
        Variable("impact_speed", ("impact",), np.float64, np.inf, "how fast"),
    )


def summarise(job, columns):
    """How many, and the hardest."""
    speeds = columns["impact_speed"]
    return {"impacts": int(speeds.size), "fastest": float(speeds.max(initial=0.0))}


def draw(job, columns, figure):
    """Speeds over time."""
    figure.subplots().plot(columns["impact_time"], columns["impact_speed"], ".")


IMPACT_SPEEDS = Analysis(
    "Impact speeds of a rattling gear pair",
    ImpactSpeedsJob,
    plan,
    lambda job, parts: parts["impacts"] if "impacts" in parts else NOTHING,
    layout,
    summarise,
    ImpactSpeedsView,
    draw,
)

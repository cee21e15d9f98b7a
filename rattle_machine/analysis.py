"""A report as a job: a basin, a sweep over speed, a production machine by machine, and a page that is made of all.

The basin and the sweep are computed as any other, tile by tile, into stores below the report's own, among its parts.
When the page is there, the parts are removed. So what is left is small, and after any interruption only what is missing
is computed.
"""

import math
from collections.abc import Iterator
from typing import Any, Literal

import numpy as np
from matplotlib.figure import Figure
from numpy import float64
from pydantic import BaseModel, Field

from rattle.results.opening import open
from rattle_kernels.numerics.pausing import Pause
from rattle_machine.job import ReportJob
from rattle_machine.numbers import RPM
from rattle_machine.page import Findings
from rattle_machine.proven import Proven
from rattle_machine.pulses import follow, rate_in_si
from rattle_machine.tolerances import Question, Range, blocks_of
from worker.analyses.analysis import Analysis, AnalysisView, Parts, Piece, Plan, in_order
from worker.basins.pipeline import basin_runs
from worker.cluster.driver import Driver
from worker.fence import Fence
from worker.progress import Stage
from worker.results.summary import FiniteOrNone
from worker.run import Run
from worker.stores.analysis_store import PARTS, AnalysisStore, StoredParts
from worker.stores.layout import NOT_THERE, Columns, Variable
from worker.stores.table import Column, Table

_A_MACHINE = "A gear pair"
_PAGE, _BASIN, _SWEEP = "page", "basin", "sweep"
_FIRST, _THEN = "machines-", "narrower-"
_DOES, _PROOF = "does", "proof"
SPEEDS = Table("speed", (
    Column("speed", float64, "mean speed of the driven shaft", attributes={"units": "rad/s"}),
    Column("quiet_share", float64, "share of departures that end in quiet", attributes={"units": "1"}),
    Column("impact_power_w", float64, "expected impact power", attributes={"units": "W"}),
    Column("gamma", float64, "inertia torque over drag torque", attributes={"units": "1"}),
))  # fmt: skip
_BYTES = Variable("page", ("byte",), np.uint8, NOT_THERE, "the page, HTML in UTF-8")  # which never has a byte of 255
_ANSWERS = Variable("answer", ("answer",), str, "", "what the person who decides reads first")


class SpeedView(BaseModel):
    """What the machine does at one speed."""

    speed: float = Field(description="Of the driven shaft, rad/s")
    quiet_share: FiniteOrNone = Field(description="Of the departures of a sample, those that end in quiet")
    impact_power_w: FiniteOrNone = Field(description="Expected impact power, W")
    gamma: float = Field(description="Inertia torque over drag torque")


class ReportView(AnalysisView):
    """Summary of a report; the page itself is at ``/v1/jobs/{id}/report.html``."""

    kind: Literal["report"]
    answers: list[str] = Field(description="What the page says first; empty until it is there")
    speeds: list[SpeedView]


def page_in(columns: Any) -> bytes:
    """The page of a result's columns, or of its dataset: HTML in UTF-8."""
    return np.asarray(columns[_BYTES.name], np.uint8).tobytes()


def compute_machines(asked: Question, ranges: tuple[Range, ...], places: np.ndarray, *, pause: Pause) -> Columns:
    """What a block of machines of a production does."""
    return {_DOES: asked.machines_do(ranges, places, pause)}


def compute_proof(asked: Question, narrow: tuple[Range, ...] | None, *, pause: Pause) -> Columns:
    """What is proven of the production that is tightened, or is not."""
    proven = asked.prove(narrow, pause=pause)
    speeds = [math.nan if speed is None else speed for speed in (proven.speed, proven.model_speed)]
    return {"speeds": np.array(speeds), "reason": np.array([proven.reason or ""], object)}


def _proven_in(columns: Columns, *, tightened: bool) -> Proven:
    if reason := str(columns["reason"][0]):
        return Proven(None, None, reason, tightened)
    speed, model_speed = columns["speeds"].tolist()
    return Proven(speed, model_speed, None, tightened)


def compute_page(
    location: str, found: np.ndarray | None, then: np.ndarray | None, proven: Proven | None, *, pause: Pause
) -> Columns:
    """Follow the pulses, and put the page of the report at a location together."""
    job: Any = AnalysisStore.open(location).job
    pair, series = job.pair, job.over
    study = None if job.production is None or found is None else job.production.study(found, then, proven)
    pause()
    hit = None if job.pulses is None else follow(pair, rate_in_si(job.rate), job.pulses, pause)
    with open(_below(location, _BASIN)) as basin, open(_below(location, _SWEEP)) as over:
        pause()
        findings = Findings(pair, basin, over, hit, study)
        page = findings.page(job.title or _A_MACHINE).encode()
        columns = {
            "speed": np.array([each.speed for each in series.pairs]),
            "quiet_share": over.share.values[:, 0],
            "impact_power_w": over.rattle.loudness().expected_impact_power_w.values,
            "gamma": np.array([each.gamma for each in series.pairs]),
        }
    return columns | {_BYTES.name: np.frombuffer(page, np.uint8), _ANSWERS.name: np.array(findings.answers, object)}


def _below(location: str, name: str) -> str:
    """Where a store lies that is a part of the report's."""
    return f"{location}/{PARTS}/{name}"


def _all_of(parts: Parts, prefix: str) -> np.ndarray:
    return np.concatenate([part[_DOES] for part in in_order(parts, prefix)])


def _pieces(asked: Question, ranges: tuple[Range, ...], places: np.ndarray, prefix: str) -> list[Piece]:
    return [
        Piece(f"{prefix}{number:05d}", compute_machines, (asked, ranges, block))
        for number, block in enumerate(blocks_of(places))
    ]


def plan(job: ReportJob, parts: StoredParts) -> Plan:
    """What is to be done for a report.

    First the production; then the narrower one, once it is known which tolerance is guilty, and what is proven of it;
    the page comes last.
    """
    first: list[Piece] = []
    then: list[Piece] = []
    found = narrow_found = proven = None
    asked = job.production
    if asked is not None:
        first = _pieces(asked, asked.ranges, asked.places(), _FIRST)
        if all(piece.name in parts for piece in first):
            found = _all_of(parts, _FIRST)
            narrow = asked.narrowed(found)
            then = [] if narrow is None else _pieces(asked, narrow, asked.places_of_production(), _THEN)
            if then and all(piece.name in parts for piece in then):
                narrow_found = _all_of(parts, _THEN)
            if job.certain:
                then.append(Piece(_PROOF, compute_proof, (asked, narrow)))
                proven = _proven_in(parts[_PROOF], tightened=narrow is not None) if _PROOF in parts else None
    ready = [piece for piece in first + then if piece.name not in parts]
    page = Piece(_PAGE, compute_page, (parts.location, found, narrow_found, proven))
    done = sum(piece.name in parts for piece in (*first, *then, page))
    if not ready and _PAGE not in parts:
        ready = [page]
    return Plan(Stage.COMPUTING, tuple(ready), done, len(first) + len(then) + 1)


def assemble(job: ReportJob, parts: Parts) -> Columns:
    """What the last piece has put together; nothing before."""
    if _PAGE in parts:
        return parts[_PAGE]
    return SPEEDS.join([]) | {_BYTES.name: np.empty(0, np.uint8), _ANSWERS.name: np.empty(0, object)}


def layout(job: ReportJob) -> tuple[Variable, ...]:
    """Variables of the store: speeds, answers, bytes of the page."""
    return (*SPEEDS.variables, _ANSWERS, _BYTES)


def summarise(job: ReportJob, columns: Columns) -> dict[str, Any]:
    """What the page says first, and what the machine does over speed."""
    speeds = [SpeedView(**vars(row)) for row in SPEEDS.rows(columns)]
    return {"answers": [str(each) for each in columns[_ANSWERS.name]], "speeds": speeds}


def draw_speeds(job: ReportJob, columns: Columns, figure: Figure) -> None:
    """Draw the quiet share, the expected impact power and Gamma over speed."""
    own = job.pair.speed * RPM
    places = figure.subplots(3, sharex=True)
    named = {"quiet_share": "quiet share", "impact_power_w": "impact power (W)", "gamma": "Γ"}
    for axes, (name, text) in zip(places, named.items(), strict=True):
        axes.plot(np.asarray(columns["speed"]) * RPM, columns[name], marker=".", color="black")
        axes.axvline(own, color="grey", linestyle=":")
        axes.set_ylabel(text)
        axes.set_ylim(bottom=0.0)
        axes.grid(alpha=0.3)
    places[-1].set_xlabel("speed (rpm)")


class Reports(Analysis):
    """Reports: their basins come before their pieces, which read them."""

    def runs(self, job: Any, location: str, driver: Driver, fence: Fence) -> Iterator[Run]:
        """The basin, the sweep, and the pieces of a report; see `Analysis.runs`."""
        store = AnalysisStore.create_or_resume(location, self.title, job, fence)
        if not (store.complete or _PAGE in store.parts()):
            for name, own in ((_BASIN, job.basin), (_SWEEP, job.sweep)):
                yield from basin_runs(own, _below(location, name), driver, fence)
        yield from super().runs(job, location, driver, fence)


REPORT = Reports(
    "Report on a rattling gear pair", ReportJob, plan, assemble, layout, summarise, ReportView, draw_speeds
)

"""The kind of jobs that are reports: the entry point `report` of `rattle.kinds` names it."""

from typing import Any

from worker.kinds import analysis_kind


def _routes() -> Any:
    from rattle_machine.routes import router  # loads FastAPI, which only a service has

    return router


KIND = analysis_kind(
    "rattle_machine.analysis:REPORT",
    name="report", path="reports", title="Report",
    summary="Submit a report",
    description="Compute what a machine does, how loud, how often, and which tolerance is to blame: a page that "
    "prints, at `/v1/jobs/{job_id}/report.html` when the job has succeeded.\n\n"
    "The same request again answers with the same job. After a failure or a cancellation it makes a new one, which "
    "continues from what is there.",
    command="",  # `rattle report machine.toml` computes one
    job="rattle_machine.job:ReportJob", table="speed", routes=_routes,
)  # fmt: skip

"""The kind of jobs that are charts: the entry point `chart` of `rattle.kinds` names it."""

from worker.kinds import analysis_kind

KIND = analysis_kind(
    "rattle_chart.analysis:CHART",
    name="chart", path="charts", title="Chart of two parameters",
    summary="Submit a chart of two parameters",
    description="Find special points, their curves and points of codimension two in a window of two parameters, and "
    "what machines do there.\n\n"
    "The same request again answers with the same job. After a failure or a cancellation it makes a new one, which "
    "continues from what is there.",
    command="",  # `rattle chart --damping 0.75:0.78 ...` computes one
    job="rattle_chart.job:ChartJob", table="point",
)  # fmt: skip

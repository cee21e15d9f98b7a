from worker.kinds import analysis_kind

KIND = analysis_kind(
    "impact_speeds.analysis:IMPACT_SPEEDS",
    name="impact_speeds", path="impact-speeds", title="Impact speeds",
    summary="Submit impact speeds",
    description="List the impacts of one motion.",
    command="List the impacts of one motion with their speeds.",
    job="impact_speeds.job:ImpactSpeedsJob", table="impact",
)  # fmt: skip

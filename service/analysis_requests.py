"""The requests for analyses, by the kind of their jobs."""

from typing import Annotated, Literal

from pydantic import Field

from service.bifurcation_model import BifurcationRequest, BifurcationView

AnalysisKind = Literal["bifurcation"]
AnalysisRequest = BifurcationRequest
ANALYSIS_REQUESTS: dict[str, type[AnalysisRequest]] = {"bifurcation": BifurcationRequest}
AnalysisResult = Annotated[BifurcationView, Field(discriminator="kind")]

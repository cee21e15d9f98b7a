"""The requests for analyses, by the kind of their jobs."""

from typing import Annotated, Literal

from pydantic import Field

from service.bifurcation_model import BifurcationRequest, BifurcationView
from service.orbits_model import OrbitsRequest, OrbitsView

AnalysisKind = Literal["bifurcation", "orbits"]
AnalysisRequest = BifurcationRequest | OrbitsRequest
ANALYSIS_REQUESTS: dict[str, type[AnalysisRequest]] = {"bifurcation": BifurcationRequest, "orbits": OrbitsRequest}
AnalysisResult = Annotated[BifurcationView | OrbitsView, Field(discriminator="kind")]

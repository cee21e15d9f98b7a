"""The requests for analyses, by the kind of their jobs."""

from typing import Annotated, Literal

from pydantic import Field

from service.models.bifurcation import BifurcationRequest, BifurcationView
from service.models.grazing_curve import GrazingCurveRequest, GrazingCurveView
from service.models.manifold import ManifoldRequest, ManifoldView
from service.models.orbits import OrbitsRequest, OrbitsView

AnalysisKind = Literal["bifurcation", "orbits", "manifold", "grazing_curve"]
AnalysisRequest = BifurcationRequest | OrbitsRequest | ManifoldRequest | GrazingCurveRequest
ANALYSIS_REQUESTS: dict[str, type[AnalysisRequest]] = {
    "bifurcation": BifurcationRequest,
    "orbits": OrbitsRequest,
    "manifold": ManifoldRequest,
    "grazing_curve": GrazingCurveRequest,
}
AnalysisResult = Annotated[BifurcationView | OrbitsView | ManifoldView | GrazingCurveView, Field(discriminator="kind")]

"""Results of jobs of every kind over HTTP."""

from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import ConfigDict, Field

from service.models.analysis import AnalysisView
from service.models.basin_result import ResultView
from service.models.bifurcation import BifurcationView
from service.models.curves import GrazingCurveView, ManifoldView
from service.models.orbits import OrbitsView


class AnyAnalysisView(AnalysisView):
    """Summary of an analysis whose result has no description of its own."""

    model_config = ConfigDict(extra="allow")

    kind: str


ANALYSIS_VIEWS: dict[str, type[AnalysisView]] = {
    "bifurcation": BifurcationView,
    "orbits": OrbitsView,
    "manifold": ManifoldView,
    "grazing_curve": GrazingCurveView,
}
"""Described results, by kind."""

if TYPE_CHECKING:
    AnyResult = Any
else:
    AnyResult = ResultView | Annotated[reduce(or_, ANALYSIS_VIEWS.values()), Field(discriminator="kind")]

"""What would become of a request, without recording it: the same checks as a submission, and the bounds that hold."""

from typing import Any

from pydantic import BaseModel, Field, ValidationError

from rattle_kernels import (
    Oscillator,
    OutsideDomain,
    eccentricity_bound_quiet,
    eccentricity_bound_smooth_maxima,
    stiffness_bound,
)
from service.answers.limits import check_size
from service.errors import LimitExceeded
from service.models.models import BasinRequest, FieldError, SweepRequest
from service.problems import faults_of
from service.settings import Settings
from worker.errors import InvalidJob
from worker.jobs.oscillator_request import PIECEWISE_LINEAR


class BoundView(BaseModel):
    """Bound of one field of the oscillator, the others being as they are."""

    field: str
    above: float | None = Field(None, description="The value must be above this")
    below: float | None = Field(None, description="The value must be below this")
    why: str


class CheckView(BaseModel):
    """Whether a request would be accepted; if not, why, field by field."""

    accepted: bool
    errors: list[FieldError]
    applications: int | None = Field(description="Applications of the impact map at the most; null where refused")
    bounds: list[BoundView]


def check_request(body: dict[str, Any], settings: Settings) -> CheckView:
    """Check a request for a basin, or with ``vary`` for a sweep, as its submission would."""
    model = SweepRequest if "vary" in body else BasinRequest
    errors: list[FieldError] = []
    applications = None
    try:
        request = model.model_validate(body)
        check_size(request, settings)
        job = request.to_job()
        applications = request.places * job.basins * job.iterations
    except (ValidationError, LimitExceeded, OutsideDomain, InvalidJob) as error:
        errors = [FieldError(**fault) for fault in faults_of(error)]
    return CheckView(
        accepted=not errors, errors=errors, applications=applications, bounds=_bounds(body.get("oscillator"))
    )


def _bounds(oscillator: Any) -> list[BoundView]:
    """Bounds that follow from what is known of the oscillator; the defaults stand for what is not a number."""
    given = oscillator if isinstance(oscillator, dict) else {}
    stiff = given.get("model") == PIECEWISE_LINEAR
    names = ("damping", "half_backlash", "stiffness") if stiff else ("damping", "half_backlash")
    known = Oscillator(**{name: given[name] for name in names if _is_positive(given.get(name))})
    bounds = [
        BoundView(field="damping", above=0.0, why="damping is positive"),
        _eccentricity_bound(known, stiff and given.get("allow_no_quiet_solution") is not True),
        BoundView(field="half_backlash", above=0.0, why="the backlash is positive"),
    ]
    if stiff:
        why = "contacts ring only above damping²/8 (Eq. 35)"
        bounds.append(BoundView(field="stiffness", above=stiffness_bound(known), why=why))
    return bounds


def _eccentricity_bound(known: Oscillator, quiet: bool) -> BoundView:
    quietly, smoothly = eccentricity_bound_quiet(known), eccentricity_bound_smooth_maxima(known)
    if quiet and quietly < smoothly:
        return BoundView(field="eccentricity", below=quietly, why="beyond it there is no quiet solution (Eq. 3)")
    why = "beyond it freeplay has smooth maxima and the impact map is not defined (Eq. 8)"
    return BoundView(field="eccentricity", below=smoothly, why=why)


def _is_positive(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0.0 < value < 1e300

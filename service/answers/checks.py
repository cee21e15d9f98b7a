"""Check a request without recording it: the checks of a submission, and the bounds that apply."""

import math
from typing import Any

from pydantic import BaseModel, Field

from rattle_kernels import (
    Oscillator,
    OutsideDomain,
    damping_bound_quiet,
    eccentricity_bound_quiet,
    eccentricity_bound_smooth_maxima,
    stiffness_bound,
    stiffness_gap_quiet,
)
from service.answers.limits import job_from
from service.errors import LimitExceeded
from service.models.problems import FieldError
from service.problems import faults_of
from service.settings import Settings
from worker.errors import InvalidJob
from worker.estimate import estimate
from worker.jobs.oscillator_request import PIECEWISE_LINEAR
from worker.kinds import KINDS, kind_of


class BoundView(BaseModel):
    """Bound of one field of the oscillator, given the values of the others."""

    field: str
    above: float | None = Field(None, description="The value must be above this")
    below: float | None = Field(None, description="The value must be below this")
    loose_from: float | None = Field(
        None, description="From this value on inertia torque exceeds drag torque at times (Eq. 8)"
    )
    between: tuple[float, float | None] | None = Field(
        None, description="Values between these two are refused; null for the second: all above the first"
    )
    why: str


class CheckView(BaseModel):
    """Whether a request would be accepted; if not, why, field by field."""

    accepted: bool
    errors: list[FieldError]
    applications: int | None = Field(description="Most applications of the impact map; null if the request is refused")
    seconds: float | None = Field(description="Longest time it takes here, estimated; null if the request is refused")
    bytes: int | None = Field(description="Bytes of its store before compression; null if the request is refused")
    bounds: list[BoundView]


def check_request(body: dict[str, Any], settings: Settings) -> CheckView:
    """Check a request of any kind, as its submission would.

    It is of the kind that it names; without one it is a basin, or a sweep if it has ``vary`` or ``design``.

    Parameters
    ----------
    body : dict
    settings : Settings

    Returns
    -------
    CheckView
    """
    errors: list[FieldError] = []
    expected: dict[str, Any] = dict.fromkeys(("applications", "seconds", "bytes"))
    kind = kind_of(body)
    try:
        if not isinstance(kind, str) or kind not in KINDS:
            raise InvalidJob(f"there is no kind {kind!r}; there are {', '.join(KINDS)}", ("kind",))
        job = job_from(KINDS[kind].job_class, body, settings)
        expected = {"applications": job.impacts} | estimate(job, settings.workers, measuring=False)._asdict()
    except (LimitExceeded, OutsideDomain, InvalidJob) as error:
        errors = [FieldError(**fault) for fault in faults_of(error)]
    loose = isinstance(kind, str) and kind in KINDS and KINDS[kind].job_class.loose_gears
    bounds = _bounds(body.get("oscillator"), loose=loose)
    return CheckView(accepted=not errors, errors=errors, bounds=bounds, **expected)


def _bounds(oscillator: Any, *, loose: bool) -> list[BoundView]:
    """Bounds that follow from the numeric fields, as far as they are known without a search."""
    given = oscillator if isinstance(oscillator, dict) else {}
    stiff = given.get("model") == PIECEWISE_LINEAR
    names = ("damping", "half_backlash", "stiffness") if stiff else ("damping", "half_backlash")
    known = Oscillator(**{name: given[name] for name in names if _is_positive(given.get(name))})
    if _is_positive(given.get("eccentricity")):
        known = known._replace(eccentricity=given["eccentricity"])
    # With harmonics, or damping in contact, a bound takes a second.
    simple = not given.get("harmonics") and not (stiff and given.get("contact_damping"))
    demanded = stiff and given.get("allow_no_quiet_solution") is not True
    damping = BoundView(field="damping", above=0.0, why="damping is positive")
    backlash = BoundView(field="half_backlash", above=0.0, why="the backlash is positive")
    stiffness = BoundView(
        field="stiffness", above=stiffness_bound(known), why="contacts ring only above damping²/8 (Eq. 35)"
    )
    if simple and demanded:
        damping, stiffness = _quiet_damping(known) or damping, _quiet_stiffness(known, stiffness)
    eccentricity = [_eccentricity_bound(known, demanded, loose)] if simple else []
    return [damping, *eccentricity, backlash, *([stiffness] if stiff else [])]


def _eccentricity_bound(known: Oscillator, quiet: bool, loose: bool) -> BoundView:
    quietly, smoothly = eccentricity_bound_quiet(known), eccentricity_bound_smooth_maxima(known)
    if quiet and (loose or quietly < smoothly):
        return BoundView(field="eccentricity", below=quietly, why="beyond it there is no quiet solution (Eq. 3)")
    if loose:
        why = "from it on inertia torque exceeds drag torque in a part of every period (Eq. 8)"
        return BoundView(field="eccentricity", loose_from=smoothly, why=why)
    why = "beyond it inertia torque exceeds drag torque (Eq. 8), which is not followed here"
    return BoundView(field="eccentricity", below=smoothly, why=why)


def _quiet_damping(known: Oscillator) -> BoundView | None:
    bound = damping_bound_quiet(known)
    if not math.isfinite(bound):
        return None
    return BoundView(field="damping", above=bound, why="below it there is no quiet solution (Eq. 3)")


def _quiet_stiffness(known: Oscillator, bound: BoundView) -> BoundView:
    gap = stiffness_gap_quiet(known)
    if gap is None:
        return bound
    low, high = gap
    between = low, high if math.isfinite(high) else None
    return bound.model_copy(update={"between": between, "why": "between the two there is no quiet solution (Eq. 3)"})


def _is_positive(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0.0 < value < 1e300

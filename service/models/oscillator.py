"""The oscillator of a request: one of two models, told apart by ``model``, and what is checked at the door."""

import math
from collections.abc import Callable
from enum import StrEnum
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from rattle_kernels import Oscillator, OutsideDomain
from service.strict import Real, Request
from worker.jobs.oscillator_request import IMPACTING, PIECEWISE_LINEAR


class PermanentContact(StrEnum):
    """When a contact beyond +beta counts as permanent."""

    ENVELOPE = "envelope"
    """It provably never ends, as the ringing that is left cannot lift it off."""
    ONE_ROTATION = "one_rotation"
    """It lasts longer than one forcing period: the paper's shortcut."""

    @property
    def permanent_after(self) -> float:
        """Value of `Oscillator.permanent_after`."""
        return 1.0 if self is PermanentContact.ONE_ROTATION else math.inf


def demand_quiet(check: Callable[[], object], *, unless: bool) -> None:
    """Refuse what has no quiet solution (Eq. 3), unless that is allowed.

    Between epsilon_crit1 and epsilon_crit2 all is defined, but nothing stays quiet. Beyond epsilon_crit2 every
    oscillator is refused before.

    Parameters
    ----------
    check : callable
        Raises `OutsideDomain` where there is no quiet solution.
    unless : bool
        Whether the request allows that.

    Raises
    ------
    OutsideDomain
        Of `check`, with the way out named.
    """
    if unless:
        return
    try:
        check()
    except OutsideDomain as error:
        error.args = (f"{error}; allow_no_quiet_solution takes it all the same",)
        raise


class _Common(Request):
    """Parameters of the gear pair, nondimensional; the paper's by default."""

    damping: Real = Field(0.6, gt=0, description="delta")
    eccentricity: Real = Field(0.1, ge=0, description="epsilon, below the bound of Eq. (8)")
    half_backlash: Real = Field(0.6, gt=0, description="beta")


class ImpactingOscillator(_Common):
    """The impacting model: contacts are elastic impacts (Eqs. 4, 5)."""

    model: Literal["impacting"] = IMPACTING

    @property
    def allow_no_quiet_solution(self) -> bool:
        """Nothing to allow: the bounds of Eqs. (3) and (8) are one."""
        return False

    @model_validator(mode="before")
    @classmethod
    def _without_contacts(cls, value: Any) -> Any:
        if isinstance(value, dict):
            for name in value.keys() & (PiecewiseLinearOscillator.model_fields.keys() - cls.model_fields.keys()):
                raise ValueError(f'{name} belongs to the piecewise linear model: add "model": "piecewise_linear"')
        return value

    def to_oscillator(self) -> Oscillator:
        """Oscillator of the kernels; its only bound is that of Eq. (8), which they check."""
        return Oscillator(**self.model_dump(exclude={"model"}))


class PiecewiseLinearOscillator(_Common):
    """The piecewise linear model: contacts are linear springs (Eqs. 1, 2)."""

    model: Literal["piecewise_linear"]
    stiffness: Real = Field(gt=0, le=1e12, description="kappa, finite and above damping^2/8")
    permanent_contact: PermanentContact = Field(
        PermanentContact.ENVELOPE, description="When a contact counts as permanent: exactly, or by the paper's rule"
    )
    allow_no_quiet_solution: Annotated[bool, Field(strict=True)] = Field(
        False, description="Take an eccentricity beyond the bound of Eq. (3), where no quiet solution exists"
    )

    def to_oscillator(self) -> Oscillator:
        """Oscillator of the kernels, which check its bounds."""
        return Oscillator(
            self.damping, self.eccentricity, self.half_backlash, self.stiffness, self.permanent_contact.permanent_after
        )


def _model_of(value: Any) -> str | None:
    model = value.get("model", IMPACTING) if isinstance(value, dict) else getattr(value, "model", None)
    return model if isinstance(model, str) else None


OscillatorRequest = Annotated[
    Annotated[ImpactingOscillator, Tag(IMPACTING)] | Annotated[PiecewiseLinearOscillator, Tag(PIECEWISE_LINEAR)],
    Discriminator(
        _model_of,
        custom_error_type="oscillator_model",
        custom_error_message="send an object whose model is 'impacting' (the default) or 'piecewise_linear'",
    ),
]

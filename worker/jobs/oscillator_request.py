"""The oscillator of a request: one of two models, chosen by ``model``, with the paper's parameters by default."""

import math
from collections.abc import Callable, Mapping
from enum import StrEnum
from functools import cached_property
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, ConfigDict, Discriminator, Field, Tag, model_validator

from rattle_kernels import (
    AngleUnit,
    Forcing,
    Harmonic,
    Oscillator,
    OutsideDomain,
    TransmissionError,
    UnusableCurve,
    transmission_error,
)
from worker.errors import InvalidJob
from worker.jobs.request import INTEGRAL, Real, Request, accepting, as_real, in_schema

IMPACTING: Literal["impacting"] = "impacting"
PIECEWISE_LINEAR: Literal["piecewise_linear"] = "piecewise_linear"
_DEFAULT = Oscillator()
# What goes beyond the paper's model. Requests without it are what they were, and so are their digests.
_WIDER = ("restitution", "contact_damping", "harmonics")
_HIGHEST_ORDER = 1000
MOST_HARMONICS = 32
_MOST_SAMPLES = 10_000
BOTH_FORCINGS = "the forcing is given twice: give transmission_error, or eccentricity and harmonics"
_LEAST_SAMPLES = 3
_BY_ANGLE = Annotated[
    tuple[Real, ...], Field(max_length=_MOST_SAMPLES, fail_fast=True), in_schema(minItems=_LEAST_SAMPLES)
]
# A measured curve takes the place of both.
_ONE_FORCING: dict[str, Any] = {
    "if": {"properties": {"transmission_error": {"type": "object"}}, "required": ["transmission_error"]},
    "then": {"properties": {"eccentricity": False, "harmonics": False}},
}


class PermanentContact(StrEnum):
    """When a contact beyond +beta counts as permanent."""

    ENVELOPE = "envelope"
    """It provably never ends: the ringing that is left cannot lift it off."""
    ONE_ROTATION = "one_rotation"
    """It lasts longer than one forcing period. This is the paper's shortcut."""

    @property
    def permanent_after(self) -> float:
        """Value of `Oscillator.permanent_after`."""
        return 1.0 if self is PermanentContact.ONE_ROTATION else math.inf


class HarmonicRequest(Request):
    """A harmonic of the forcing beside the first: ``amplitude cos(2 pi (order t + phase))``."""

    order: Annotated[int, Field(strict=True, ge=2, le=_HIGHEST_ORDER), INTEGRAL] = Field(description="2 or more")
    amplitude: Real = Field(ge=0, description="as the eccentricity, which is that of the first order")
    phase: Real = Field(0.0, description="in periods of this harmonic")

    def at(self, values: Mapping[str, float]) -> "HarmonicRequest":
        """The harmonic with all fields named, at values of parameters of the oscillator."""
        amplitude = values.get(f"amplitude_{self.order}", self.amplitude)
        phase = values.get(f"phase_{self.order}", self.phase)
        return HarmonicRequest.model_construct(order=self.order, amplitude=amplitude, phase=phase)


def _harmonics_of(harmonics: tuple[Harmonic, ...]) -> tuple[HarmonicRequest, ...]:
    """Harmonics that Python gives, unchecked."""
    return tuple(
        HarmonicRequest.model_construct(order=int(order), amplitude=as_real(amplitude), phase=as_real(phase))
        for order, amplitude, phase in harmonics
    )


class TransmissionErrorRequest(Request):
    """A measured transmission error. In canonical form it is the eccentricity and the harmonics that are kept of it."""

    angle: _BY_ANGLE = Field(description="Increasing, over a revolution or more; one revolution is a forcing period")
    error: _BY_ANGLE = Field(description="As many; the mean is removed")
    unit: AngleUnit = Field(AngleUnit.TURNS, description="Of the angle")
    explained: Real = Field(
        0.99, gt=0, le=1, description="The kept orders are the fewest that explain this part of the variance"
    )
    scale: Annotated[Real, in_schema(**{"not": {"const": 0}})] = Field(
        1.0, description="Errors times this are in the units of half_backlash"
    )

    def to_forcing(self) -> Forcing:
        """Eccentricity and harmonics.

        Raises
        ------
        InvalidJob
            Naming the sample at fault, if it is one.
        """
        try:
            measured: TransmissionError = transmission_error(**dict(self))
        except UnusableCurve as error:
            place = () if error.sample is None else ("angle", error.sample)
            raise InvalidJob(str(error), ("transmission_error", *place)) from error
        if len(measured.harmonics) > MOST_HARMONICS:
            message = f"{len(measured.orders)} orders explain {self.explained:g}, which is more than {MOST_HARMONICS}"
            raise InvalidJob(f"{message}: lower explained", ("transmission_error", "explained"))
        return measured.forcing


class _Common(Request):
    """Parameters of the gear pair, nondimensional; the paper's by default."""

    model_config = ConfigDict(json_schema_extra=_ONE_FORCING)

    model: str
    damping: Real = Field(_DEFAULT.damping, gt=0, description="delta")
    eccentricity: Real = Field(_DEFAULT.eccentricity, ge=0, description="epsilon, amplitude of the first harmonic")
    half_backlash: Real = Field(_DEFAULT.half_backlash, gt=0, description="beta")
    harmonics: Annotated[tuple[HarmonicRequest, ...], Field(max_length=MOST_HARMONICS)] = Field(
        (), description="Harmonics of the forcing beside the first"
    )
    # Once read it is harmonics, and no longer a part of the request: equal forcings are equal requests.
    transmission_error: TransmissionErrorRequest | None = Field(
        None, description="A measured curve in place of eccentricity and harmonics"
    )

    @model_validator(mode="after")
    def _measured_as_harmonics(self) -> Self:
        if self.transmission_error is None:
            return self
        if self.model_fields_set & {"eccentricity", "harmonics"}:
            raise InvalidJob(BOTH_FORCINGS, ("transmission_error",))
        forcing = self.transmission_error.to_forcing()
        harmonics = _harmonics_of(forcing["harmonics"])
        self.__dict__.update(eccentricity=forcing["eccentricity"], harmonics=harmonics, transmission_error=None)
        given = self.model_fields_set - {"transmission_error"} | {"eccentricity", "harmonics"}
        object.__setattr__(self, "__pydantic_fields_set__", given)
        return self

    @property
    def _harmonics(self) -> tuple[Harmonic, ...]:
        return tuple(Harmonic(float(each.order), each.amplitude, each.phase) for each in self.harmonics)

    def settled(self, at: Mapping[str, float], *, quiet: bool) -> Self:
        """The oscillator in canonical form.

        Parameters
        ----------
        at : mapping of str to float
            Values of parameters that are swept.
        quiet : bool
            Whether it has a quiet solution (Eq. 3). If it has none, the request says that this is allowed.

        Returns
        -------
        ImpactingOscillator or PiecewiseLinearOscillator
        """
        fields = {name: at.get(name, getattr(self, name)) for name in type(self).model_fields}
        del fields["transmission_error"]
        fields["harmonics"] = tuple(each.at(at) for each in sorted(self.harmonics, key=lambda each: each.order))
        if quiet:
            fields.pop("allow_no_quiet_solution", None)
        for name in _WIDER:
            if fields.get(name) == getattr(_DEFAULT, name):
                del fields[name]
        settled: Any = type(self).model_construct(**fields)
        return settled


class ImpactingOscillator(_Common):
    """The impacting model: contacts are impacts (Eqs. 4, 5), elastic ones by default."""

    model: Literal["impacting"] = IMPACTING
    restitution: Real = Field(
        _DEFAULT.restitution, gt=0, le=1, description="r, by which an impact multiplies the speed; 1 is elastic"
    )

    @property
    def allow_no_quiet_solution(self) -> bool:
        """Always true: Eqs. (3) and (8) are one bound in this model, beyond which loose gears are followed."""
        return True

    @model_validator(mode="before")
    @classmethod
    def _without_contacts(cls, value: Any) -> Any:
        if isinstance(value, dict):
            for name in value.keys() & (PiecewiseLinearOscillator.model_fields.keys() - cls.model_fields.keys()):
                raise ValueError(f'{name} belongs to the piecewise linear model: add "model": "piecewise_linear"')
        return value

    @cached_property
    def value(self) -> Oscillator:
        """Oscillator of the kernels, which check the bound of Eq. (8)."""
        return Oscillator(
            self.damping, self.eccentricity, self.half_backlash, restitution=self.restitution, harmonics=self._harmonics
        )


class PiecewiseLinearOscillator(_Common):
    """The piecewise linear model: contacts are linear springs (Eqs. 1, 2)."""

    model: Literal["piecewise_linear"]
    stiffness: Real = Field(gt=0, le=1e12, description="kappa, finite and above damping^2/8")
    contact_damping: Real = Field(
        _DEFAULT.contact_damping, ge=0, lt=1, description="zeta, damping of the ringing in contact; 1 is critical"
    )
    permanent_contact: PermanentContact = Field(
        PermanentContact.ENVELOPE, description="When a contact counts as permanent: exactly, or by the paper's rule"
    )
    allow_no_quiet_solution: Annotated[bool, Field(strict=True)] = Field(
        False, description="Accept an eccentricity beyond the bound of Eq. (3), where no quiet solution exists"
    )

    @model_validator(mode="before")
    @classmethod
    def _without_impacts(cls, value: Any) -> Any:
        if isinstance(value, dict) and "restitution" in value:
            raise ValueError("restitution belongs to the impacting model: give contact_damping, or leave out the model")
        return value

    @cached_property
    def value(self) -> Oscillator:
        """Oscillator of the kernels, which check its bounds."""
        return Oscillator(
            self.damping, self.eccentricity, self.half_backlash, self.stiffness, self.permanent_contact.permanent_after,
            contact_damping=self.contact_damping, harmonics=self._harmonics,
        )  # fmt: skip


def _oscillator_of(oscillator: Oscillator) -> ImpactingOscillator | PiecewiseLinearOscillator:
    """An oscillator that Python gives, unchecked. It need not have a quiet solution."""
    names = ("damping", "eccentricity", "half_backlash", "stiffness", "restitution", "contact_damping")
    fields: dict[str, Any] = {name: as_real(getattr(oscillator, name)) for name in names}
    fields["harmonics"] = _harmonics_of(oscillator.harmonics)
    if math.isinf(oscillator.stiffness):
        return ImpactingOscillator.model_construct(**fields)
    exact = math.isinf(oscillator.permanent_after)
    rule = PermanentContact.ENVELOPE if exact else PermanentContact.ONE_ROTATION
    fields |= {"model": PIECEWISE_LINEAR, "permanent_contact": rule, "allow_no_quiet_solution": True}
    return PiecewiseLinearOscillator.model_construct(**fields)


def with_swept_stiffness(oscillator: Any) -> Any:
    """Give an oscillator whose stiffness is swept a placeholder if it has no stiffness of its own.

    Parameters
    ----------
    oscillator : object
        Oscillator of a request.

    Returns
    -------
    object
        The same oscillator, with a stiffness if its model is piecewise linear.
    """
    if isinstance(oscillator, dict) and oscillator.get("model") == PIECEWISE_LINEAR:
        return {"stiffness": 1.0} | oscillator
    return oscillator


def check_quiet_unless_allowed(check: Callable[[], object], *, allowed: bool) -> None:
    """Refuse an oscillator without a quiet solution (Eq. 3), unless the request allows it.

    Beyond epsilon_crit1 no motion stays quiet, but everything is defined, up to epsilon_crit2 and beyond it.

    Parameters
    ----------
    check : callable
        Raises `OutsideDomain` if there is no quiet solution.
    allowed : bool
        Whether the request allows that.

    Raises
    ------
    OutsideDomain
        The error of `check`; its message names the option that allows it.
    """
    if allowed:
        return
    try:
        check()
    except OutsideDomain as error:
        error.args = (f"{error}; allow_no_quiet_solution takes it all the same",)
        raise


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
    BeforeValidator(accepting(Oscillator, _oscillator_of)),
]
"""Either model. From Python also an `Oscillator` of the kernels, which need not have a quiet solution."""

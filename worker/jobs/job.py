"""What jobs of every kind have in common. A job is its own request: checked once, then in canonical form.

A request may be written in several ways: values listed or spaced, defaults given or left out. A job holds the canonical
form, so `Job.request` and the digest are the same for all of them. What was stored in this form is not checked again:
its digest vouches for it.

A field whose name ends with an underscore is a part of the request in its JSON shape; the property of the same name
without it is the value that the worker uses. In JSON and as an argument it has the name without the underscore.
"""

import hashlib
import json
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator
from functools import cached_property
from typing import Any, ClassVar, Self

from pydantic import ConfigDict, Field, ValidationError, ValidationInfo, model_validator

from rattle_kernels import Oscillator, OutsideDomain, check_domain, check_invertible, check_oscillator, check_quiet
from worker.errors import InvalidJob, SweptOutsideDomain
from worker.jobs.design import SweepAxis, changes_at
from worker.jobs.first_refused import first_fault
from worker.jobs.oscillator_request import (
    ImpactingOscillator,
    OscillatorRequest,
    check_quiet_unless_allowed,
)
from worker.jobs.request import Request, refusal
from worker.jobs.swept_parameter import values_as_json, without_stiffness
from worker.precision_limits import check_decidable, check_fastest, fastest_resolved

Check = Callable[["Job"], object]
Sizes = tuple[tuple[str, float, str], ...]
"""Sizes of a request: for each, what is counted, the number, and the name of the setting that limits it."""
# Stands for the checks of a request that was checked when it came in.
_CHECKED = object()
# Stands for the values of a range: no text of a canonical request holds this character.
_A_RANGE = "\0"

# What the schema says of kinds that only the impacting model has.
IMPACTING_ALONE: dict[str, Any] = {
    "allOf": [{"properties": {"oscillator": {"properties": {"model": {"const": "impacting"}}}}}]
}


class Job(Request, ABC):
    """A job of any kind. Its fields are the request for it, as JSON and as arguments.

    Raises
    ------
    InvalidJob, OutsideDomain
        Naming the field at fault and what would be right.
    """

    model_config = ConfigDict(alias_generator=lambda name: name.rstrip("_"), serialize_by_alias=True)

    result_version: ClassVar[int] = 1
    """Part of every digest. A new layout of the store, or kernels with different results, need a new version."""

    impacting_only: ClassVar[bool] = False
    """Whether only the impacting model can be computed."""

    loose_gears: ClassVar[bool] = False
    """Whether machines are followed beyond the bound of Eq. (8), too."""

    oscillator_: OscillatorRequest = Field(default_factory=ImpactingOscillator)
    machine_: dict[str, Any] | None = Field(
        None,
        description="The machine that the oscillator comes from, its numbers in SI as `POST /v1/machines` answers; of "
        "the machines of a design, those that differ as lists. The result then has SI units as well. It may stand in "
        "place of the oscillator",
    )

    def __init__(self, **fields: Any) -> None:
        self._validate(fields, None)

    @classmethod
    def from_request(cls, request: dict[str, Any], check_size: Check | None = None) -> Self:
        """Job that a request describes.

        Parameters
        ----------
        request : dict
            As JSON. It need not be in canonical form.
        check_size : callable
            Called with the job once the types and ranges of its fields are checked, before any work that grows with
            its `sizes`.

        Returns
        -------
        Job

        Raises
        ------
        InvalidJob, OutsideDomain
            Naming the field at fault; also what `check_size` raises.
        """
        job = cls.__new__(cls)
        job._validate(request, check_size)
        return job

    @classmethod
    def trusted(cls, request: dict[str, Any], digest: str) -> Self:
        """Job of a stored request. It was checked when it came in, and its digest vouches that it is still that one.

        Fields that a package adds which is not installed are kept in the request, and so in the digest. The rest of the
        store can be read; computing it is refused.

        Parameters
        ----------
        request : dict
            As JSON, in canonical form.
        digest : str
            That it was stored with.

        Returns
        -------
        Job

        Raises
        ------
        InvalidJob
            If it does not have this digest.
        """
        known = {field.alias for field in cls.model_fields.values()}
        job = cls.__new__(cls)
        job._validate({name: value for name, value in request.items() if name in known}, _CHECKED)
        job.__dict__["unread"] = {name: value for name, value in request.items() if name not in known}
        if job.digest != digest:
            raise InvalidJob("it does not have the digest that was stored with it")
        return job

    @cached_property
    def unread(self) -> dict[str, Any]:
        """What a stored request asks for that nothing here knows."""
        return {}

    def _validate(self, fields: dict[str, Any], check_size: Check | object | None) -> None:
        try:
            self.__pydantic_validator__.validate_python(fields, self_instance=self, context=check_size)
        except ValidationError as error:
            raise refusal(error) from error

    _stiffness_may_be_swept = model_validator(mode="before")(without_stiffness)

    @model_validator(mode="after")
    def _check(self, info: ValidationInfo) -> Self:
        if info.context is _CHECKED:
            return self
        if info.context is not None:
            info.context(self)
        allowed = self.oscillator_.allow_no_quiet_solution
        settled, oscillator = self._settled(), self.oscillator
        check_quiet_unless_allowed(self.check_quiet, allowed=allowed)
        first = {name: oscillator.value_of(name) for name in self.own_values}
        settled["oscillator_"] = self.oscillator_.settled(first, quiet=not allowed or self.quiet)
        if self.machine_ is not None:
            settled.setdefault("machine_", self.machine_)
        fields = type(self).model_fields.items()
        unused = {name: field.get_default(call_default_factory=True) for name, field in fields if name not in settled}
        self.__dict__.update(unused | settled)
        object.__setattr__(self, "__pydantic_fields_set__", set(settled))
        return self

    @abstractmethod
    def _settled(self) -> dict[str, Any]:
        """Check the job, and return the fields of its canonical form other than the oscillator.

        Fields that are left out are not part of the request. The base class checks nothing.
        """

    @property
    @abstractmethod
    def kind(self) -> str:
        """Name of its kind."""

    @abstractmethod
    def sizes(self) -> Sizes:
        """Sizes of the request, for limits."""

    @cached_property
    def oscillator(self) -> Oscillator:
        """Oscillator of the kernels, at the first values of what is swept, checked."""
        return self.check_oscillator(self.oscillator_.value.at(**self.own_values))

    @property
    def own_values(self) -> dict[str, float]:
        """Parameters that the job itself gives values, and those of its oscillator in canonical form."""
        return changes_at(self.axes, (0,) * len(self.axes))

    @classmethod
    def check_oscillator(cls, oscillator: Oscillator) -> Oscillator:
        """Return an oscillator, or raise if jobs of this kind cannot be computed with it.

        Parameters
        ----------
        oscillator : Oscillator

        Returns
        -------
        Oscillator

        Raises
        ------
        OutsideDomain
            Naming the parameter, the bound and its value.
        """
        if cls.impacting_only:
            return check_invertible(oscillator)
        return check_oscillator(oscillator) if cls.loose_gears else check_domain(oscillator)

    @property
    def axes(self) -> tuple[SweepAxis, ...]:
        """What the job steps along, checked: its swept parameters, or its design. None if it has one oscillator."""
        return ()

    def check_oscillators(
        self, check: Callable[[Oscillator], Oscillator], *, convex: Collection[str] | None = None
    ) -> None:
        """Check the oscillator, or every one of a sweep.

        Parameters
        ----------
        check : callable
            Raises `OutsideDomain`.
        convex : collection of str, optional
            Parameters in which the check is convex (see `worker.jobs.first_refused`); by default all but phases.

        Raises
        ------
        OutsideDomain, SweptOutsideDomain
            The latter names the first swept value at fault.
        """
        if not self.axes:
            check(self.oscillator)
            return
        fault = first_fault(self.oscillator_.value, self.axes, check, convex)
        if fault is None:
            return
        place, error = fault
        if isinstance(error, OutsideDomain):
            raise self._swept_error(place, error) from error
        raise error

    def _swept_error(self, place: tuple[int, ...], error: OutsideDomain) -> SweptOutsideDomain:
        """The error of the oscillator at a place of the swept values, of one parameter."""
        (axis,), (at,) = self.axes, place
        return SweptOutsideDomain(error, ("vary", "values", at), f"{axis.name} = {axis.values[at]:g}")

    def check_quiet(self) -> None:
        """Refuse a job that has an oscillator of finite stiffness without a quiet solution (Eq. 3).

        Raises
        ------
        OutsideDomain
        """
        if not math.isinf(self.oscillator.stiffness):
            self.check_oscillators(check_quiet, convex=())

    @cached_property
    def quiet(self) -> bool:
        """Whether every oscillator of the job has a quiet solution; of the impacting model it is not asked."""
        try:
            self.check_quiet()
        except OutsideDomain:
            return False
        return True

    def forcing_terms(self, oscillators: int) -> Sizes:
        """Size of the forcing at so many oscillators, which each of them is checked by and computed with."""
        highest = max((harmonic.order for harmonic in self.oscillator_.harmonics), default=0)
        terms = oscillators * len(self.oscillator_.harmonics) * highest
        return (("values times harmonics times their highest order", terms, "max_forcing_terms"),)

    @property
    @abstractmethod
    def impacts(self) -> int:
        """Most applications of P that it takes; for searches and curves, a usual number."""

    @property
    def impacts_together(self) -> int:
        """Those of `impacts` that many trajectories make side by side, which is tens of times faster."""
        return 0

    @property
    def tasks_at_once(self) -> float:
        """Most tasks that can compute at the same time: no more cores than these make it faster."""
        return math.inf

    @property
    @abstractmethod
    def bytes(self) -> int:
        """Most bytes of its store before compression; for searches and curves, a usual number."""

    @property
    def cell_count(self) -> int:
        """Cells, or points of samples, that are computed; 0 for an analysis."""
        return 0

    def request(self) -> dict[str, Any]:
        """Request for this job in canonical form, as JSON."""
        return self.model_dump(mode="json", exclude_unset=True) | self.unread

    @cached_property
    def digest(self) -> str:
        """Hash of the request and of the version of the result: equal digests, equal bytes."""
        hashed = hashlib.sha256()
        for piece in self._hashed_text():
            hashed.update(piece.encode())
        return hashed.hexdigest()

    def _hashed_text(self) -> Iterator[str]:
        """The request with all its values as JSON, in pieces: a range and its values have the same digest."""
        request, ranges = self.request(), []
        rules = request.get("vary", [])
        for rule, axis in zip(rules if isinstance(rules, list) else [rules], self.axes, strict=False):
            if "values" not in rule:
                ranges.append(axis)
                rule.clear()
                rule.update(parameter=axis.name, values=_A_RANGE)
        text = json.dumps({"request": request, "version": self.result_version}, sort_keys=True)
        first, *others = text.split(json.dumps(_A_RANGE))
        yield first
        for axis, other in zip(ranges, others, strict=True):
            yield from values_as_json(axis.values)
            yield other


class AnalysisJob(Job):
    """A job that explains basins: about one oscillator, or about a range of them."""

    kind_: str

    @property
    @abstractmethod
    def fastest(self) -> float:
        """Highest speed of the window, or of the seeds."""

    @model_validator(mode="after")
    def _is_decidable(self, info: ValidationInfo) -> Self:
        if info.context is _CHECKED:
            return self

        def check(oscillator: Oscillator) -> Oscillator:
            limit = fastest_resolved(check_decidable(oscillator))
            why = f"at half backlash {oscillator.half_backlash:g} double precision does not resolve shorter flights"
            check_fastest(self.fastest, limit, why)
            return oscillator

        self.check_oscillators(check)
        return self

    @property
    def kind(self) -> str:
        """Name of its kind."""
        return self.kind_

    def request(self) -> dict[str, Any]:
        """Request for this job in canonical form, as JSON; its kind comes first."""
        return {"kind": self.kind_} | super().request()

"""A parameter of the oscillator that a request varies."""

from typing import Annotated, Literal

from pydantic import Field

from service.strict import Real, Request
from worker.errors import InvalidJob
from worker.jobs.swept_parameter import Spacing, SweptParameter

Parameter = Literal["damping", "eccentricity", "half_backlash", "stiffness"]


class VaryRequest(Request):
    """Values of one swept parameter: all of them, or how many from a start to a stop, both included."""

    parameter: Parameter
    values: list[Real] | None = Field(None, description="Ascending or descending")
    start: Real | None = None
    stop: Real | None = None
    count: Annotated[int, Field(strict=True, ge=2)] | None = None
    spacing: Spacing = Spacing.LINEAR

    @property
    def size(self) -> int:
        """Number of values."""
        return len(self.values) if self.values is not None else self.count or 0

    @property
    def least(self) -> float:
        """Least value above 0; one that is not is refused in other words than a size."""
        ends = [end for end in (self.start, self.stop) if end is not None]
        return min((value for value in self.values or ends if value > 0.0), default=1.0)

    def to_swept(self, place: tuple[str | int, ...]) -> SweptParameter:
        """Swept parameter that this describes; `place` is where it stands in the request.

        Raises
        ------
        InvalidJob
            Where neither or both descriptions are given, or they are contradictory.
        """
        spaced = self.start, self.stop, self.count
        if self.values is not None and spaced == (None, None, None) and "spacing" not in self.model_fields_set:
            return SweptParameter(self.parameter, tuple(self.values))
        if self.values is not None or self.start is None or self.stop is None or self.count is None:
            raise InvalidJob(f"give {self.parameter} either values, or start, stop and count", place)
        try:
            return SweptParameter.spaced(self.parameter, self.start, self.stop, self.count, self.spacing)
        except InvalidJob as error:
            raise InvalidJob(str(error), (*place, "spacing")) from error

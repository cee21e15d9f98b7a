"""Types of request fields: strict numbers, and no unknown fields."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

# Strict: JSON's `true` is not a number. An integer is accepted as a real number.
Real = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Count = Annotated[int, Field(strict=True, ge=1)]


class Request(BaseModel):
    """A request. Unknown fields are refused, so that a misspelt one is not taken for a default."""

    model_config = ConfigDict(extra="forbid")

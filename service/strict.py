"""What every request is made of: strict numbers, and no unknown fields."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

# Strict: JSON's true is no number. Integers are welcome where a real number is asked for.
Real = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Count = Annotated[int, Field(strict=True, ge=1)]


class Request(BaseModel):
    """A request: unknown fields are refused, so that a typing error is not taken for a default."""

    model_config = ConfigDict(extra="forbid")

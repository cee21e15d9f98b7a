"""Numbers that JSON cannot hold."""

import math
from typing import Annotated

from pydantic import BeforeValidator


def _finite_or_none(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


FiniteOrNone = Annotated[float | None, BeforeValidator(_finite_or_none)]
"""A number, or None in place of NaN and infinity."""

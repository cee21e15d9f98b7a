"""How a store says that it has levels: the convention `multiscales` of zarr-conventions.

Source: https://github.com/zarr-conventions/multiscales, version 0.1.
"""

from collections.abc import Sequence
from typing import Any

from worker.stores.layout import SOLUTION
from worker.stores.pyramid.levels import Level

ATTRIBUTE = "multiscales"
"""Attribute of a store that has levels."""
_CONVENTION = {
    "uuid": "d35379db-88df-4056-af3a-620245f8e347",
    "name": ATTRIBUTE,
    "schema_url": "https://raw.githubusercontent.com/zarr-conventions/multiscales/refs/tags/v0.1/schema.json",
    "spec_url": "https://github.com/zarr-conventions/multiscales/blob/v0.1/README.md",
    "description": "Multiscale layout of zarr datasets",
}
_SAMPLED = (
    "a cell of a level is the first of its block, with all of its labels, and stands for the others: it is sampled, "
    "neither a mean nor the most frequent one. The coordinates are those of this cell."
)


def multiscales(levels: Sequence[Level], swept: int) -> dict[str, Any]:
    """Attributes of a store with levels; none if there is only the basin itself.

    Parameters
    ----------
    levels : sequence of Level
    swept : int
        Number of swept parameters, whose dimensions come first.

    Returns
    -------
    dict
        Each asset is an array of solutions. ``group``, ``period`` and ``step`` lie beside it.
    """
    if len(levels) == 1:
        return {}
    layout: list[dict[str, Any]] = [
        {"asset": SOLUTION.path, "transform": _transform(swept, 1.0)},
    ]
    for finer, level in zip(levels, levels[1:], strict=False):
        source, own = finer.own(SOLUTION).path, level.own(SOLUTION).path
        layout.append({"asset": own, "derived_from": source, "transform": _transform(swept, 2.0)})
    return {
        "zarr_conventions": [_CONVENTION],
        ATTRIBUTE: {"layout": layout, "resampling_method": "nearest", "comment": _SAMPLED},
    }


def _transform(swept: int, scale: float) -> dict[str, list[float]]:
    """From the cells of the finer level to this one's. Both begin at the same cell, so nothing is moved."""
    axes = [1.0] * swept
    return {"scale": [*axes, scale, scale], "translation": [0.0] * (swept + 2)}

"""Curves of a result as overlays."""

import xarray as xr

from rattle_kernels import Piece
from worker.analyses.curves import pieces_of
from worker.pictures.overlay import Lines
from worker.stores.table import slices

_MANIFOLDS = {1: ("stable", "-"), 2: ("unstable", ":")}
_COLOURS = {
    "manifold": ("magenta", "lime", "darkorange", "cyan"),
    "grazing_curve": ("white", "black", "yellow", "magenta", "lime"),
}


def curves_of(dataset: xr.Dataset, kind: str) -> list[Lines]:
    """Manifolds of each saddle, or the grazing curve and its pre-images, each in a colour of its own.

    Parameters
    ----------
    dataset : xarray.Dataset
    kind : {"manifold", "grazing_curve"}

    Returns
    -------
    list of Lines
    """
    pieces, colours = pieces_of(dataset), _COLOURS[kind]
    if kind == "grazing_curve":
        orders = slices(dataset.order_size.values)
        names = ["grazing curve", *(f"pre-image {order}" for order in range(1, len(orders)))]
        return [
            Lines(name, colours[order % len(colours)], tuple(pieces[own]))
            for order, (name, own) in enumerate(zip(names, orders, strict=True))
        ]
    curves = []
    branches = slices(dataset.branch_size.values)
    for saddle, name in enumerate(dataset.name.values.tolist()):
        for code, (side, style) in _MANIFOLDS.items():
            own = ((dataset.branch_kind == code) & (dataset.branch_orbit == saddle)).values.nonzero()[0]
            arcs: list[Piece] = [piece for branch in own for piece in pieces[branches[branch]]]
            if arcs:
                label = f"{side} manifold of {name}"
                curves.append(Lines(label, colours[saddle % len(colours)], tuple(arcs), style=style))
    return curves

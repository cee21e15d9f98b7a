"""Overlays of a picture of basins by name, computed from the oscillator and the catalogue."""

import math
from collections.abc import Collection
from enum import StrEnum

from rattle_kernels import (
    Attractor,
    FirstCurve,
    ManifoldLimits,
    Oscillator,
    PeriodicOrbit,
    grazing_preimages,
    stable_manifold,
)
from rattle_kernels.manifolds.boundary_saddles import boundary_saddles
from rattle_kernels.model.arcs import arcs_of
from worker.additions import Mask, additions
from worker.errors import InvalidJob
from worker.pictures.overlay import (
    Lines,
    Overlay,
    attractor_marks,
    grazing_line,
    manifold_lines,
    preimage_lines,
    saddle_marks,
)

# Orders of pre-images, as in the paper's pictures.
_PREIMAGES = 2
# Arclength of each branch. At the paper's parameters it puts a manifold next to every boundary cell up to v = 7.
_ARCLENGTH = 100.0
_MANIFOLD_COLOURS = ("magenta", "lime", "darkorange", "cyan")


class OverlayKind(StrEnum):
    """What is laid over a picture, in the order of drawing."""

    # What packages lay over the cells: masks, which are stored and not computed.
    vars().update({addition.overlay.upper(): addition.overlay for addition in additions()})
    GRAZING = "grazing"
    PREIMAGES = "preimages"
    MANIFOLDS = "manifolds"
    ATTRACTORS = "attractors"
    SADDLES = "saddles"


USUAL_OVERLAYS = (OverlayKind.GRAZING, OverlayKind.ATTRACTORS)


def parse_overlays(text: str) -> tuple[OverlayKind, ...]:
    """Kinds from names separated by commas, such as ``grazing,attractors``; none from an empty text.

    Raises
    ------
    InvalidJob
        If a name is unknown; lists the known ones.
    """
    return tuple(_kind(name.strip()) for name in text.split(",") if name.strip())


def masks_among(kinds: Collection[str]) -> list[Mask]:
    """The masks among overlays."""
    return [addition.mask() for addition in additions() if addition.overlay in kinds]


def _kind(name: str) -> OverlayKind:
    if name not in list(OverlayKind):
        raise InvalidJob(f"there is no overlay {name!r}; choose among {','.join(OverlayKind)}")
    return OverlayKind(name)


def overlays_for(
    kinds: Collection[str], oscillator: Oscillator, attractors: tuple[Attractor, ...], velocity: tuple[float, float]
) -> tuple[Overlay, ...]:
    """Compute overlays.

    Parameters
    ----------
    kinds : collection of str
        Names of `OverlayKind`. Masks are not computed: `masks_among` has them.
    oscillator : Oscillator
        Either model. Pre-images and manifolds exist for the impacting model only.
    attractors : tuple of Attractor
        Catalogue of its motions, permanent contact first; empty if not known yet. Then there are no saddles, because
        it is not known which of them separate basins.
    velocity : (float, float)
        Lowest and highest speed of the picture.

    Returns
    -------
    tuple of Overlay
        Grazing curve; first and second pre-images; stable manifolds of the saddles of impact period 1 and 2 that
        separate basins; attractors; those saddles. Of a loose gear with impacts both curves on which it grazes a wall.

    Raises
    ------
    InvalidJob
        If a kind is unknown, or this oscillator has no such overlay.
    """
    asked = {_kind(name) for name in kinds}
    for kind in sorted(asked & {OverlayKind.PREIMAGES, OverlayKind.MANIFOLDS}):
        if math.isfinite(oscillator.stiffness):
            raise InvalidJob(
                f"the overlay {kind} needs the map backwards, which is known for the impacting model, not for the "
                f"piecewise linear one of stiffness {oscillator.stiffness:g}: leave it out"
            )
    return tuple(_computed(asked, oscillator, attractors, velocity))


def _computed(
    kinds: set[OverlayKind], oscillator: Oscillator, attractors: tuple[Attractor, ...], velocity: tuple[float, float]
) -> list[Overlay]:
    overlays: list[Overlay] = []
    if OverlayKind.PREIMAGES in kinds:
        overlays += preimage_lines(grazing_preimages(oscillator, _PREIMAGES, velocity_limits=velocity)[1:])
        if _grazes_above(oscillator):
            orders = grazing_preimages(oscillator, _PREIMAGES, velocity_limits=velocity, first=FirstCurve.UPPER)
            overlays += preimage_lines(orders[1:], "grazing +beta")
    if OverlayKind.GRAZING in kinds:
        overlays.append(grazing_line(oscillator))
        if _grazes_above(oscillator):
            (pieces,) = grazing_preimages(oscillator, 0, velocity_limits=velocity, first=FirstCurve.UPPER)
            overlays.append(Lines("grazing +beta", "white", pieces, 1.4, "--"))
    sought = kinds & {OverlayKind.MANIFOLDS, OverlayKind.SADDLES} and attractors
    saddles = boundary_saddles(oscillator, attractors) if sought else ()
    if OverlayKind.MANIFOLDS in kinds:
        overlays += manifolds_of(oscillator, saddles, ManifoldLimits(_ARCLENGTH, *velocity))
    if OverlayKind.ATTRACTORS in kinds:
        overlays += attractor_marks(attractors)
    if OverlayKind.SADDLES in kinds:
        overlays += saddle_marks(saddles)
    return overlays


def _grazes_above(oscillator: Oscillator) -> bool:
    """Whether flights graze +beta from below, too, and P has an inverse."""
    arcs = arcs_of(oscillator)
    return math.isinf(oscillator.stiffness) and arcs is not None and arcs.begin.size > 1


def manifolds_of(
    oscillator: Oscillator, saddles: tuple[PeriodicOrbit, ...], limits: ManifoldLimits
) -> tuple[Lines, ...]:
    """Stable manifolds of saddles, each in its own colour: magenta and green as in Fig. 15, then others."""
    return tuple(
        manifold_lines(
            stable_manifold(oscillator, saddle, limits), f"stable manifold of {saddle.name}",
            _MANIFOLD_COLOURS[number % len(_MANIFOLD_COLOURS)],
        )
        for number, saddle in enumerate(saddles)
    )  # fmt: skip

"""What can be laid over a picture of basins by name, and how it is computed from the oscillator alone."""

import math
from collections.abc import Collection
from enum import StrEnum

from rattle_kernels import Attractor, ManifoldLimits, Oscillator, PeriodicOrbit, grazing_preimages, stable_manifold
from rattle_kernels.manifolds.boundary_saddles import boundary_saddles
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

# Those of the paper's pictures.
_PREIMAGES = 2
# Of each branch: at the paper's parameters all boundary cells of a picture of v up to 7 are then next to a manifold.
_ARCLENGTH = 100.0
_MANIFOLD_COLOURS = ("magenta", "lime", "darkorange", "cyan")


class OverlayKind(StrEnum):
    """What is laid over a picture, in the order of drawing."""

    GRAZING = "grazing"
    PREIMAGES = "preimages"
    MANIFOLDS = "manifolds"
    ATTRACTORS = "attractors"
    SADDLES = "saddles"


USUAL_OVERLAYS = (OverlayKind.GRAZING, OverlayKind.ATTRACTORS)


def parse_overlays(text: str) -> tuple[OverlayKind, ...]:
    """Kinds from their names with commas between, as ``grazing,attractors``; none from an empty text.

    Raises
    ------
    InvalidJob
        Where a name is none of them; it lists those that there are.
    """
    return tuple(_kind(name.strip()) for name in text.split(",") if name.strip())


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
        Names of `OverlayKind`.
    oscillator : Oscillator
        Either model; pre-images and manifolds are those of the impacting one.
    attractors : tuple of Attractor
        Catalogue of its motions, permanent contact first; empty where it is not known yet, and then there are no
        saddles: which of them part basins is not known either.
    velocity : (float, float)
        Lowest and highest speed of the picture.

    Returns
    -------
    tuple of Overlay
        Grazing curve; first and second pre-image; stable manifolds of the saddles that part basins, of impact period 1
        and 2; attractors; those saddles.

    Raises
    ------
    InvalidJob
        Where one is asked for that this oscillator has not.
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
    if OverlayKind.GRAZING in kinds:
        overlays.append(grazing_line(oscillator))
    sought = kinds & {OverlayKind.MANIFOLDS, OverlayKind.SADDLES} and attractors
    saddles = boundary_saddles(oscillator, attractors) if sought else ()
    if OverlayKind.MANIFOLDS in kinds:
        overlays += manifolds_of(oscillator, saddles, ManifoldLimits(_ARCLENGTH, *velocity))
    if OverlayKind.ATTRACTORS in kinds:
        overlays += attractor_marks(attractors)
    if OverlayKind.SADDLES in kinds:
        overlays += saddle_marks(saddles)
    return overlays


def manifolds_of(
    oscillator: Oscillator, saddles: tuple[PeriodicOrbit, ...], limits: ManifoldLimits
) -> tuple[Lines, ...]:
    """Stable manifolds of saddles, each in a colour of its own: magenta, green as in Fig. 15, then others."""
    return tuple(
        manifold_lines(
            stable_manifold(oscillator, saddle, limits), f"stable manifold of {saddle.name}",
            _MANIFOLD_COLOURS[number % len(_MANIFOLD_COLOURS)],
        )
        for number, saddle in enumerate(saddles)
    )  # fmt: skip

"""Results over HTTP: those of jobs of every kind, a basin for a viewer, a preview with its cells, one time history."""

import base64
from collections.abc import Iterable
from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, Field

from rattle_kernels import Attractor, AttractorKind, Direction, Loudness, Outcome, TimeHistory, grazing_velocity
from worker.additions import additions, with_fields
from worker.jobs.preview_request import Preview
from worker.kinds import KINDS
from worker.pictures.colours import MISSING, SPECKLE, Colour, Paint, Palette, paints_of
from worker.pictures.overlay import Lines, Overlay
from worker.results.motion_end import MotionEnd
from worker.results.summary import EndView, ExpectedView, FiniteOrNone, Loud, ends_of
from worker.results.viewer import PanelOutline
from worker.stores.pyramid import Level

_DIGITS = 7
# A preview is for a screen, and comes ten times a second.
_PREVIEW_DIGITS = 6
_PREVIEW_CURVE_POINTS = 192
_PREVIEW_POINTS = 400
_OUTCOMES: dict[Outcome, Literal["rattling", "permanent_contact", "undecided"]] = {
    Outcome.RETURNED: "rattling",
    Outcome.PERMANENT_CONTACT: "permanent_contact",
    Outcome.NOT_CONVERGED: "undecided",
}
_DIRECTIONS: dict[int, Literal["in", "out", "impact"]] = {
    Direction.IN: "in",
    Direction.OUT: "out",
    Direction.IMPACT: "impact",
}
_ENDS: dict[AttractorKind, Literal["permanent_contact", "periodic"]] = {
    AttractorKind.PERMANENT_CONTACT: "permanent_contact",
    AttractorKind.PERIODIC: "periodic",
}


def _result_of_any_kind() -> Any:
    """Type of the results of all kinds: those that say of which kind they are, and those of basins and sweeps."""
    views = dict.fromkeys(kind.result_view for kind in KINDS.values())
    named = [view for view in views if "kind" in view.model_fields]
    unnamed = [view for view in views if view not in named]
    return reduce(or_, [*unnamed, Annotated[reduce(or_, named), Field(discriminator="kind")]])


if TYPE_CHECKING:
    AnyResult = Any
else:
    AnyResult = _result_of_any_kind()


def in_hex(colour: Colour) -> str:
    """A colour as "#rrggbb"."""
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in colour)


class WindowView(BaseModel):
    """One direction of the window, cut into cells."""

    start: float
    stop: float
    cells: int


class TilingView(BaseModel):
    """Tiles of the basin, of `rows` by `columns` cells; tiles at the upper edges may be smaller."""

    rows: int
    columns: int
    down: int = Field(description="Tiles along velocity, from the lowest speed")
    across: int = Field(description="Tiles along time")
    first: int = Field(
        description="Number of the basin's first tile; the others follow along time, then along velocity"
    )
    states: list[Literal[1, 2, 3]] = Field(description="1 pending, 2 mapped, 3 labelled: only such can be fetched")


class LevelView(BaseModel):
    """A coarser level of a large basin: each of its cells is one of the basin and stands for its neighbours.

    Its tiles are of `rows` by `columns` cells of the level; those at the upper edges may be smaller.
    """

    level: int
    every: int = Field(description="Cells of the basin from one cell of the level to the next, each way")
    rows: int
    columns: int
    down: int = Field(description="Tiles along velocity, from the lowest speed")
    across: int = Field(description="Tiles along time")
    first: int = Field(description="Number of the basin's first tile in this level")

    @classmethod
    def from_level(cls, level: Level, basin: int) -> "LevelView":
        """View of a level of a basin."""
        tiling = level.tiling
        down, across = tiling.shape
        return cls(
            level=level.number, every=level.every, rows=tiling.tile_rows, columns=tiling.tile_columns, down=down,
            across=across, first=tiling.numbers_of(basin).start,
        )  # fmt: skip


class DrawnSolution(Loud):
    """One solution, as drawn."""

    number: int
    name: str
    kind: Literal["periodic", "chaotic", "chaotic_transient", "permanent_contact", "undecided"]
    share: FiniteOrNone = Field(description="In this basin; null until it is complete, or if it has no such solution")
    lyapunov_exponent: FiniteOrNone
    mean_life: FiniteOrNone = Field(description="Mean number of impacts until a motion leaves chaos; null if it lasts")
    mean_life_error: FiniteOrNone = Field(description="Standard error of `mean_life`, at most")
    ends: list[EndView] = Field(
        description="What a chaotic transient ends in; the rest of its ensemble had not ended. Empty of other motions"
    )
    colours: dict[Palette, str]
    textures: dict[Palette, int] = Field(description="How cells of a colour that is used again are marked; 0: not")
    points: list[tuple[float, float]] = Field(description="(t, v) of its departures in this basin")

    @classmethod
    def from_attractor(
        cls, number: int, attractor: Attractor, heard: Loudness, share: float, paints: dict[Palette, Paint]
    ) -> "DrawnSolution":
        """View of an attractor."""
        points = zip(attractor.time.tolist(), attractor.velocity.tolist(), strict=True)
        return cls(
            number=number, name=attractor.name, kind=attractor.kind.name.lower(),
            share=share, lyapunov_exponent=attractor.lyapunov_exponent, mean_life=attractor.mean_life,
            mean_life_error=attractor.mean_life_error, ends=ends_of(attractor),
            colours={palette: in_hex(paint.colour) for palette, paint in paints.items()},
            textures={palette: paint.texture for palette, paint in paints.items()},
            points=list(points), **heard._asdict(),
        )  # fmt: skip


def drawn(
    attractors: tuple[Attractor, ...], loudness: tuple[Loudness, ...], shares: Iterable[float]
) -> list[DrawnSolution]:
    """Solutions as drawn, with their colours in every palette."""
    palettes = {palette: paints_of(attractors, palette) for palette in Palette}
    return [
        DrawnSolution.from_attractor(
            number, attractor, heard, share, {name: paints[number] for name, paints in palettes.items()}
        )
        for number, (attractor, heard, share) in enumerate(zip(attractors, loudness, shares, strict=True))
    ]


class PolylineView(BaseModel):
    """A curve in the (t, v) plane."""

    time: list[float]
    velocity: list[float]


class OverlayView(BaseModel):
    """Curves, or marked departures, of one kind. Phases may run beyond a period."""

    label: str
    colour: str = Field(description="A colour by its name, as in the paper's pictures")
    marker: Literal["+", "x", "."] | None = Field(description="null for curves")
    pieces: list[PolylineView] = Field(description="Each by itself: none is joined to another")

    @classmethod
    def from_overlay(cls, overlay: Overlay) -> "OverlayView":
        """View of an overlay."""
        if isinstance(overlay, Lines):
            marker, pieces = None, [(piece.t, piece.v) for piece in overlay.pieces]
        else:
            marker, pieces = overlay.marker, [(overlay.t, overlay.v)]
        # Finer than any screen, and a third of the bytes.
        curves = [PolylineView(time=t.round(_DIGITS).tolist(), velocity=v.round(_DIGITS).tolist()) for t, v in pieces]
        return cls(label=overlay.label, colour=overlay.colour, marker=marker, pieces=curves)


class OverlaysView(BaseModel):
    """Overlays of one kind."""

    overlays: list[OverlayView]


class UncertaintyView(BaseModel):
    """How slowly better knowledge of the departure makes the final motion certain: f(e) ~ e^exponent."""

    exponent: FiniteOrNone = Field(description="1 for smooth borders, less for fractal ones; null without borders")
    error: FiniteOrNone = Field(description="Standard error of the fit")


class OutlineView(BaseModel):
    """Everything needed to draw one basin, except its cells, which are fetched tile by tile."""

    parameters: dict[str, float] = Field(description="Values of the swept parameters in this basin")
    time: WindowView
    velocity: WindowView
    tiles: TilingView
    levels: list[LevelView] = Field(
        description="From fine to coarse; none of 4,000 cells or fewer each way, or until the job is complete"
    )
    complete: bool
    solutions: list[DrawnSolution] = Field(description="By number; those of the whole job")
    expected: ExpectedView | None = Field(description="Mean loudness over the window; null until it is complete")
    missing_colour: str
    speckle: list[float] = Field(description="Brightness of chaotic cells by their group, counted round")
    grazing: PolylineView = Field(description="The grazing curve v*(t)")

    @classmethod
    def from_outline(cls, outline: PanelOutline) -> "OutlineView":
        """View of an outline."""
        grid, tiling = outline.tiling.grid, outline.tiling
        down, across = tiling.shape
        return cls(
            parameters=outline.values,
            time=WindowView(start=grid.time_start, stop=grid.time_stop, cells=grid.time_cells),
            velocity=WindowView(start=grid.velocity_start, stop=grid.velocity_stop, cells=grid.velocity_cells),
            tiles=TilingView(
                rows=tiling.tile_rows, columns=tiling.tile_columns, down=down, across=across,
                first=outline.first_tile, states=list(outline.states),
            ),
            levels=[LevelView.from_level(level, outline.basin) for level in outline.levels],
            complete=outline.complete, **outline.added,
            solutions=drawn(outline.solutions, outline.loudness, outline.shares),
            expected=outline.expected and ExpectedView(**outline.expected._asdict()),
            missing_colour=in_hex(MISSING), speckle=list(SPECKLE),
            grazing=PolylineView(time=outline.curve[0].tolist(), velocity=outline.curve[1].tolist()),
        )  # fmt: skip


if not TYPE_CHECKING:
    for _addition in additions():
        OutlineView = with_fields(OutlineView, _addition.outline_fields())


class PreviewView(BaseModel):
    """A small basin: its window, its motions, and the number of the motion that each cell ends in."""

    time: WindowView
    velocity: WindowView
    iterations: int = Field(description="k")
    solutions: list[DrawnSolution] = Field(description="By number")
    expected: ExpectedView = Field(description="Mean loudness over the window")
    missing_colour: str
    grazing: PolylineView = Field(description="The grazing curve v*(t)")
    labels: str = Field(
        description="Base64 of one byte a cell: the number of its solution, row by row from the lowest speed",
        json_schema_extra={"contentEncoding": "base64"},
    )

    @classmethod
    def from_preview(cls, preview: Preview, iterations: int) -> "PreviewView":
        """View of a preview."""
        grid = preview.grid
        phases = np.linspace(grid.time_start, grid.time_stop, _PREVIEW_CURVE_POINTS)
        curve = grazing_velocity(preview.oscillator, phases)
        return cls(
            time=WindowView(start=grid.time_start, stop=grid.time_stop, cells=grid.time_cells),
            velocity=WindowView(start=grid.velocity_start, stop=grid.velocity_stop, cells=grid.velocity_cells),
            iterations=iterations,
            solutions=drawn(
                tuple(_thinned(each) for each in preview.attractors), preview.loudness, preview.shares.tolist()
            ),
            expected=ExpectedView(**preview.expected._asdict()),
            missing_colour=in_hex(MISSING),
            grazing=PolylineView(
                time=phases.round(_PREVIEW_DIGITS).tolist(), velocity=curve.round(_PREVIEW_DIGITS).tolist()
            ),
            labels=base64.b64encode(preview.solution.astype(np.uint8).tobytes()).decode(),
        )


def _thinned(attractor: Attractor) -> Attractor:
    if not attractor.is_chaotic:
        return attractor
    every = -(-attractor.time.size // _PREVIEW_POINTS) or 1
    time, velocity = attractor.time[::every].round(_PREVIEW_DIGITS), attractor.velocity[::every].round(_PREVIEW_DIGITS)
    return attractor._replace(time=time, velocity=velocity)


class ContactView(BaseModel):
    """A crossing of a backlash boundary, or an impact on it."""

    time: float
    wall: Literal[1, -1] = Field(description="+1: Phi = +beta, -1: Phi = -beta")
    direction: Literal["in", "out", "impact"] = Field(
        description="Beyond the wall, back into freeplay, or both at once"
    )
    speed: float


class RepeatedView(BaseModel):
    """What a motion nearly repeats at first, and leaves, as one that starts beside a saddle does."""

    name: str = Field(description="P(m,n+,n-)")
    periods: float = Field(description="Forcing periods from its start")


class MotionEndView(BaseModel):
    """What this very motion does in the end, as far as it was followed."""

    kind: Literal["rattling", "permanent_contact", "periodic"] = Field(
        description="rattling: it has settled on no attracting motion within the periods followed"
    )
    name: str | None = Field(description="Of the motion that it has settled on; null while it rattles without one")
    periods: float = Field(
        description="Forcing periods from its start until it has settled, or else all that were followed"
    )
    impacts: int = Field(description="Impacts within these periods")
    first: RepeatedView | None = Field(description="What it nearly repeats before; null if nothing")

    @classmethod
    def from_end(cls, end: MotionEnd) -> "MotionEndView":
        """View of an end."""
        kind = _ENDS[end.settled.kind] if end.settled else "rattling"
        name = end.settled.name if end.settled else None
        first = end.first and RepeatedView(**end.first._asdict())
        return cls(kind=kind, name=name, periods=end.periods, impacts=end.impacts, first=first)


class TrajectoryView(BaseModel):
    """A time history. Every contact is among the samples; an impact is two of them, before and after."""

    time: list[float] = Field(description="Forcing periods, not reduced, never decreasing")
    displacement: list[float]
    velocity: list[float]
    contacts: list[ContactView]
    outcome: Literal["rattling", "permanent_contact", "undecided"] = Field(
        description="permanent_contact: within the span a contact has begun that counts as permanent, or ever lower "
        "bounces that never rattle again; undecided: a root-finder gave up where the history ends"
    )
    truncated: bool = Field(description="The history ends early, at the largest number of contacts allowed")
    permanent_from: FiniteOrNone = Field(
        description="When the contact begins that counts as permanent; null if there is none"
    )
    end: MotionEndView | None = Field(
        None, exclude_if=lambda end: end is None,
        description="What the motion does in the end; left out unless the query asks for it",
    )  # fmt: skip

    @classmethod
    def from_history(cls, history: TimeHistory, end: MotionEnd | None = None) -> "TrajectoryView":
        """View of a history, and of what its motion does in the end."""
        rows = zip(*(field.tolist() for field in history.contacts), strict=True)
        contacts = [
            ContactView(time=time, wall=wall, direction=_DIRECTIONS[direction], speed=speed)
            for time, wall, direction, speed in rows
        ]
        return cls(
            time=history.time.tolist(), displacement=history.displacement.tolist(), velocity=history.velocity.tolist(),
            contacts=contacts, outcome=_OUTCOMES[history.outcome], truncated=history.truncated,
            permanent_from=history.permanent_from, end=end and MotionEndView.from_end(end),
        )  # fmt: skip

"""What the four analyses have in common: work cut in pieces, whose columns are put together in tables.

An analysis explains pictures: a bifurcation diagram, periodic orbits with their branches, manifolds, pre-images of the
grazing curve. What pieces there are depends on the request and on what other pieces have found, never on time: so
whatever happens on the way, the same request gives the same bytes.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from worker.progress import Stage
from worker.stores.layout import Columns, Variable

Parts = Mapping[str, Columns]
"""Columns of the pieces that are done, by the pieces' names."""


class Piece(NamedTuple):
    """Work for one worker: ``compute(*arguments, pause=...)`` gives its columns. Its name is unique in the job."""

    name: str
    compute: Callable[..., Columns]
    arguments: tuple[Any, ...]


class Plan(NamedTuple):
    """What can be done now, given what is done: the stage, its pieces that can be computed, and how far it is."""

    stage: Stage
    ready: tuple[Piece, ...]
    done: int
    total: int


@dataclass(frozen=True)
class Analysis:
    """One kind of analysis.

    Parameters
    ----------
    title : str
        Of its stores.
    from_request : callable
        Job that a request asks for.
    plan : callable
        ``plan(job, parts)``: what to do next. Nothing ready and nothing under way is the end.
    assemble : callable
        ``assemble(job, parts)``: the store's columns, of whatever parts there are.
    layout : callable
        ``layout(job)``: variables of the store, one for each column.
    summarise : callable
        ``summarise(job, columns)``: the result in short, as JSON.
    draw : callable
        ``draw(job, columns, figure)``.
    """

    title: str
    from_request: Callable[[dict[str, Any]], Any]
    plan: Callable[[Any, Parts], Plan]
    assemble: Callable[[Any, Parts], Columns]
    layout: Callable[[Any], tuple[Variable, ...]]
    summarise: Callable[[Any, Columns], dict[str, Any]]
    draw: Callable[[Any, Columns, Figure], None]


def in_order(parts: Parts, prefix: str) -> list[Columns]:
    """Columns of the parts whose names begin so, by name."""
    return [parts[name] for name in sorted(parts) if name.startswith(prefix)]


def ready_of(stage: Stage, pieces: list[Piece], parts: Parts) -> Plan:
    """Plan of a stage whose pieces are all known and wait for nothing."""
    ready = tuple(piece for piece in pieces if piece.name not in parts)
    return Plan(stage, ready, len(pieces) - len(ready), len(pieces))

"""The common structure of analyses: work is split into pieces, whose columns are assembled into tables.

Analyses are bifurcation diagrams, periodic orbits with their branches, manifolds, and pre-images of the grazing curve.
The pieces depend on the request and on the results of other pieces, never on timing. So the same request always gives
the same bytes.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from worker.progress import Stage
from worker.stores.layout import Columns, Variable

Parts = Mapping[str, Columns]
"""Columns of the finished pieces, by name."""


class Piece(NamedTuple):
    """Work for one worker: ``compute(*arguments, pause=...)`` returns its columns. Its name is unique in the job."""

    name: str
    compute: Callable[..., Columns]
    arguments: tuple[Any, ...]


class Plan(NamedTuple):
    """The current stage: the pieces that can be computed now, how many are done, and how many there are."""

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
        Title of its stores.
    from_request : callable
        Makes a job from a request.
    plan : callable
        ``plan(job, parts)``: what to do next. The job ends when no piece is ready or in progress.
    assemble : callable
        ``assemble(job, parts)``: the store's columns, from the parts found so far.
    layout : callable
        ``layout(job)``: variables of the store, one for each column.
    summarise : callable
        ``summarise(job, columns)``: a summary of the result, as JSON.
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
    """Columns of the parts whose names begin with a prefix, in the order of their names."""
    return [parts[name] for name in sorted(parts) if name.startswith(prefix)]


def ready_of(stage: Stage, pieces: list[Piece], parts: Parts) -> Plan:
    """Plan of a stage whose pieces are all known and do not depend on each other."""
    ready = tuple(piece for piece in pieces if piece.name not in parts)
    return Plan(stage, ready, len(pieces) - len(ready), len(pieces))

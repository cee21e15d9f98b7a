"""Sets of boxes that P maps into themselves: who is inside rattles for ever inside, by proof.

A union Q of boxes is grown from boxes that a trajectory has visited: every box that may hold an image of Q joins,
until none is new. Where that ends, P(Q) lies in Q. Boxes are mapped in parts, since the hull of an image grows with the
part. Near a crisis Q leaks, and nothing is proven.
"""

import math

import numpy as np

from rattle_kernels.attractors.attractor import Attractor
from rattle_kernels.lanes.run import next_impacts
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import kernel_as_written
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_proof.enclosures.flight import Box
from rattle_proof.enclosures.impact import LOST, image
from rattle_proof.enclosures.interval import Interval, middle, point
from rattle_proof.enclosures.lattice import Lattice, box_at, empty_lattice, span_of
from rattle_proof.enclosures.machine import Machine

# Columns of the lattices tried, and in how many parts a box is cut each way. The parts are powers of two: no rounding.
_LATTICES = ((1024, 4), (2048, 4), (4096, 4))
# Beside the attractor, by how much of its range of speeds the lattice is higher at either end.
_ROOM = 0.5
_LARGEST_SHARE = 0.25
_SEED_IMPACTS = 400
# Boxes between two pauses: 32,768 images.
_MARKED_AT_A_TIME = 2048


@kernel_as_written
def _mark_images(machine, oscillator, lattice, rows, columns, parts, marked):
    """Mark all boxes that images of some boxes may touch; false where one is lost or leaves the lattice."""
    width, height = 1.0 / (lattice.ends.shape[1] * parts), lattice.height / parts
    for k in range(rows.size):
        whole = box_at(lattice, rows[k], columns[k])
        for part in range(parts * parts):
            low, early = whole.w.low + (part // parts) * height, whole.t.low + (part % parts) * width
            box = Box(Interval(early, early + width), Interval(low, low + height))
            mapped = image(machine, oscillator, Box(point(middle(box.t)), point(middle(box.w))), box)
            span = span_of(lattice, mapped.all)
            if mapped.state == LOST or span.top < span.bottom:
                return False
            for i in range(span.bottom, span.top + 1):
                for j in range(span.left, span.right + 1):
                    marked[i, j % marked.shape[1]] = True
    return True


def _visited(oscillator: Oscillator, attractor: Attractor, lattice: Lattice, pause: Pause) -> np.ndarray:
    """Boxes that trajectories on an attractor have visited."""
    rows, columns = lattice.ends.shape
    held = np.zeros((rows, columns), np.bool_)
    t, v = attractor.time, attractor.velocity
    for _ in range(_SEED_IMPACTS):
        pause()
        i, j = np.floor(v / lattice.height).astype(np.int64) - lattice.first, np.floor(t * columns).astype(np.int64)
        inside = (i >= 0) & (i < rows)
        held[i[inside], j[inside] % columns] = True
        landed = next_impacts(oscillator, t, v)
        kept = np.isfinite(landed.t)
        t, v = landed.t[kept], landed.v[kept]
    return held


def _closed(
    machine: Machine, oscillator: Oscillator, lattice: Lattice, held: np.ndarray, parts: int, pause: Pause
) -> np.ndarray | None:
    """The boxes with all that their images reach; None if they leave the lattice or are too many."""
    new = held
    while new.any():
        marked = np.zeros_like(held)
        rows, columns = np.nonzero(new)
        if held.mean() > _LARGEST_SHARE:
            return None
        for start in range(0, rows.size, _MARKED_AT_A_TIME):
            pause()
            run = slice(start, start + _MARKED_AT_A_TIME)
            if not _mark_images(machine, oscillator, lattice, rows[run], columns[run], parts, marked):
                return None
        new = marked & ~held
        held = held | new
    return held


def rattling_set(
    machine: Machine, oscillator: Oscillator, attractor: Attractor, end: int, pause: Pause = never_stopped
) -> Lattice | None:
    """Boxes around a chaotic attractor that P maps into themselves.

    Parameters
    ----------
    machine : Machine
    oscillator : Oscillator
        One of them, whose attractor it is.
    attractor : Attractor
        Chaotic.
    end : int
        What the boxes are to carry.
    pause : callable
        Called several times a second; an exception raised there ends the search.

    Returns
    -------
    Lattice or None
        None if no lattice tried is fine enough.
    """
    slowest, fastest = float(attractor.velocity.min()), float(attractor.velocity.max())
    room = _ROOM * (fastest - slowest)
    for columns, parts in _LATTICES:
        height = 2.0 ** math.floor(math.log2(fastest / columns))
        lattice = empty_lattice(max(slowest - room, 0.5 * slowest), fastest + room, columns, height)
        held = _visited(oscillator, attractor, lattice, pause)
        closed = _closed(machine, oscillator, lattice, held, parts, pause)
        if closed is not None:
            lattice.ends[closed] = end
            return lattice
    return None

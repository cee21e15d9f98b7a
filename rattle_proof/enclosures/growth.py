"""Proven boxes grow by rounds: a box whose departures all come to boxes of one end carries that end, too.

Each box is followed once, for a few impacts, and strips that hold its images are kept as its *trail*. A round then
looks only at trails. A box is proven from boxes of earlier rounds, so no proof rests on itself.

What never falls quiet is found the other way round: all that is not proven to fall quiet is taken for it, and boxes
that are not known to come back to it are taken out, round after round.

Where tolerances are cut in parts, each part has a lattice of its own. They stand above each other in one array, and
grow in the same rounds.
"""

import numpy as np

from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import inlined_as_written, kernel_as_written
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_proof.enclosures.interval import Interval, down, up, width
from rattle_proof.enclosures.lattice import UNPROVEN, Lattice, Strip, box_at, find_end
from rattle_proof.enclosures.machine import Machine
from rattle_proof.enclosures.moving_set import WIDEST, advance, set_out, strip_of
from rattle_proof.enclosures.targets import RATTLES, Targets, proven_end, rattles

IMPACTS = 4
"""Length of a trail."""
NUMBERS = 7
"""Numbers of each strip of a trail."""

# Rows of boxes that are missing: none would help, and not known yet.
_HOPELESS, _NOT_LOOKED_UP = -1, -2
# Boxes between two pauses: some tenth of a second, of 32,768 images or of looking trails up.
_FOLLOWED_AT_A_TIME, _GROWN_AT_A_TIME = 8192, 65536
_OUTWARDS = 2.0**-22
_LEAST = 2.0**-100


def empty_trails(boxes: int) -> np.ndarray:
    """Trails of as many boxes, to be filled by `follow_boxes`."""
    return np.empty((boxes, IMPACTS, NUMBERS), np.float32)


@inlined_as_written
def _wider(a):
    """An interval a little wider, for single precision to hold."""
    return Interval(a.low - abs(a.low) * _OUTWARDS - _LEAST, a.high + abs(a.high) * _OUTWARDS + _LEAST)


@inlined_as_written
def _in_rows(lattice, a):
    return _wider(Interval(down(a.low / lattice.height - lattice.first), up(a.high / lattice.height - lattice.first)))


@inlined_as_written
def _write(trail, lattice, strip):
    """Keep a strip in rows of the lattice."""
    trail[0], trail[1] = _wider(strip.t)
    trail[2], trail[3] = _in_rows(lattice, strip.v)
    trail[4], trail[5] = _in_rows(lattice, strip.offset)
    trail[6] = strip.slope / lattice.height


@inlined_as_written
def _read(trail):
    """A strip over a lattice with rows of height 1 from 0 on."""
    times, rows = Interval(float(trail[0]), float(trail[1])), Interval(float(trail[2]), float(trail[3]))
    return Strip(times, rows, float(trail[6]), Interval(float(trail[4]), float(trail[5])))


@kernel_as_written
def follow_boxes(machine, oscillator, targets, boxes, ends, trails):
    """Follow boxes of the lattice.

    Parameters
    ----------
    machine : Machine
    oscillator : Oscillator
        One of them: where roots are sought first. Nothing rests on it.
    targets : Targets
        What is proven before the first round.
    boxes : ndarray of int32, shape (boxes, 2)
        Their rows and columns.
    ends : ndarray of uint16, shape (boxes,)
        Filled with the ends of boxes that come to a target at once, RATTLES where all that is known is that none of a
        box falls quiet.
    trails : ndarray
        Of `empty_trails`. Filled with the strips that hold the images; not numbers where one is not known.
    """
    trails[:] = np.nan
    for k in range(boxes.shape[0]):
        moving = set_out(box_at(targets.lattice, int(boxes[k, 0]), int(boxes[k, 1])), False)
        strip = strip_of(moving)
        ends[k] = proven_end(targets, moving, strip)
        on = rattles(targets, strip)
        for n in range(IMPACTS):
            if ends[k] != UNPROVEN:
                break
            proven, moving = advance(machine, oscillator, moving)
            if not (proven and width(moving.all.t) < WIDEST):
                break
            strip = strip_of(moving)
            ends[k] = proven_end(targets, moving, strip)
            on = on or rattles(targets, strip)
            _write(trails[k, n], targets.lattice, strip)
        if ends[k] == UNPROVEN and on:
            ends[k] = RATTLES


def follow_all(
    machine: Machine,
    oscillator: Oscillator,
    targets: Targets,
    boxes: np.ndarray,
    ends: np.ndarray,
    trails: np.ndarray,
    pause: Pause = never_stopped,
) -> None:
    """Follow boxes of the lattice as `follow_boxes` does, with pauses; an exception raised there ends the work."""
    for start in range(0, len(boxes), _FOLLOWED_AT_A_TIME):
        pause()
        run = slice(start, start + _FOLLOWED_AT_A_TIME)
        follow_boxes(machine, oscillator, targets, boxes[run], ends[run], trails[run])


@kernel_as_written
def _grow(ends, boxes, trails, missing, found):
    """One round: write into `found` the ends of boxes that come to boxes proven before; how many.

    ``ends`` has the lattices one after the other, and a trail is looked up in that of its box. ``missing`` has a box
    without a proof for each strip of a trail: as long as that has none, nothing is looked up.
    """
    new = 0
    for k in range(boxes.shape[0]):
        found[k] = UNPROVEN
        lattice = Lattice(1.0, 0, ends[boxes[k, 0] // ends.shape[1]])
        for n in range(IMPACTS):
            row, column = missing[k, n, 0], missing[k, n, 1]
            if row == _HOPELESS or (row >= 0 and lattice.ends[row, column] == UNPROVEN):
                continue
            look = find_end(lattice, _read(trails[k, n]))
            missing[k, n, 0], missing[k, n, 1] = look.row, look.column
            if look.end != UNPROVEN:
                found[k] = look.end
                new += 1
                break
    return new


def grow_all(
    ends: np.ndarray,
    rounds: np.ndarray,
    boxes: np.ndarray,
    trails: np.ndarray,
    pause: Pause = never_stopped,
    parts: int = 1,
) -> None:
    """All rounds, until one proves nothing new.

    Parameters
    ----------
    ends : ndarray of uint16, shape (rows, columns)
        What is proven; more of it afterwards.
    rounds : ndarray of uint16, shape (rows, columns)
        In which round each box was proven; filled for the new ones.
    boxes : ndarray of int32, shape (boxes, 2)
        Rows and columns of those that were followed.
    trails : ndarray
        Of those.
    pause : callable
        Called several times a second; an exception raised there ends the work.
    parts : int
        How many lattices stand above each other in the arrays.
    """
    lattices = ends.reshape(parts, -1, ends.shape[1])
    this_round = int(rounds.max())
    runs = [
        (boxes[run], trails[run], np.full((len(boxes[run]), IMPACTS, 2), _NOT_LOOKED_UP, np.int32))
        for run in (slice(start, start + _GROWN_AT_A_TIME) for start in range(0, len(boxes), _GROWN_AT_A_TIME))
    ]
    while True:
        found = []
        for n, run in enumerate(runs):
            pause()
            left = ends[run[0][:, 0], run[0][:, 1]] == UNPROVEN
            runs[n] = run[0][left], run[1][left], run[2][left]
            own = np.empty(len(runs[n][0]), np.uint16)
            if _grow(lattices, *runs[n], own):
                found.append((runs[n][0], own))
        if not found:
            return
        # Only now: a round looks up what was proven before it.
        this_round += 1
        for followed, own in found:
            rows, columns = followed[own != UNPROVEN].T
            ends[rows, columns], rounds[rows, columns] = own[own != UNPROVEN], this_round


@kernel_as_written
def _take_out(within, boxes, trails):
    """Take boxes out that are not known to come to boxes within: how many."""
    gone = 0
    for k in range(boxes.shape[0]):
        rows, column = within.shape[1], boxes[k, 1]
        lattice, row = Lattice(1.0, 0, within[boxes[k, 0] // rows]), boxes[k, 0] % rows
        if lattice.ends[row, column] == UNPROVEN:
            continue
        stays = False
        for n in range(IMPACTS):
            if find_end(lattice, _read(trails[k, n])).end != UNPROVEN:
                stays = True
                break
        if not stays:
            lattice.ends[row, column] = UNPROVEN
            gone += 1
    return gone


def never_quiet(
    ends: np.ndarray,
    quiet: int,
    boxes: np.ndarray,
    trails: np.ndarray,
    pause: Pause = never_stopped,
    parts: int = 1,
) -> np.ndarray:
    """Boxes of which no departure falls quiet: the largest set that is known to come back to itself.

    A motion of the set meets it again and again, or comes to an orbit. It has no box of the lowest row, so the speeds
    of its departures have a lower bound; those of a motion that falls quiet tend to 0.

    Parameters
    ----------
    ends : ndarray of uint16, shape (rows, columns)
        Of lattices from speed 0 on that have grown.
    quiet : int
        What boxes carry that fall quiet.
    boxes : ndarray of int32, shape (boxes, 2)
        Rows and columns of those of which it is to be shown: all that are not proven, but for those that come to a set
        that rattles for ever; and maybe others.
    trails : ndarray
        Of those.
    pause : callable
        Called several times a second; an exception raised there ends the work.
    parts : int
        How many lattices stand above each other in the arrays.

    Returns
    -------
    ndarray of uint16, shape (rows, columns)
        1 in the set, 0 elsewhere. Boxes of other ends than `quiet` belong to it.
    """
    within = (ends != quiet).astype(np.uint16)
    lattices = within.reshape(parts, -1, ends.shape[1])
    lattices[:, 0] = UNPROVEN
    gone = 1
    while gone:
        gone = 0
        for start in range(0, len(boxes), _GROWN_AT_A_TIME):
            pause()
            run = slice(start, start + _GROWN_AT_A_TIME)
            here = boxes[run]
            # Only these: all trails together may be a gigabyte.
            left = ends[here[:, 0], here[:, 1]] == UNPROVEN
            gone += _take_out(lattices, here[left], trails[run][left])
    return within

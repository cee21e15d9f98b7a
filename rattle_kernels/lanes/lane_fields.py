"""The buffer of the lanes: 64 trajectories whose numbers lie in one flat array, field after field."""

import numpy as np

from rattle_kernels.numerics.jit import always_inlined, inlined

LANES = 64

# A lane without a point flies at so many times the largest grazing speed, where it is never unsure.
IDLE_SPEED = 1e6

# Fields of the buffer. A flight reads PHASE and VELOCITY. It writes END_PHASE, END_VELOCITY (after an impact with
# the wall) and DURATION. DROPS is 1.0 where it ended on -beta, UNSURE is 1.0 where the careful path must decide.
PHASE = 0 * LANES
VELOCITY = 1 * LANES
SINE = 2 * LANES
COSINE = 3 * LANES
DURATION = 4 * LANES
TARGET = 5 * LANES
END_PHASE = 6 * LANES
END_VELOCITY = 7 * LANES
END_ACCELERATION = 8 * LANES
DROPS = 9 * LANES
UNSURE = 10 * LANES
GRAZING = 11 * LANES
ROW_PART = 12 * LANES
COLUMN_PART = 13 * LANES
# Two neighbouring nodes of a table, lane by lane: they are loaded and stored as one.
LOW_PAIR = 14 * LANES
HIGH_PAIR = 16 * LANES
HALF_SINE = 18 * LANES
HALF_COSINE = 19 * LANES
PHI2 = 20 * LANES
RING_SINE = 21 * LANES
RING_COSINE = 22 * LANES
CUBIC = 23 * LANES
MISS = 24 * LANES
RATE = 25 * LANES
SINE_CHANGE = 26 * LANES
COSINE_CHANGE = 27 * LANES
# Sums over harmonics beside the first (`harmonics`): eight of a flight, then eight of the contact after it.
SUMS = 28 * LANES
FLIGHT_FIELDS = 36
# The angles of one order at a time: sine and cosine of the phase's, of half the duration's, and h - sin h of that.
# They lie where the nodes of the guess were, which are not read again.
ORDER_CUBIC = COLUMN_PART
ORDER_SINE, ORDER_COSINE = LOW_PAIR, LOW_PAIR + LANES
ORDER_HALF_SINE, ORDER_HALF_COSINE = HIGH_PAIR, HIGH_PAIR + LANES

# A flight is sure when the last term of its step, 5 r^4 or so for a guess off by the part r, is below this part of the
# duration: r < 1.4e-3, and what the series leaves out, 14 r^5, below 1e-13.
LAST_TERM = 2e-11
# In place of 1.0 in UNSURE: the guess is off by the part 1.4e-2 at most, ten times what a sure one is. So the end is
# the zero next to it, and needs no search.
NEARLY = 0.5
NEAR = 1e4 * LAST_TERM


@inlined
def lane_buffer(fields):
    """Zeros for some fields of all lanes, from the start of a cache line: vectors that cross lines cost 7 %."""
    lanes = unset_lane_buffer(fields)
    lanes[:] = 0.0
    return lanes


@inlined
def unset_lane_buffer(fields):
    """As `lane_buffer`, of whatever numbers, for what sets each field before it reads it."""
    longer = np.empty(fields * LANES + 8)
    first = -longer.ctypes.data % 64 // 8
    return longer[first : first + fields * LANES]


@always_inlined
def count_set(lanes, field):
    """Number of lanes in which a flag field is set."""
    # An integer sum: one of floats would not vectorise without reassociation.
    total = 0
    for i in range(LANES):
        total += 1 if lanes[field + i] != 0.0 else 0
    return total

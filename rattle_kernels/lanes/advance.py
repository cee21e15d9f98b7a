"""What every loop over lanes does: lanes depart, fly, and stay in contact.

A flight of all lanes has three passes (`flight`), and so has the contact after it (`contact`). Here they are put
together, for the loops that differ in what they do between: many applications (`run`), arrivals (`arrival`) and tangent
vectors (`lyapunov`).
"""

from rattle_kernels.lanes.contact import follow_contacts_carefully, guess_contacts, refine_contacts
from rattle_kernels.lanes.flight import fly_carefully, guess_durations, refine_durations
from rattle_kernels.lanes.lane_fields import END_PHASE, END_VELOCITY, IDLE_SPEED, LANES, PHASE, VELOCITY
from rattle_kernels.lanes.loose_flight import fly_loosely, stay_loosely
from rattle_kernels.numerics.jit import always_inlined, chosen_by_field, inlined
from rattle_kernels.numerics.phase import wrap


@chosen_by_field("arcs", fly_loosely)
def fly(lanes, corners, oscillator, tables):
    """Fly every lane to the next wall; return how many took the careful path."""
    guess_durations(lanes, corners, oscillator, tables)
    unsure = refine_durations(lanes, oscillator)
    if unsure > 0:
        fly_carefully(lanes, oscillator)
    return unsure


@chosen_by_field("arcs", stay_loosely)
def stay(lanes, corners, oscillator, tables, slow):
    """Follow the contact of every lane after its flight (finite stiffness); return how many took the careful path."""
    guess_contacts(lanes, corners, tables)
    unsure = refine_contacts(lanes, oscillator.permanent_after, slow)
    if unsure > 0:
        follow_contacts_carefully(lanes, oscillator)
    return unsure


@always_inlined
def begin_at_the_end(lanes):
    """Make the end of every lane's flight or contact the state from which it goes on."""
    for i in range(LANES):
        lanes[PHASE + i] = lanes[END_PHASE + i]
        lanes[VELOCITY + i] = lanes[END_VELOCITY + i]


@inlined
def depart(lanes, lane, phase, speed):
    """Put a lane on +beta at a phase (any value), leaving it at a speed."""
    lanes[PHASE + lane] = wrap(phase)
    lanes[VELOCITY + lane] = -speed


@inlined
def idle(lanes, lane, largest_grazing_speed):
    """Let a lane fly at a speed at which it is never unsure.

    It loses speed in contacts and flights, a hundredth in a contact of stiffness 1e4. So call this before every flight.
    """
    depart(lanes, lane, 0.0, IDLE_SPEED * largest_grazing_speed)

"""The machine of these tests: the paper's numbers, scaled up, in SI."""

import math

import rattle

SPEED, INERTIA = 300.0, 0.01


def machine(**changes):
    """By default delta = beta = 0.6 and eps = 0.1: a quarter of the plane is chaos."""
    given = {
        "speed": SPEED, "inertia": INERTIA, "drag_torque": 0.6 * INERTIA * SPEED**2 / (2.0 * math.pi),
        "base_radius": 0.1, "backlash": 0.12, "transmission_error": 0.01,
    }  # fmt: skip
    return rattle.GearPair(**given | changes)

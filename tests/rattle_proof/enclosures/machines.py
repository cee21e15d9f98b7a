"""Oscillators whose enclosures are tested, alone and within tolerances, and boxes of their departures."""

import math

import numpy as np

from rattle_kernels import Harmonic, Oscillator, grazing_velocity, largest_grazing_speed
from rattle_proof.enclosures.machine import machine_of

OSCILLATORS = (
    Oscillator(0.6, 0.1, 0.6),
    Oscillator(0.6, 0.1, 0.6, restitution=0.9),
    Oscillator(0.05, 0.01, 0.06),
    Oscillator(6e-4, 1e-4, 6e-4),
    # So little backlash that short bounces meet -beta.
    Oscillator(0.6, 0.1, 1e-3),
    Oscillator(0.6, 0.05, 0.6, harmonics=(Harmonic(2.0, 0.01, 0.3), Harmonic(3.0, 0.004, 0.8)), restitution=0.8),
)
TOLERANCES = {"damping": 0.01, "half_backlash": 0.003, "eccentricity": 0.02, "restitution": 0.05}
"""Parts of the parameters by which they may differ; that of harmonics is `_HARMONIC`."""
_HARMONIC = 0.05
# Parameters are not in the middle of their tolerances: else the sign of a slope would not matter.
_BELOW = 0.5


def tolerances_of(oscillator, part=1.0):
    """Ranges around an oscillator's parameters, of `part` of `TOLERANCES` above and of half of that below."""
    ranges, parts = {}, dict(TOLERANCES)
    for order, _, _ in oscillator.harmonics:
        parts |= {f"amplitude_{order:g}": _HARMONIC, f"phase_{order:g}": _HARMONIC}
    for name, each in parts.items():
        value = oscillator.value_of(name)
        ranges[name] = (
            value * (1.0 - _BELOW * part * each),
            min(value * (1.0 + part * each), 1.0 if name == "restitution" else math.inf),
        )
    return ranges


def some_within(oscillator, ranges, random):
    """An oscillator within tolerances; its parameters are at their ends as often as not."""
    chosen = {}
    for name, (low, high) in ranges.items():
        chosen[name] = float(random.choice([low, high, random.uniform(low, high)]))
    return oscillator.at(**chosen)


def machine_and_some(oscillator, part, random):
    """The enclosure of an oscillator within `part` of the tolerances, and one of those it holds."""
    if part == 0.0:
        return machine_of(oscillator), oscillator
    ranges = tolerances_of(oscillator, part)
    return machine_of(oscillator, ranges), some_within(oscillator, ranges, random)


def boxes_of_departures(oscillator, count, random):
    """Boxes of all sizes: anywhere, near grazing, and at tiny speeds. Shape (count, 4)."""
    fastest = 1.5 * largest_grazing_speed(oscillator)
    t = random.random(count)
    grazing = grazing_velocity(oscillator, t)
    near = grazing * (1.0 + random.choice([-1.0, 1.0], count) * 10.0 ** random.uniform(-14.0, -1.0, count))
    tiny = fastest * 10.0 ** random.uniform(-12.0, 0.0, count)
    v = np.choose(random.integers(0, 3, count), [random.uniform(0.0, fastest, count), near, tiny])
    # Tiny bounces are short: so are their boxes.
    width, height = 10.0 ** random.uniform([[-12.0], [-12.0]], [[-2.0], [-1.0]], (2, count))
    width, height = width * np.minimum(v / fastest, 1.0), height * v
    return np.stack([t - width, t + width, v - height, v + height], axis=1)


def departures_in(boxes, random):
    """A departure of each box; at its corners and edges as often as not."""
    part = random.choice([0.0, 1.0, 0.5], (2, len(boxes)))
    part = np.where(random.random((2, len(boxes))) < 0.5, part, random.random((2, len(boxes))))
    t = boxes[:, 0] + part[0] * (boxes[:, 1] - boxes[:, 0])
    v = boxes[:, 2] + part[1] * (boxes[:, 3] - boxes[:, 2])
    return np.clip(t, boxes[:, 0], boxes[:, 1]), np.clip(v, boxes[:, 2], boxes[:, 3])

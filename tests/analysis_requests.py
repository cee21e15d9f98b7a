"""A small request of each kind of analysis."""

OSCILLATOR = {"damping": 0.575, "eccentricity": 0.1, "half_backlash": 0.6}
DIAGRAM = {
    "oscillator": OSCILLATOR,
    "vary": {"parameter": "damping", "start": 0.59, "stop": 0.6, "count": 11},
    "seeds": [{"time": 0.47, "velocity": 2.2}, {"time": 0.9, "velocity": 3.7}],
    "direction": "both",
    "transient": 300,
}
ORBITS = {
    "oscillator": OSCILLATOR,
    "longest": 2,
    "region": {"time": {"start": 0, "stop": 1}, "velocity": {"start": 1, "stop": 4.5}},
    "cells": 12,
    "continuation": {"parameter": "damping", "start": 0.55, "stop": 0.65},
}
MANIFOLD = {"saddles": [{"time": 0.6, "velocity": 3.77}], "side": "both", "arclength": 3}
GRAZING = {"order": 1}
REPORT = {
    # Nearly the paper's numbers: some of its departures end in rattle.
    "machine": {
        "speed": 100.0, "inertia": 0.01, "drag_torque": 9.5493, "base_radius": 0.1, "backlash": 0.12,
        "transmission_error": 0.01,
    },
    "cells": 24,
    "speeds": 3,
    "departures": 64,
    "numbers": {"backlash": [0.11, 0.13]},
    "machines": 64,
}  # fmt: skip
CHART = {
    "first": {"parameter": "damping", "start": 0.75, "stop": 0.78},
    "second": {"parameter": "eccentricity", "start": 0.094, "stop": 0.0995},
    "longest": 1,
    "lines": 1,
    "cells": 8,
    "pixels": 2,
    "departures": 6,
}
ROUTES = {
    "bifurcations": DIAGRAM, "orbits": ORBITS, "manifolds": MANIFOLD, "grazing-curves": GRAZING, "reports": REPORT,
    "charts": CHART,
}  # fmt: skip

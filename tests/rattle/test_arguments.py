"""Arguments of the verbs make the requests that JSON makes, and wrong ones are named as they were written."""

import numpy as np
import pytest

import rattle
from rattle import verbs
from rattle.arguments import job_of
from rattle.verbs import VERBS
from rattle_kernels import Oscillator
from worker.jobs.swept_parameter import Spacing
from worker.kinds import KINDS

KIND_OF = {verb.__name__: kind for kind, verb in VERBS.items()}


def job(verb, **given):
    return job_of(KIND_OF[verb], given)


@pytest.mark.parametrize(
    ("verb", "given", "request_"),
    [
        ("basin", {}, {}),
        (
            "basin", {"damping": 0.5, "cells": 20, "velocity": (1, 6), "time": [0.9, 1.1], "iterations": 101},
            {
                "oscillator": {"damping": 0.5}, "iterations": 101,
                "grid": {"time": {"start": 0.9, "stop": 1.1, "cells": 20},
                         "velocity": {"start": 1, "stop": 6, "cells": 20}},
            },
        ),
        ("basin", {"cells": (30, 20)}, {"grid": {"time": {"cells": 30}, "velocity": {"cells": 20}}}),
        ("basin", {"prove": True, "cells": 9}, {"prove": {}, "grid": {"time": {"cells": 9}, "velocity": {"cells": 9}}}),
        ("basin", {"prove": False}, {}),
        ("basin", {"prove": True, "levels": 1, "tolerances": {"damping": (0.5, 0.7)}},
         {"prove": {"levels": 1, "tolerances": {"damping": [0.5, 0.7]}}}),
        ("basin", {"prove": True, "damping": (0.5, 0.75), "half_backlash": [0.5, 0.75]},
         {"oscillator": {"damping": 0.625, "half_backlash": 0.625},
          "prove": {"tolerances": {"damping": [0.5, 0.75], "half_backlash": [0.5, 0.75]}}}),
        ("basin", {"sample": np.int64(50), "seed": 3}, {"sample": {"points": 50, "seed": 3}}),
        ("basin", {"sample": 64, "scramblings": 8}, {"sample": {"points": 64, "scramblings": 8}}),
        (
            "basin", {"stiffness": np.float64(1e3), "permanent_contact": "one_rotation", "cells": 9},
            {
                "oscillator": {
                    "model": "piecewise_linear", "stiffness": 1e3, "permanent_contact": "one_rotation",
                },
                "grid": {"time": {"cells": 9}, "velocity": {"cells": 9}},
            },
        ),
        (
            "sweep", {"damping": np.array([0.5, 0.6]), "eccentricity": 0.09},
            {
                "oscillator": {"eccentricity": 0.09}, "vary": [{"parameter": "damping", "values": [0.5, 0.6]}],
                "grid": {"time": {"cells": 200}, "velocity": {"cells": 200}},
            },
        ),
        (
            "sweep", {"stiffness": [100.0, 1000.0], "damping": (0.5, 0.7, 3, "geometric"), "cells": 10},
            {
                "oscillator": {"model": "piecewise_linear"},
                "vary": [
                    {"parameter": "stiffness", "values": [100.0, 1000.0]},
                    {"parameter": "damping", "start": 0.5, "stop": 0.7, "count": 3, "spacing": Spacing.GEOMETRIC},
                ],
                "grid": {"time": {"cells": 10}, "velocity": {"cells": 10}},
            },
        ),
        (
            "bifurcation", {"damping": (0.5, 0.6, 11), "seeds": [(0.7, 4.0)], "direction": "both"},
            {
                "kind": "bifurcation", "vary": {"parameter": "damping", "start": 0.5, "stop": 0.6, "count": 11},
                "seeds": [{"time": 0.7, "velocity": 4.0}], "direction": "both",
            },
        ),
        (
            "orbits",
            {
                "seeds": [(0.7, 4.0, 2)], "continuation": {"damping": (0.5, 0.7)},
                "curves": {"eccentricity": (0, 0.1, 9)},
            },
            {
                "kind": "orbits", "seeds": [{"time": 0.7, "velocity": 4.0, "period": 2}],
                "continuation": {"parameter": "damping", "start": 0.5, "stop": 0.7},
                "curves": {"parameter": "eccentricity", "start": 0, "stop": 0.1, "most_points": 9},
            },
        ),
        (
            "orbits", {"longest": 2, "time": (0, 0.5), "cells": 8},
            {"kind": "orbits", "longest": 2, "region": {"time": {"start": 0, "stop": 0.5}}, "cells": 8},
        ),
        (
            "manifolds", {"saddles": ["P(1,1,0)", (0.89, 3.988)], "chord": 1e-3, "side": "both"},
            {
                "kind": "manifold", "saddles": [{"itinerary": "P(1,1,0)"}, {"time": 0.89, "velocity": 3.988}],
                "resolution": {"chord": 1e-3, "finest": 1e-6}, "side": "both",
            },
        ),
        ("grazing_curve", {"order": 1}, {"kind": "grazing_curve", "order": 1}),
    ],
)  # fmt: skip
def test_arguments_make_the_request_that_json_makes(verb, given, request_):
    if "resolution" in request_:
        finest = KINDS["manifold"].job_class(saddles=[{"itinerary": "P(1,1,0)"}]).resolution.finest
        request_["resolution"]["finest"] = min(finest, 1e-3)
    assert job(verb, **given).digest == KINDS[KIND_OF[verb]].job_class.from_request(request_).digest


@pytest.mark.parametrize(
    ("verb", "given", "error", "told"),
    [
        ("basin", {"dampign": 0.6}, TypeError, "unexpected keyword argument 'dampign'"),
        ("basin", {"colour": 1}, TypeError, "unexpected keyword argument 'colour'"),
        ("basin", {"damping": "0.6"}, ValueError, "^damping: Input should be a valid number"),
        ("basin", {"damping": [0.5, 0.6]}, ValueError, "several values"),
        ("basin", {"cells": 0}, ValueError, "^cells: "),
        ("basin", {"cells": (1, 2, 3)}, ValueError, "cells is a number, or a pair"),
        ("basin", {"time": 0.5}, ValueError, "time is a pair"),
        ("basin", {"cells": 10, "sample": 100}, ValueError, "a sample has no cells"),
        ("basin", {"eccentricity": 0.3, "stiffness": 1e4}, ValueError, "epsilon_crit1"),
        ("basin", {"permanent_contact": "one_rotation"}, ValueError, "give a stiffness"),
        ("basin", {"damping": (0.5, 0.7)}, ValueError, r"one value here; .* a proof \(prove=True\) a tolerance"),
        ("basin", {"levels": 2}, ValueError, "levels belongs to a proof: give prove=True"),
        ("basin", {"seed": 5}, ValueError, "seed belongs to a sample: give its points"),
        ("sweep", {"damping": [0.5, 0.6], "scramblings": 4}, ValueError, "scramblings belongs to a sample"),
        ("basin", {"tolerances": {"damping": (0.5, 0.7)}}, ValueError, "tolerances belongs to a proof"),
        ("basin", {"prove": True, "levels": 9}, ValueError, "^levels: "),
        ("basin", {"prove": True, "stiffness": 100.0}, ValueError, "only the impacting model is proven"),
        ("basin", {"prove": True, "tolerances": {"mass": (1, 2)}}, ValueError, "mass has no tolerance"),
        ("sweep", {"dampign": [0.5, 0.6]}, TypeError, "unexpected keyword argument 'dampign'"),
        ("sweep", {"damping": 0.6}, ValueError, "give several values of one or two of damping"),
        ("sweep", {"damping": (0.5, 0.6)}, ValueError, "a list or an array, or"),
        ("bifurcation", {"damping": [0.5], "eccentricity": [0.1]}, ValueError, "several values of one of"),
        ("bifurcation", {"damping": [0.5], "seeds": [(1,)]}, ValueError, "seeds are a list of departures"),
        ("orbits", {"seeds": 5}, ValueError, "seeds are a list of departures"),
        ("manifolds", {"saddles": (0.89, 3.99)}, ValueError, "saddles are a list of departures"),
        ("orbits", {"continuation": 3}, ValueError, "continuation is written as in"),
        ("orbits", {"continuation": {"damping": 0.5}}, ValueError, "followed between two values"),
        ("manifolds", {}, TypeError, "missing 1 required keyword-only argument: 'saddles'"),
        ("manifolds", {"saddles": ["P(1,1)"]}, ValueError, "an itinerary is"),
        (
            "manifolds",
            {"saddles": ["P(1,1,0)"], "stiffness": 100.0},
            TypeError,
            "unexpected keyword argument 'stiffness'",
        ),
    ],
)
def test_a_wrong_argument_is_named_before_anything_is_computed(verb, given, error, told):
    with pytest.raises(error, match=told):
        getattr(rattle, verb)(**given)


def test_all_that_is_swept_is_in_the_order_of_the_arguments(monkeypatch):
    monkeypatch.setattr(verbs, "compute", lambda job, **_: [each.parameter for each in job.vary])
    assert rattle.sweep(eccentricity=[0.09, 0.1], damping=[0.5, 0.6], cells=10) == ["eccentricity", "damping"]
    amplitudes = {"amplitude_2": [0.001, 0.002], "damping": np.array([0.5, 0.6]), "harmonics": [(2, 0.001)]}
    assert rattle.sweep(**amplitudes, cells=10) == ["amplitude_2", "damping"]


def test_an_argument_with_its_default_value_says_nothing(monkeypatch):
    monkeypatch.setattr(verbs, "compute", lambda job, **_: job)
    assert rattle.basin(sample=64, cells=1000, seed=0).digest == job("basin", sample=64).digest
    assert rattle.basin(restitution=1.0, stiffness=100.0).oscillator == Oscillator(stiffness=100.0)
    assert rattle.basin(damping=0.6, cells=9).digest == job("basin", cells=9).digest

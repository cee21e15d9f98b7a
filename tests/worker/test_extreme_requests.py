"""Extreme requests of every kind, drawn: each ends, is refused with a reason, or is left at a pause; none warns."""

import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rattle_kernels import OutsideDomain
from tests.watched_run import Watch, run_watched
from worker.errors import InvalidFields, InvalidJob, NotFound
from worker.kinds import KINDS

# Above what a service allows; a laptop's memory holds it.
MOST_BYTES = 10**8
DAMPING, HALF_BACKLASH, STIFFNESS = (-6.0, 6.0), (-9.0, 6.0), (-3.0, 15.0)


def powers(lowest, highest):
    """Numbers between two powers of ten, as likely small as large."""
    return st.floats(lowest, highest).map(lambda power: 10.0**power)


def counts(largest):
    """Whole numbers from 1, as likely small as large."""
    return powers(0.0, len(str(largest)) - 1.0).map(int)


OSCILLATORS = st.fixed_dictionaries(
    {"damping": powers(*DAMPING), "half_backlash": powers(*HALF_BACKLASH)},
    optional={"eccentricity": powers(-9.0, 0.0)},
)
STIFF = st.tuples(OSCILLATORS, powers(*STIFFNESS), st.booleans()).map(
    lambda drawn: drawn[0] | {"model": "piecewise_linear", "stiffness": drawn[1], "allow_no_quiet_solution": drawn[2]}
)
EITHER_MODEL = OSCILLATORS | STIFF
SPEEDS = powers(-9.0, 9.0)
INTERVALS = SPEEDS.map(lambda stop: {"start": 0, "stop": stop})
PHASES = st.floats(0.0, 1.0)
REGIONS = INTERVALS.map(lambda velocity: {"time": {"start": 0, "stop": 1}, "velocity": velocity})
SEEDS = st.lists(st.fixed_dictionaries({"time": PHASES, "velocity": SPEEDS}), min_size=1, max_size=3)
BEGINNINGS = st.fixed_dictionaries({"seeds": SEEDS}) | st.fixed_dictionaries({"region": REGIONS})
VARY = st.tuples(powers(*DAMPING), powers(*DAMPING), st.integers(2, 50)).map(
    lambda drawn: {"parameter": "damping", "start": min(drawn[:2]), "stop": max(drawn[:2]), "count": drawn[2]}
)
FOLLOWED = st.tuples(powers(*DAMPING), powers(*DAMPING)).map(
    lambda ends: {"parameter": "damping", "start": min(ends), "stop": max(ends)}
)
GRIDS = st.tuples(counts(1000), counts(1000), INTERVALS).map(
    lambda drawn: {"time": {"cells": drawn[0]}, "velocity": drawn[2] | {"cells": drawn[1]}}
)
PRIMES = st.sampled_from([1, 2, 3, 61, 1499, 15013, 10_000_019])
REQUESTS = {
    "basin": st.fixed_dictionaries(
        {"oscillator": EITHER_MODEL, "grid": GRIDS}, optional={"iterations": PRIMES},
    ),
    "sweep": st.fixed_dictionaries(
        {"oscillator": EITHER_MODEL, "grid": GRIDS, "vary": st.lists(VARY, min_size=1, max_size=1)},
        optional={"iterations": PRIMES},
    ),
    "bifurcation": st.fixed_dictionaries(
        {"oscillator": EITHER_MODEL, "vary": VARY, "transient": counts(10**9), "kept": counts(10**6)},
        optional={"direction": st.sampled_from(["up", "down", "both"])},
    ).flatmap(lambda request: BEGINNINGS.map(lambda beginning: request | beginning)),
    "orbits": st.fixed_dictionaries(
        {"oscillator": EITHER_MODEL, "longest": counts(1000), "cells": counts(100), "region": REGIONS},
        optional={"continuation": FOLLOWED},
    ),
    "manifold": st.fixed_dictionaries(
        {"oscillator": OSCILLATORS, "saddles": SEEDS, "arclength": powers(-3.0, 6.0)},
        optional={"side": st.sampled_from(["stable", "unstable", "both"]), "velocity": INTERVALS},
    ),
    "grazing_curve": st.fixed_dictionaries(
        {"oscillator": OSCILLATORS, "order": st.integers(0, 16)}, optional={"velocity": INTERVALS},
    ),
}  # fmt: skip
each_kind = pytest.mark.parametrize("kind", REQUESTS)


def ends_well(kind, request, pauses):
    """Run a request; any error that is not a documented refusal passes, and so does any warning."""
    try:
        job = KINDS[kind].job_class.from_request(request)
    except (OutsideDomain, InvalidJob, InvalidFields) as refusal:
        assert str(refusal)
        return
    if job.bytes > MOST_BYTES:
        return
    watch = Watch(pauses=pauses)
    with tempfile.TemporaryDirectory() as folder:
        try:
            ended = run_watched(job, Path(folder) / "store.zarr", watch)
        except NotFound as refusal:
            assert str(refusal)
            return
    # Whoever is cancelled leaves at once: it does not call again.
    assert ended or watch.left == -1


SEED = [{"time": 0.553, "velocity": 4.703}]
CHAOTIC = {"parameter": "damping", "values": [0.6]}
ENDLESS = {
    "long transient": ("bifurcation", {"vary": CHAOTIC, "seeds": SEED, "transient": 4_000_000_000_000}),
    "much kept": ("bifurcation", {"vary": CHAOTIC, "seeds": SEED, "kept": 5_000_000}),
    "long orbits": ("orbits", {"longest": 9999, "cells": 10}),
    "fine pre-images": ("grazing_curve", {"order": 16, "resolution": {"chord": 1e-4}, "most_points": 2_000_000}),
}


@pytest.mark.parametrize("name", ENDLESS)
def test_a_task_that_takes_minutes_pauses_many_times(name, tmp_path):
    kind, request = ENDLESS[name]
    watch = Watch(pauses=30)
    assert not run_watched(KINDS[kind].job_class.from_request(request), tmp_path / "store.zarr", watch)
    # The first task of all is left: between its pauses it does some thousand impacts.
    assert watch.tasks == 1


@each_kind
def test_an_extreme_request_ends_or_is_refused_or_is_left(kind):
    @settings(max_examples=12)
    @given(REQUESTS[kind])
    def drawn(request):
        ends_well(kind, request, pauses=4)

    drawn()


@pytest.mark.slow
@pytest.mark.timeout(3600)
@each_kind
def test_many_extreme_requests_end_or_are_refused_or_are_left(kind):
    @settings(max_examples=150)
    @given(REQUESTS[kind])
    def drawn(request):
        ends_well(kind, request, pauses=12)

    drawn()

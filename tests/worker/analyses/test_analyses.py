"""Diagrams, orbits, manifolds and grazing curves: resumable, the same to the byte, cancelled soon."""

import json
import re
import threading
from itertools import pairwise

import numpy as np
import pytest
import xarray as xr

from rattle_kernels import (
    Oscillator,
    bifurcation_diagram,
    find_orbits,
    find_saddle,
    grazing_preimages,
    stable_manifold,
)
from tests.waiting import wait_until
from tests.worker.basins.test_pipeline import content
from worker.analyses.bifurcation import BIFURCATION
from worker.analyses.grazing_curves import orders_of
from worker.analyses.manifolds import branches_of
from worker.analyses.orbit_tables import orbits_of
from worker.cluster.driver import Driver
from worker.errors import InvalidJob, JobCancelled, NotFound, StoreConflict
from worker.jobs.basin_job import BasinJob
from worker.jobs.bifurcation_job import BifurcationJob, Direction
from worker.jobs.grazing_curve_job import GrazingCurveJob
from worker.jobs.manifold_job import Itinerary, ManifoldJob, Side
from worker.jobs.orbits_job import Continuation, OrbitSeed, OrbitsJob
from worker.jobs.region import Departure, Interval, Region
from worker.jobs.swept_parameter import Spacing, SweptParameter
from worker.kinds import KINDS
from worker.pictures.figure_file import save_figure
from worker.progress import Stage
from worker.results.figure import figure_of_store
from worker.run import run_job
from worker.stores.analysis_store import AnalysisStore, kind_of_store
from worker.stores.layout import MISSING

DAMPING = SweptParameter.spaced("damping", 0.59, 0.6, 120, Spacing.LINEAR)
SEEDS = (Departure(0.9, 3.7), Departure(0.553, 4.703))
DIAGRAM = BifurcationJob(vary=DAMPING, seeds=SEEDS, direction=Direction.BOTH, transient=4_000)
ORBITS = OrbitsJob(
    oscillator=Oscillator(damping=0.575), longest=2, region=Region(velocity=Interval(1.0, 4.5)), cells=12,
    continuation=Continuation("damping", 0.55, 0.65),
)  # fmt: skip
MANIFOLD = ManifoldJob(saddles=(OrbitSeed(0.6, 3.77), OrbitSeed(0.89, 3.988)), arclength=3.0)
GRAZING = GrazingCurveJob(order=2)
JOBS = [DIAGRAM, ORBITS, MANIFOLD, GRAZING]
each_kind = pytest.mark.parametrize("job", JOBS, ids=lambda job: job.kind)


def run(job, location, client, *, report=lambda _: None, cancel=None):
    cancel = cancel or threading.Event()
    run_job(job, str(location), Driver(client), report=report, cancel=cancel)
    return KINDS[job.kind].summarise(str(location))


@pytest.fixture(scope="session")
def stores(client, tmp_path_factory):
    """A store of each kind, computed without disturbance."""
    folder = tmp_path_factory.mktemp("analyses")
    for job in JOBS:
        run(job, folder / job.kind, client)
    return folder


@each_kind
def test_a_job_is_its_request(job):
    again = KINDS[job.kind].job_class.from_request(json.loads(json.dumps(job.request())))
    assert again == job and again.digest == job.digest
    assert len({each.digest for each in JOBS}) == len(JOBS)


@pytest.mark.parametrize(
    "job",
    [pytest.param(DIAGRAM, marks=pytest.mark.slow), *JOBS[1:]],
    ids=lambda job: job.kind,
)
def test_a_cancelled_job_says_what_is_missing_and_resumes_to_the_same_bytes(client, stores, tmp_path, job):
    cancel, location = threading.Event(), tmp_path / "store"

    def cancel_soon(progress):
        if progress.tiles_done == 1:
            cancel.set()

    with pytest.raises(JobCancelled):
        run(job, location, client, report=cancel_soon, cancel=cancel)
    partial = KINDS[job.kind].summarise(str(location))
    assert not partial.complete and partial.pieces_done >= 1
    save_figure(figure_of_store(str(location)), tmp_path / "partial.png")
    with xr.open_zarr(location) as store:
        assert not store.attrs["complete"] and store.sizes
    seen = []
    assert run(job, location, client, report=seen.append).complete
    assert seen[0].tiles_done >= 1 or seen[0].stage != Stage.SEARCHING, "what was there is not computed again"
    assert content(location) == content(stores / job.kind)


def test_files_that_others_write_are_no_parts(client, tmp_path):
    cancel = threading.Event()
    cancel.set()
    with pytest.raises(JobCancelled):
        run(GRAZING, tmp_path / "store", client, cancel=cancel)
    store = AnalysisStore(str(tmp_path / "store"))
    store.write_part("done", {"numbers": np.arange(3)})
    parts = tmp_path / "store" / "parts"
    (parts / "zarr.0123.partial").write_bytes(b"{")
    (parts / "begun").mkdir()
    assert list(store.parts()) == ["done"]


@pytest.mark.parametrize(
    "job", [*(pytest.param(job, marks=pytest.mark.slow) for job in JOBS[:2]), *JOBS[2:]], ids=lambda job: job.kind
)
def test_who_reads_while_the_driver_finishes_is_told_the_end(client, stores, tmp_path, job, monkeypatch):
    location = tmp_path / "store"
    read, finished = AnalysisStore.parts, []

    def finish_first(store):
        found = read(store)
        if not finished:
            finished.append(True)
            with monkeypatch.context() as unwatched:
                unwatched.setattr(AnalysisStore, "parts", read)
                run(job, location, client)
        return found

    cancel = threading.Event()
    with pytest.raises(JobCancelled):
        run(job, location, client, report=lambda progress: progress.tiles_done and cancel.set(), cancel=cancel)
    monkeypatch.setattr(AnalysisStore, "parts", finish_first)
    told = KINDS[job.kind].summarise(str(location))
    assert finished and told.complete
    same = told.model_dump(exclude={"zarr", "seconds"})
    assert same == KINDS[job.kind].summarise(str(stores / job.kind)).model_dump(exclude={"zarr", "seconds"})


@each_kind
def test_a_complete_store_answers_at_once_and_stays(client, stores, job):
    before, seen = content(stores / job.kind), []
    assert run(job, stores / job.kind, client, report=seen.append).complete
    assert seen == [] and content(stores / job.kind) == before


@each_kind
def test_pictures_are_the_same_to_the_byte(stores, tmp_path, job):
    formats = [("png", b"\x89PNG")] + [("svg", b"<?xml"), ("pdf", b"%PDF")] * (job is GRAZING)
    for ending, first in formats:
        one, other = tmp_path / f"one.{ending}", tmp_path / f"other.{ending}"
        for target in (one, other):
            save_figure(figure_of_store(str(stores / job.kind)), target)
        assert one.read_bytes() == other.read_bytes() and one.read_bytes().startswith(first)


def test_cancelling_is_noticed_while_a_piece_is_computed(client, tmp_path):
    # An hour's work, and more than a test may take: what ends before has been cancelled.
    endless = BifurcationJob(vary=DAMPING, seeds=SEEDS[1:], transient=10**12)
    cancel = threading.Event()

    def cancel_at_work():
        wait_until("a worker is at work", lambda: any(client.processing().values()))
        cancel.set()

    threading.Thread(target=cancel_at_work).start()
    with pytest.raises(JobCancelled):
        run(endless, tmp_path / "store", client, cancel=cancel)
    wait_until("no worker goes on with what nobody wants", lambda: not any(client.processing().values()))


def test_a_diagram_is_that_of_the_kernels_whatever_the_stretches(stores):
    direct = bifurcation_diagram(
        Oscillator(),
        "damping",
        DAMPING.values,
        *np.array([(seed.time, seed.velocity) for seed in SEEDS]).T,
        direction="both",
        transient=DIAGRAM.transient,
    )
    with xr.open_zarr(stores / "bifurcation") as store:
        np.testing.assert_array_equal(store.damping, direct.values)
        np.testing.assert_array_equal(store.velocity, direct.v)
        np.testing.assert_array_equal(store.impact_period, direct.period)
        assert store.way.values.tolist() == [1] * 120 + [-1] * 120


def test_of_a_diagram_without_seeds_the_search_for_them_is_the_first_of_its_stages():
    job = BifurcationJob(vary=DAMPING, transient=4_000)
    stage, ready, done, total = BIFURCATION.plan(job, {})
    assert (stage, [piece.name for piece in ready], done, total) == (Stage.SEARCHING, ["seeds"], 0, 1)


def test_stretches_of_a_diagram_follow_each_other_without_gaps():
    values = np.linspace(0.5, 0.6, 6)
    columns = {
        "damping": np.concatenate([values, values[::-1]]), "way": np.repeat([1, -1], 6),
        "outcome": np.array([[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, MISSING, MISSING]]).T,
        "impact_period": np.array([[1, 1, 2, 2, 2, 0, 0, 0, 1, 1, MISSING, MISSING]]).T,
        "seed_name": np.array(["given"]), "seed_time": np.array([0.25]), "seed_velocity": np.array([4.5]),
    }  # fmt: skip
    job = BifurcationJob(vary=SweptParameter("damping", tuple(values)), seeds=(Departure(0.25, 4.5),), direction="both")
    told = BIFURCATION.summarise(job, columns)
    assert (told["parameter"], told["values_visited"]) == ("damping", 12)
    (motion,) = told["motions"]
    assert (motion.name, motion.time, motion.velocity, motion.stretches_total) == ("given", 0.25, 4.5, 6)
    assert [tuple(run.model_dump().values()) for run in motion.stretches] == [
        ("impact period 1", "up", values[0], values[1], 2), ("impact period 2", "up", values[2], values[4], 3),
        ("no period seen", "up", values[5], values[5], 1), ("no period seen", "down", values[5], values[4], 2),
        ("impact period 1", "down", values[3], values[2], 2), ("not computed", "down", values[1], values[0], 2),
    ]  # fmt: skip


def test_orbits_are_those_of_the_undivided_search(stores):
    region = ORBITS.region
    direct = find_orbits(ORBITS.oscillator, 2, region.time.ends, region.velocity.ends, cells=12)
    with xr.open_zarr(stores / "orbits") as store:
        found = orbits_of(store)
        assert [each.orbit.name for each in found] == [each.orbit.name for each in direct]
        for one, other in zip(found, direct, strict=True):
            np.testing.assert_allclose(one.orbit.v, other.orbit.v, rtol=1e-9)
        assert store.orbit_branch.values.min() == 0, "every orbit lies on a branch that is kept"
        assert store.sizes["branch"] < store.sizes["orbit"]
        assert int(store.branch_size.sum()) == store.sizes["branch_point"]


def test_branches_of_manifolds_are_those_grown_at_once(stores):
    direct = stable_manifold(Oscillator(), find_saddle(Oscillator(), 0.6, 3.77), MANIFOLD.limits)
    with xr.open_zarr(stores / "manifold") as store:
        grown = branches_of(store, Side.STABLE, orbit=0)
        assert [(branch.side, branch.end) for branch in grown] == [(branch.side, branch.end) for branch in direct]
        for one, other in zip(grown, direct, strict=True):
            assert len(one.pieces) == len(other.pieces)
            # The two saddles differ in the last digit, and the points along the curve a little more.
            np.testing.assert_allclose(one.pieces[-1].v, other.pieces[-1].v, rtol=1e-6)


def test_pre_images_of_stretches_are_those_of_the_whole_curve(stores):
    direct = grazing_preimages(Oscillator(), 2, velocity_limits=(0.0, 7.0))
    with xr.open_zarr(stores / "grazing_curve") as store:
        for one, other in zip(orders_of(store), direct, strict=True):
            assert sorted(piece.v.size for piece in one) == sorted(piece.v.size for piece in other)
            assert sum(piece.v.sum() for piece in one) == pytest.approx(sum(piece.v.sum() for piece in other))


def test_an_order_that_needs_too_many_points_says_that_it_is_incomplete(client, tmp_path):
    run(GrazingCurveJob(order=4, most_points=1000), tmp_path / "store", client)
    with xr.open_zarr(tmp_path / "store") as store:
        complete = store.order_complete.values.tolist()
    assert complete[0] == 1 and complete[-1] == 0
    assert all(one >= other for one, other in pairwise(complete))


def test_saddles_of_an_itinerary_are_found_and_other_orbits_are_named(client, tmp_path):
    asked = ManifoldJob(saddles=(Itinerary(1, 1, 0),), cells=12, arclength=0.5)
    told = run(asked, tmp_path / "store", client)
    assert [saddle.departures[0].velocity for saddle in told.saddles] == [pytest.approx(3.7699111843)]
    missing = ManifoldJob(saddles=(Itinerary(1, 1, 3),), cells=12)
    with pytest.raises(NotFound, match=r"no saddle P\(1,1,3\); it found P\(1,1,0\)"):
        run(missing, tmp_path / "missing", client)


def test_an_itinerary_of_two_saddles_selects_none_and_both_are_listed(client, tmp_path):
    """The refused request names what the next one needs: a departure of each."""
    with pytest.raises(NotFound, match=r"saddle 1: the search found 2 saddles P\(1,1,1\)") as refused:
        run(ManifoldJob(saddles=(Itinerary(1, 1, 1),), cells=12, arclength=0.5), tmp_path / "two", client)
    departures = re.findall(r"(0\.\d+),(\d\.\d+),1", str(refused.value))
    assert [float(v) for _, v in departures] == [pytest.approx(3.98824019585), pytest.approx(4.57125641142)]
    seed = OrbitSeed(*map(float, departures[0]))
    told = run(ManifoldJob(saddles=(seed,), arclength=0.5), tmp_path / "one", client)
    assert told.saddles[0].departures[0].velocity == pytest.approx(3.98824019585)


def test_another_kinds_store_is_not_touched(client, stores, tmp_path):
    before = content(stores / "orbits")
    with pytest.raises(StoreConflict, match="holds the store of another request"):
        run(GRAZING, stores / "orbits", client)
    with pytest.raises(StoreConflict, match="is no basin store: it is one of kind orbits"):
        cancel = threading.Event()
        run_job(BasinJob(), str(stores / "orbits"), Driver(client), report=lambda _: None, cancel=cancel)
    assert content(stores / "orbits") == before and kind_of_store(str(stores / "orbits")) == "orbits"
    with pytest.raises(StoreConflict, match="no store"):
        AnalysisStore(str(tmp_path / "nothing"))


@pytest.mark.parametrize(
    ("job", "changes", "told"),
    [
        (BifurcationJob, {"vary": DAMPING, "seeds": ({"time": 0.1, "velocity": 0.0},)}, "section of departures"),
        (BifurcationJob, {"vary": SweptParameter("damping", ())}, "at least one value"),
        (BifurcationJob, {"vary": SweptParameter("stiffness", (1.0,))}, "in the impacting model"),
        (OrbitsJob, {"seeds": ({"time": 0.1, "velocity": 1.0, "period": 0},)}, "period must be 1 or more"),
        (OrbitsJob, {"region": {"time": {"start": 0.5, "stop": 0.2}}}, "phases of the region"),
        (OrbitsJob, {"continuation": Continuation("stiffness", 1.0, 10.0)}, "hold its value inf"),
        (ManifoldJob, {"saddles": ()}, "saddles: .*at least 1 item"),
        (ManifoldJob, {"saddles": (OrbitSeed(0.1, 1.0),), "arclength": float("inf")}, "arclength: .*finite"),
        (GrazingCurveJob, {"order": -1}, "order must be 0"),
    ],
)  # fmt: skip
def test_a_job_that_cannot_be_is_refused_where_it_is_made(job, changes, told):
    with pytest.raises(InvalidJob, match=told):
        job(**changes)

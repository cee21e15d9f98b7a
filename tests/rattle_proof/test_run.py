"""A proof through the pipeline: the same bytes from one thread and from two, and after a driver has died."""

import shutil
import threading

import numpy as np
import pytest
from distributed import Client

import rattle
from rattle_kernels import CellGrid, Oscillator, next_impacts
from rattle_proof.arrays import proof_of
from rattle_proof.enclosures.cells import WHOLE
from rattle_proof.layout import NEVER_QUIET, PROVEN, UNPROVEN_REASON, Unproven
from rattle_proof.request import LEVELS, first_columns
from tests.store_content import content
from worker.cluster.driver import Driver
from worker.errors import JobCancelled
from worker.jobs.basin_job import BasinJob
from worker.progress import Stage
from worker.run import run_job
from worker.stores.basin_store import BasinStore
from worker.stores.new_store import consolidate
from worker.stores.opening import open_group

_EVER, _OF_WINDOWS = ("ends", "never_quiet", "rattling", "rounds"), ("window_ends", "window_order")
ENCLOSING, PROVING = Stage("enclosing"), Stage("proving")
pytestmark = pytest.mark.timeout(400)
# Losing energy, most departures fall quiet soon.
LOSSY = Oscillator(0.6, 0.1, 0.6, restitution=0.9)
JOB = BasinJob(oscillator=LOSSY, grid=CellGrid(time_cells=70, velocity_cells=66), prove={"levels": 1})


def run(job, location, threads=1, report=lambda _: None, cancel=None):
    with Client(processes=False, n_workers=1, threads_per_worker=threads, dashboard_address=None) as client:
        run_job(job, str(location), Driver(client), report=report, cancel=cancel or threading.Event())
    return BasinStore(str(location))


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return run(JOB, tmp_path_factory.mktemp("proven") / "whole.zarr")


def test_two_threads_give_the_same_bytes(store, tmp_path):
    assert content(run(JOB, tmp_path / "again.zarr", threads=2).location) == content(store.location)


@pytest.mark.parametrize("stage", [ENCLOSING, PROVING])
def test_a_proof_that_was_stopped_goes_on_to_the_same_bytes(store, tmp_path, stage):
    cancel, seen = threading.Event(), []

    def stop(progress):
        seen.append(progress.stage)
        if seen.count(stage) == 2:
            cancel.set()

    with pytest.raises(JobCancelled):
        run(JOB, tmp_path / "stopped.zarr", report=stop, cancel=cancel)
    assert not BasinStore(str(tmp_path / "stopped.zarr")).complete
    assert content(run(JOB, tmp_path / "stopped.zarr").location) == content(store.location)


def test_a_level_that_has_grown_is_not_done_again(tmp_path):
    stages = []
    cancel = threading.Event()

    def stop(progress):
        stages.append(progress.stage)
        if progress.stage is PROVING:
            cancel.set()

    with pytest.raises(JobCancelled):
        run(JOB, tmp_path / "grown.zarr", report=stop, cancel=cancel)
    assert proof_of(BasinStore(str(tmp_path / "grown.zarr"))).levels_grown == LEVELS
    again = []
    run(JOB, tmp_path / "grown.zarr", report=lambda progress: again.append(progress.stage))
    assert ENCLOSING not in again and PROVING in again


def test_the_certificate_says_what_the_arrays_say(store):
    certificate = proof_of(store).certificate
    proven, reason = store.read_whole((PROVEN, UNPROVEN_REASON))
    solution = store.read_solution(0)
    ends, rounds = proof_of(store).read_lattice(LEVELS, True)
    counts, shares = certificate["counts"], np.array(certificate["shares"])
    assert counts["whole"] == (proven == WHOLE).sum() == (reason == Unproven.PROVEN).sum() > 0
    assert counts["reasons"] == np.bincount(reason.ravel(), minlength=len(Unproven)).tolist()
    assert (counts["boxes"], counts["proven_boxes"]) == (ends.size, np.count_nonzero(ends))
    assert counts["rounds"] == rounds.max() > 1
    assert certificate["lattice"]["columns"] == ends.shape[1] == first_columns(JOB.grid, 1) << (LEVELS - 1)
    assert certificate["lattice"]["rows"] == ends.shape[0]
    for number, share in enumerate(shares):
        assert share == proven[solution == number].sum() / (WHOLE * proven.size)
    assert shares.sum() > 0.5
    (rattling,) = store.read_whole((NEVER_QUIET,))
    assert certificate["never_quiet"] == rattling.sum() / (WHOLE * rattling.size)
    # What ends in a motion that rattles does not fall quiet, and the other way round.
    falls = solution == certificate["quiet"]["motion"]
    assert (rattling[~falls] >= proven[~falls]).all() and (rattling[falls] + proven[falls] <= WHOLE).all()
    never = proof_of(store).read_never_quiet()
    assert not never[ends == 1 + certificate["quiet"]["motion"]].any() and not never[0].any()
    assert (never[1:][ends[1:] > 1] == 1).all()
    assert ends.max() <= len(certificate["motions"])


def test_motions_are_in_the_core_within_as_many_impacts_as_the_certificate_says(store):
    certificate = proof_of(store).certificate
    quiet, (ends, rounds) = certificate["quiet"], proof_of(store).read_lattice(LEVELS, True)
    assert quiet["within"] == 12 + 4 * rounds[ends == 1 + quiet["motion"]].max()
    (proven,), grid = store.read_whole((PROVEN,)), JOB.grid
    falls = (store.read_solution(0) == quiet["motion"]) & (proven == WHOLE)
    t, v = (each[falls] for each in np.meshgrid(grid.time_centres(), grid.velocity_centres()))
    waiting, o = np.ones(t.size, np.bool_), JOB.oscillator
    for _ in range(quiet["within"] + 1):
        turn = 2.0 * np.pi * t
        felt = 4.0 * np.pi * o.damping - 2.0 * np.pi * o.eccentricity * (
            2.0 * np.pi * np.cos(turn) + o.damping * np.sin(turn)
        )
        waiting &= ~(v**3 < quiet["level"] * felt)
        t[waiting], v[waiting], *_ = next_impacts(o, t[waiting], v[waiting])
    assert t.size > 10 and not waiting.any()


def test_a_damaged_store_of_the_first_edition_is_mended_to_one_of_this(store, tmp_path):
    """It had no `never_quiet`: what it lacks is made, and its lattice grows anew."""
    old = tmp_path / "old.zarr"
    shutil.copytree(store.location, old)
    group = open_group(str(old), "r+")
    certificate = dict(group["proof"].attrs["certificate"])
    del group["never_quiet"], group["proof/never_quiet"], certificate["never_quiet"]
    group["proof"].update_attributes({"certificate": certificate})
    consolidate(str(old))
    assert rattle.open(old).share_proven.sum() > 0.5 and "never_quiet" not in rattle.open(old)
    assert rattle.check(old, dry_run=True).complete
    (old / "proven" / "c" / "0" / "0").unlink()
    assert rattle.check(old).complete
    assert content(str(old)) == content(store.location)


def test_what_the_lattice_grew_from_is_gone(store):
    assert list(store._group["proof"].group_keys()) == []
    assert sorted(store._group["proof"].array_keys()) == [
        *_EVER,
        *(_OF_WINDOWS if proof_of(store).certificate["windows"] else ()),
    ]


@pytest.mark.parametrize(
    ("least", "greatest", "parts"),
    [(0.5999999, 0.6000001, 0), pytest.param(0.597, 0.603, 8, marks=pytest.mark.slow)],
)
def test_tolerances_prove_for_every_machine_within(tmp_path, least, greatest, parts):
    """What is proven of all is proven of one of them; wide tolerances are cut in parts."""
    prove = {"levels": 0, "tolerances": {"damping": (least, greatest)}}
    within = run(BasinJob(oscillator=LOSSY, grid=JOB.grid, prove=prove), tmp_path / "within.zarr")
    some = run(BasinJob(oscillator=LOSSY, grid=JOB.grid, prove={"levels": 0}), tmp_path / "one.zarr")
    (proven,), (alone,) = within.read_whole((PROVEN,)), some.read_whole((PROVEN,))
    certificate, (ends, _) = proof_of(within).certificate, proof_of(within).read_lattice(LEVELS, True)
    assert certificate["machine"]["damping"] == [least, greatest]
    assert len(certificate["parts"]) == parts
    assert ends.shape[0] == max(parts, 1) * certificate["lattice"]["rows"]
    assert certificate["counts"]["boxes"] == ends.size
    assert 0.2 * alone.sum() < proven.sum() <= alone.sum()


def test_a_proof_in_parts_that_was_stopped_goes_on_to_the_same_bytes(tmp_path):
    prove = {"levels": 0, "tolerances": {"damping": (0.598, 0.602)}}
    job = BasinJob(oscillator=LOSSY, grid=CellGrid(time_cells=20, velocity_cells=20), prove=prove)
    cancel = threading.Event()

    def stop(progress):
        if progress.stage is PROVING:
            cancel.set()

    with pytest.raises(JobCancelled):
        run(job, tmp_path / "stopped.zarr", report=stop, cancel=cancel)
    whole = run(job, tmp_path / "whole.zarr", threads=2)
    assert content(run(job, tmp_path / "stopped.zarr").location) == content(whole.location)


def test_a_lattice_that_is_proven_whole_is_not_followed_any_more(tmp_path):
    """Here every motion falls quiet."""
    quiet = BasinJob(oscillator=Oscillator(0.6, 0.05, 0.6), grid=CellGrid(time_cells=70, velocity_cells=8), prove=True)
    store = run(quiet, tmp_path / "quiet.zarr")
    ends, _ = proof_of(store).read_lattice(LEVELS, True)
    assert ends.all() and store.complete


def test_a_request_without_a_proof_has_no_trace_of_it(tmp_path):
    plain = run(BasinJob(oscillator=LOSSY, grid=CellGrid(time_cells=8, velocity_cells=8)), tmp_path / "plain.zarr")
    assert not proof_of(plain).wanted and proof_of(plain).certificate is None and "prove" not in plain.job.request()

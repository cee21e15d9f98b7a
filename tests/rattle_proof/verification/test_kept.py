"""A verification goes on where it stopped, with the same answer, and believes nothing but what this code has tried."""

import os
import signal
import subprocess
import sys
from dataclasses import asdict
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

import rattle
from rattle.cli import app
from rattle_proof.verification import kept as kept_module
from rattle_proof.verification.kept import Kept, content_of
from rattle_proof.verification.verdict import contradicted, undecided
from rattle_proof.verification.work import Subject
from worker.stores.opening import open_group

PLACES = np.arange(12).reshape(6, 2)
FAILURES = [contradicted("box (0, 1)", "it ends in P(1,1,0)"), undecided("box (2, 3)")]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where results of a test are kept."""
    monkeypatch.setenv("RATTLE_CACHE", str(tmp_path / "kept"))
    return tmp_path / "kept" / "beside" / "verified"


def kept(folder, content="store", what="cells", places=PLACES):
    return Kept(folder, content, what, places)


def test_batches_and_their_failures_are_kept(folder):
    assert kept(folder).read() == {}
    kept(folder).add(3, [])
    kept(folder).add(1, FAILURES)
    assert kept(folder).read() == {3: [], 1: FAILURES}
    kept(folder).forget()
    assert kept(folder).read() == {}


def test_another_store_part_sample_or_code_has_tried_nothing(folder, monkeypatch):
    kept(folder).add(0, [])
    for other in (kept(folder, content="another"), kept(folder, what="boxes"), kept(folder, places=PLACES[:5])):
        assert other.read() == {}
        kept(folder).file.replace(other.file)  # not even under its name
        assert other.read() == {}
        other.file.replace(kept(folder).file)
    assert kept(folder).read() == {0: []}
    monkeypatch.setattr(kept_module, "_code", lambda: "another version")
    assert kept(folder).read() == {}


def test_the_code_is_every_source_and_what_it_is_run_with(tmp_path, monkeypatch):
    (tmp_path / "targets").mkdir()
    for name in ("kept.py", "targets/quiet.py"):
        (tmp_path / name).write_text("x = 1\n")
    monkeypatch.setattr(kept_module, "__file__", str(tmp_path / "kept.py"))
    first = kept_module._code.__wrapped__()
    assert kept_module._code.__wrapped__() == first
    (tmp_path / "targets/quiet.py").write_text("x = 2\n")
    second = kept_module._code.__wrapped__()
    monkeypatch.setattr(kept_module.flint, "__version__", "0.0")
    assert len({first, second, kept_module._code.__wrapped__()}) == 3


@pytest.mark.parametrize("cut", [1, 20, 40])
def test_a_torn_line_is_passed_over_and_hides_no_other(folder, cut):
    kept(folder).add(0, [])
    kept(folder).add(1, FAILURES)
    with kept(folder).file.open("r+") as file:
        file.truncate(file.seek(0, 2) - cut)
    assert kept(folder).read() == {0: []}
    kept(folder).add(2, [])
    assert kept(folder).read() == {0: [], 2: []}


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", b"[1, []]\n", b"digest [1, []]\n{}\n"])
def test_a_foreign_file_is_passed_over(folder, content):
    folder.mkdir(parents=True)
    kept(folder).file.write_bytes(content)
    assert kept(folder).read() == {}
    kept(folder).add(4, FAILURES)
    assert kept(folder).read() == {4: FAILURES}


def test_a_changed_verdict_is_not_believed(folder):
    kept(folder).add(0, FAILURES)
    text = kept(folder).file.read_text()
    kept(folder).file.write_text(text.replace("[0, ", "[1, "))
    assert kept(folder).read() == {}


def test_where_nothing_can_be_kept_it_is_said(folder):
    folder.parent.mkdir(parents=True)
    folder.write_text("no folder")
    with pytest.warns(UserWarning, match="what is verified is not kept"):
        kept(folder).add(0, [])
    assert kept(folder).read() == {}


@pytest.mark.parametrize("changed", ["certificate", "arrays", "solution", "proven", "never_quiet", "request"])
def test_every_claim_of_a_store_counts(changed):
    def proof(**more):
        values = {"certificate": {"level": 1.0}, "arrays": {"ends": PLACES}, "request": "one"}
        values |= dict.fromkeys(("solution", "proven", "never_quiet"), PLACES)
        values |= more
        return SimpleNamespace(job=SimpleNamespace(request=lambda: values["request"]), **values)

    others = {"certificate": {"level": 2.0}, "arrays": {"ends": PLACES + 1}, "request": "another"}
    assert content_of(proof()) == content_of(proof())
    assert content_of(proof()) != content_of(proof(**{changed: others.get(changed, PLACES[::-1])}))


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    path = tmp_path_factory.mktemp("kept") / "damped.zarr"
    rattle.basin(damping=1.5, cells=20, prove=True, levels=0, store=path, progress=False)
    return str(path)


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    """A store whose lattice takes a quarter of a minute: what is told to stop has not ended by then."""
    path = tmp_path_factory.mktemp("kept") / "large.zarr"
    rattle.basin(damping=1.5, cells=128, prove=True, levels=0, store=path, progress=False)
    return str(path)


@pytest.fixture
def tried(monkeypatch):
    """What is tried by this process. It is quickly done: of each row a third cannot be decided."""
    places = []

    def try_one(subject, what, place):
        places.append((what, place))
        return undecided(f"{what} {place}") if place[1] % 3 == 1 else None

    monkeypatch.setattr(Subject, "try_one", try_one)
    return places


def answer(found):
    """All that is found, but for when."""
    return [asdict(part) | {"earlier": 0} for part in found.parts]


def test_a_verification_that_was_stopped_goes_on_to_the_same_answer(store, folder, tried):
    asked = {"cells": 200, "boxes": 300}
    whole = rattle.verify(store, **asked)
    of = len(tried)
    assert not whole.holds and not any(part.earlier for part in whole.parts)
    rattle.cache.clear()
    tried.clear()

    def stop(what, done, total):
        if what == "cells" and done >= 60:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        rattle.verify(store, **asked, progress=stop)
    done, lines = len(tried), []
    again = rattle.verify(store, **asked, progress=lambda *line: lines.append(line))
    assert 0 < done < of == len(tried) == len(set(tried))
    assert answer(again) == answer(whole)
    assert sum(part.earlier for part in again.parts) == done
    assert lines[0][0].endswith("(resumed)") and ("cells (resumed)", 200, 200) == lines[-1]

    # All of it has been tried now, also for a sample of which only the cells are others.
    tried.clear()
    assert answer(rattle.verify(store, **asked)) == answer(whole) and tried == []
    rattle.verify(store, cells=100, boxes=300)
    assert {what for what, _ in tried} == {"cells"}
    tried.clear()
    assert answer(rattle.verify(store, **asked, anew=True)) == answer(whole) and len(tried) == of


def test_a_store_that_was_changed_is_tried_anew(store, folder, tried):
    rattle.verify(store, cells=10, boxes=10)
    of = len(tried)
    group = open_group(store, "r+")["proof"]
    rounds = group["rounds"][...]
    group["rounds"][...] = np.where(rounds == rounds.max(), rounds + 1, rounds)
    try:
        found = rattle.verify(store, cells=10, boxes=10)
    finally:
        group["rounds"][...] = rounds
    assert len(tried) == 2 * of and not any(part.earlier for part in found.parts)


def test_failures_are_the_first_in_order_whoever_was_faster(store, folder, tried):
    cells = rattle.verify(store, cells=200, boxes=0).parts[-1]
    assert cells.undecided > 40 == len(cells.failures)
    places = [each.place for each in cells.failures]
    kept_file = max(folder.iterdir(), key=lambda file: file.stat().st_mtime_ns)
    lines = kept_file.read_text().split("\n")
    kept_file.write_text("\n".join([*lines[:20], *lines[:30:-1]]))  # some are missing, the others the other way round
    again = rattle.verify(store, cells=200, boxes=0).parts[-1]
    assert 0 < again.earlier < 200 and [each.place for each in again.failures] == places


def test_all_cells_may_be_tried_and_the_command_says_what_was_tried_before(store, folder, tried):
    def verify(*options):
        return CliRunner().invoke(app, ["verify", store, "--processes", "1", "--boxes", "50", *options])

    first, second, third = verify("--cells", "all"), verify("--cells", "all"), verify("--cells", "all", "--anew")
    assert [each.exit_code for each in (first, second, third)] == [1, 1, 1]
    assert "were tried by earlier runs" in second.output and "cells (resumed): 400 of 400" in second.output
    assert "earlier" not in first.output and "earlier" not in third.output
    assert verify("--cells", "some").exit_code == 2


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGKILL])
def test_once_stopped_no_process_is_left_and_the_same_command_goes_on(large, folder, stop):
    # Whoever runs tests in the background of a shell has Ctrl-C ignored, and what they start as well.
    heeding = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    code = f"{heeding}; from rattle.cli import app; app()"
    command = [sys.executable, "-c", code, "verify", large, "--boxes", "all"]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
    ) as running:
        for line in running.stdout:
            if line.startswith("boxes of the lattice"):
                break
        # Ctrl-C reaches all processes of a terminal.
        (os.killpg if stop == signal.SIGINT else os.kill)(running.pid, stop)
        said = running.stdout.read()  # to its end: no process holds it any longer
    if stop == signal.SIGINT:
        assert "the same command goes on" in said and "Traceback" not in said
        assert running.returncode == 1, said
    found = rattle.verify(large, cells=100, boxes=100, processes=1)
    assert found.holds and sum(part.earlier for part in found.parts) >= 64  # those of the core

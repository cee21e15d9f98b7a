"""`make test-all` runs every suite there is, goes on after one that fails, and keeps when each last passed."""

import importlib.util
import json
import re
from importlib.machinery import SourceFileLoader
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
MAKEFILE = (ROOT / "Makefile").read_text()


@pytest.fixture(scope="module")
def test_all():
    loader = SourceFileLoader("test_all", str(ROOT / ".ci" / "test-all"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("test_all", loader))
    loader.exec_module(module)
    return module


@pytest.fixture
def project(tmp_path):
    """A project of three suites, of which the second fails."""
    (tmp_path / "Makefile").write_text("one:\n\ntwo:\n\t@false\n\nthree:\n")
    return tmp_path


def test_every_verb_that_tests_is_a_suite(test_all):
    found = test_all.suites(MAKEFILE)
    running_tests = re.findall(
        r"^([a-z-]+):.*\n(?:\t.*\n)*?\t.*(?:-m pytest tests|-m pytest -m|-m pytest \$)", MAKEFILE, re.M
    )
    assert set(running_tests) <= set(found) and {"check", "dist", "demo", "test-pythons", "test-load"} <= set(found)
    assert "test-all" not in found


def test_a_suite_that_fails_does_not_stop_the_next_and_keeps_when_it_last_passed(test_all, project, capfd):
    (project / "build").mkdir()
    before = {"passed": "2026-01-01T00:00:00+00:00", "commit": "0123456789abcdef", "minutes": 1.0}
    (project / "build" / "suites.json").write_text(json.dumps({"two": before}))
    assert test_all.run(["one", "two", "three"], project) == ["two"]
    kept = json.loads((project / "build" / "suites.json").read_text())
    assert set(kept) == {"one", "two", "three"} and kept["two"] == before
    told = capfd.readouterr().out
    for line in (r"one +passed in", r"two +FAILED in .*; last passed 2026-01-01.* on 0123456789ab$", r"three +passed"):
        assert re.search(f"^{line}", told, re.MULTILINE), told


def test_what_ci_runs_includes_the_golden_stores_and_the_proofs():
    assert "make test-golden" in (ROOT / ".ci" / "run").read_text().splitlines()
    ran = re.search(r"^test-golden:.*\n((?:\t.*\n)+)", MAKEFILE, re.MULTILINE)[1].splitlines()
    assert ran[0].endswith("tests/golden") and (ROOT / "tests" / "golden").is_dir()
    assert "-m 'proof and not slow and not planted'" in ran[1]


def test_faults_planted_in_proofs_are_a_suite_of_their_own():
    """Minutes each: a verb runs them all, and the golden and slow verbs none."""
    told = {"test-planted": "-m planted", "test-slow": "not planted", "test-golden": "not planted"}
    for verb, of_planted in told.items():
        ran = re.search(rf"^{verb}:.*\n((?:\t.*\n)+)", MAKEFILE, re.MULTILINE)[1]
        assert of_planted in ran

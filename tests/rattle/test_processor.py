"""Which registers kernels use: the user's choice, else what is on record, else what is timed."""

import json
import os
import sys

import pytest
from llvmlite import binding

from rattle import processor


@pytest.fixture
def fresh(monkeypatch, tmp_path):
    """A process without Numba, on a processor of the first with AVX-512, with a cache folder of its own."""
    monkeypatch.delitem(sys.modules, "numba")
    for name in ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"):
        # Set first, so that what the test sets is taken back.
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    features = binding.FeatureMap({"fma": True, "avx512f": True})
    monkeypatch.setattr(binding, "get_host_cpu_features", lambda: features)
    return tmp_path / "gear-rattle" / "vectors.json"


def _timed(monkeypatch, halves, whole):
    asked = []

    def seconds(target):
        asked.append(target)
        return whole if target else halves

    monkeypatch.setattr(processor, "_seconds", seconds)
    return asked


def test_whole_registers_are_used_where_they_are_faster_and_timed_once(fresh, monkeypatch):
    asked = _timed(monkeypatch, halves=2.0, whole=1.0)
    processor.use_whole_registers()
    assert os.environ["NUMBA_CPU_FEATURES"].endswith("+fma,-prefer-256-bit")
    assert list(json.loads(fresh.read_text()).values()) == [True]
    monkeypatch.delenv("NUMBA_CPU_FEATURES")
    processor.use_whole_registers()
    assert os.environ["NUMBA_CPU_FEATURES"].endswith("-prefer-256-bit")
    assert len(asked) == 6


def test_a_slow_moment_does_not_decide(fresh, monkeypatch):
    seconds = iter([1.0, 3.0, 2.0, 0.5, 1.0, 3.0])
    monkeypatch.setattr(processor, "_seconds", lambda target: next(seconds))
    processor.use_whole_registers()
    assert list(json.loads(fresh.read_text()).values()) == [True]


def test_later_processors_are_left_to_the_kernels(fresh, monkeypatch):
    later = binding.FeatureMap({"avx512f": True, "avx512vbmi2": True})
    monkeypatch.setattr(binding, "get_host_cpu_features", lambda: later)
    asked = _timed(monkeypatch, halves=2.0, whole=1.0)
    processor.use_whole_registers()
    assert "NUMBA_CPU_FEATURES" not in os.environ and not asked and not fresh.exists()


def test_halves_stay_where_whole_registers_gain_nothing(fresh, monkeypatch):
    _timed(monkeypatch, halves=1.0, whole=1.0)
    processor.use_whole_registers()
    assert "NUMBA_CPU_FEATURES" not in os.environ
    assert list(json.loads(fresh.read_text()).values()) == [False]


@pytest.mark.parametrize("name", ["NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"])
def test_a_users_target_stays(fresh, monkeypatch, name):
    monkeypatch.setenv(name, "")
    asked = _timed(monkeypatch, halves=2.0, whole=1.0)
    processor.use_whole_registers()
    assert os.environ[name] == "" and not asked


def test_nothing_changes_once_numba_is_loaded(fresh, monkeypatch):
    monkeypatch.setitem(sys.modules, "numba", object())
    asked = _timed(monkeypatch, halves=2.0, whole=1.0)
    processor.use_whole_registers()
    assert "NUMBA_CPU_FEATURES" not in os.environ and not asked


def test_a_broken_record_is_made_anew_and_a_folder_that_cannot_be_written_does_no_harm(fresh, monkeypatch):
    fresh.parent.mkdir()
    fresh.write_text("no JSON")
    _timed(monkeypatch, halves=2.0, whole=1.0)
    processor.use_whole_registers()
    assert list(json.loads(fresh.read_text()).values()) == [True]
    fresh.unlink()
    fresh.mkdir()
    monkeypatch.delenv("NUMBA_CPU_FEATURES")
    processor.use_whole_registers()
    assert os.environ["NUMBA_CPU_FEATURES"].endswith("-prefer-256-bit")


def test_the_timed_loop_runs():
    assert 0.0 < processor._seconds({}) < processor._TIMED_WITHIN

"""Kernels prefer whole registers in any program, unless the processor is old or the user has named a target."""

import numba
import numpy as np
import pytest
from llvmlite import binding
from numba.core.compiler import Compiler

from rattle_kernels.lanes.flight import refine_durations
from rattle_kernels.numerics import whole_registers
from rattle_kernels.numerics.whole_registers import compiler

PREFERS = '"prefer-vector-width"="512"'


@pytest.fixture
def later(monkeypatch):
    """A processor from Ice Lake on, whose user has named no target."""
    for name in ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"):
        monkeypatch.delenv(name, raising=False)
    features = binding.FeatureMap({"avx512f": True, "avx512vbmi2": True})
    monkeypatch.setattr(binding, "get_host_cpu_features", lambda: features)


def total(numbers):
    found = 0.0
    for i in range(numbers.size):
        found += numbers[i]
    return found


def test_functions_say_what_they_prefer_and_compute_the_same(later):
    usual, whole = numba.njit(total), numba.njit(pipeline_class=compiler())(total)
    numbers = np.random.default_rng(1).random(1000)
    assert usual(numbers) == whole(numbers)
    assert PREFERS not in usual.inspect_llvm(usual.signatures[0])
    assert PREFERS in whole.inspect_llvm(whole.signatures[0])


def test_older_processors_are_left_alone(later, monkeypatch):
    older = binding.FeatureMap({"avx512f": True})
    monkeypatch.setattr(binding, "get_host_cpu_features", lambda: older)
    assert compiler() is Compiler


@pytest.mark.parametrize("name", ["NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"])
def test_a_users_target_is_left_alone(later, monkeypatch, name):
    monkeypatch.setenv(name, "")
    assert compiler() is Compiler


def test_loops_over_lanes_are_compiled_so():
    assert refine_durations._compiler.pipeline_class is whole_registers.compiler()

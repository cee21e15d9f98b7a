"""Loops over lanes lie in the kernels: apart, the linker may take a slower copy of them (`always_inlined`)."""

import re

import numba
import numpy as np
import pytest

from rattle_kernels import Oscillator
from rattle_kernels.lanes import advance, contact, flight, lane_fields
from rattle_kernels.lanes.advance import fly, stay
from rattle_kernels.lanes.lane_fields import FLIGHT_FIELDS, LANES, lane_buffer
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.model.contact import slow_part

# A kernel that is compiled to be read, and is not kept on disk.
pytestmark = pytest.mark.slow


@numba.njit(error_model="numpy")
def _pass(oscillator, tables, slow):
    lanes, corners = lane_buffer(FLIGHT_FIELDS), np.zeros(LANES, np.int64)
    return fly(lanes, corners, oscillator, tables) + stay(lanes, corners, oscillator, tables, slow)


@pytest.fixture(scope="module")
def called():
    oscillator = Oscillator(stiffness=1000.0)
    _pass(oscillator, lane_tables(oscillator), slow_part(oscillator))
    (machine_code,) = _pass.inspect_llvm().values()
    return re.findall(r"\bcall [^\n@]*@([^\s(]+)\(", machine_code)


def _loops():
    for module in (advance, contact, flight, lane_fields):
        for name, function in vars(module).items():
            if getattr(function, "targetoptions", {}).get("forceinline") and function.__module__ == module.__name__:
                yield f"{len(name)}{name}"  # as a mangled name has it


@pytest.mark.parametrize("loop", sorted(set(_loops())))
def test_no_kernel_calls_a_loop_over_lanes(called, loop):
    assert not [name for name in called if loop in name]


def test_the_calls_that_there_are_have_been_found(called):
    assert "expm1" in called  # of the careful path

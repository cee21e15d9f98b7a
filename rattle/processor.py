"""Vectors as wide as the registers of the first processors with AVX-512, for processes that are this project's own.

From Ice Lake on kernels choose them by themselves (`rattle_kernels.numerics.whole_registers`). Older processors slow
their clock down for whole registers. Both widths are timed on them, once for each kind of processor, and the answer is
kept in the user's cache folder. Results are the same bytes.
"""

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

_TARGET = "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"
_WHOLE = ",-prefer-256-bit"
_AVX512, _SINCE_ICE_LAKE = "avx512f", "avx512vbmi2"
# How much faster whole registers must be, beyond what runs differ by: the fastest of three, taken in turn.
_GAIN = 1.05
_TURNS = 3
_TIMED_WITHIN = 60.0


def use_whole_registers() -> None:
    """Choose the widest vectors that pay, for this process and those that it starts.

    Nothing is changed where the user has named a target, or where Numba is loaded already and may have compiled.
    """
    if "numba" in sys.modules or any(name in os.environ for name in _TARGET):
        return
    import llvmlite.binding as llvm

    there = llvm.get_host_cpu_features()
    if not there.get(_AVX512) or there.get(_SINCE_ICE_LAKE):
        return
    features = there.flatten()
    if _pays(f"{llvm.get_host_cpu_name()} {llvm.llvm_version_info} {features}", features):
        os.environ["NUMBA_CPU_FEATURES"] = features + _WHOLE


def _record() -> Path:
    import platformdirs

    return platformdirs.user_cache_path("gear-rattle") / "vectors.json"


def _pays(processor: str, features: str) -> bool:
    """Whether whole registers are faster on this kind of processor: what is on record, or what is measured now."""
    try:
        known = json.loads(_record().read_text())
    except (OSError, ValueError):
        known = {}
    if processor not in known:
        known[processor] = _measured(features)
        try:
            _record().parent.mkdir(parents=True, exist_ok=True)
            _record().write_text(json.dumps(known))
        except OSError:  # timed again by the next process
            pass
    return bool(known[processor])


def _measured(features: str) -> bool:
    """Whether a loop runs faster in whole registers. False where that cannot be timed."""
    try:
        turns = [
            [_seconds(target) for target in ({}, {"NUMBA_CPU_FEATURES": features + _WHOLE})] for _ in range(_TURNS)
        ]
    except (OSError, subprocess.SubprocessError, ValueError):
        return False
    halves, whole = map(min, zip(*turns, strict=True))
    return halves > _GAIN * whole


def _seconds(target: Mapping[str, str]) -> float:
    command = [sys.executable, "-m", "rattle.vector_speed"]
    timed = subprocess.run(
        command, env={**os.environ, **target}, capture_output=True, text=True, check=True, timeout=_TIMED_WITHIN
    )
    return float(timed.stdout)

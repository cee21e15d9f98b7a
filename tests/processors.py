"""Processes whose kernels are compiled for some kind of processor, whatever the machine's own is."""

import os
import platform
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from llvmlite import binding

from rattle_kernels.numerics.fused_multiply_add import fuses_multiply_add

ROOT = Path(__file__).parents[1]
NATIVE, V2, V3, V4 = "native", "x86-64-v2", "x86-64-v3", "x86-64-v4"
"""The machine's own; without FMA; AVX2 and FMA; AVX-512, whole registers."""
_NEEDED = {V2: ["sse4.2"], V3: ["avx2", "fma", "bmi2"], V4: ["avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"]}
_CHOICES = ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES", "NPY_DISABLE_CPU_FEATURES", "OPENBLAS_CORETYPE")


def reason_against(target):
    """Why this machine cannot run what is compiled for a target; empty where it can."""
    if target == NATIVE:
        return ""
    if platform.machine() not in ("x86_64", "AMD64"):
        return f"{target} is no target for {platform.machine()}"
    if target == V2 and not fuses_multiply_add():
        return "this process has no FMA either"
    features = binding.get_host_cpu_features()
    missing = [name for name in _NEEDED[target] if not features.get(name)]
    return f"this processor cannot run {target}: it has no {', '.join(missing)}" if missing else ""


def environment_for(target):
    """Variables of a process that computes as a processor of a kind does; skips where this machine cannot.

    Numba adds the machine's own features unless ``NUMBA_CPU_FEATURES`` is there, be it empty. NumPy and OpenBLAS look
    at the machine: for AVX2 they are kept from AVX-512, too.
    """
    if reason := reason_against(target):
        pytest.skip(reason)
    variables = {name: value for name, value in os.environ.items() if name not in _CHOICES}
    if target != NATIVE:
        variables |= {"NUMBA_CPU_NAME": target, "NUMBA_CPU_FEATURES": "-prefer-256-bit" if target == V4 else ""}
    if target == V3:
        found = np.show_config(mode="dicts")["SIMD Extensions"]["found"]
        variables["OPENBLAS_CORETYPE"] = "Haswell"
        variables["NPY_DISABLE_CPU_FEATURES"] = " ".join(name for name in found if name != "X86_V3")
    return variables


def run_on(targets, module, folder):
    """Run ``python -m module PLACE`` as on each target, at the same time; the places are folders of their names."""
    running = {}
    for target in targets:
        (folder / target).mkdir(parents=True)
        command = [sys.executable, "-m", module, str(folder / target)]
        running[target] = subprocess.Popen(
            command, cwd=ROOT, env=environment_for(target), stderr=subprocess.PIPE, text=True
        )
    for target, process in running.items():
        _, told = process.communicate()
        assert process.returncode == 0, f"{target}: {told}"

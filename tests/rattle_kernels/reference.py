"""Reference values of both maps in 28 digits or more (see data/PROVENANCE.md), and how they are compared."""

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from rattle_kernels import Oscillator

_DATA = Path(__file__).parent / "data"


def entries(name, *, inside_domain=True):
    """Entries of a table; those beyond the bound of Eq. (8) only where asked for."""
    table = json.loads((_DATA / name).read_text())["entries"]
    return [entry for entry in table if (entry.get("category") != "beyond_crit2") == inside_domain]


def spare_compiling(table):
    """Entries as parameters. Kernels are compiled for each number of harmonics: of one and three in the slow tests."""
    rare = {1, 3}
    marks = {True: [pytest.mark.slow], False: []}
    return [pytest.param(entry, marks=marks[len(entry["harmonics"]) in rare]) for entry in table]


def low_bounces(machine):
    """A path of 1e5 ever lower bounces of the machine: its start, and where it is exactly at every 5000th impact."""
    told = json.loads((_DATA / "low_bounces.json").read_text())
    assert (told["damping"], told["eccentricity"], told["half_backlash"]) == machine[:3]
    return [float.fromhex(told["start"][name]) for name in ("t", "v")], told["checkpoints"]


def oscillator_of(entry):
    """Oscillator of an entry; the impacting model's have no stiffness."""
    return Oscillator(*(float(entry.get(name, "inf")) for name in ("delta", "eps", "beta", "kappa")))


def phase_error(t, printed):
    """Distance of a phase from its printed value, around the circle, without rounding the latter."""
    error = abs(float(Fraction(float(t)) - Fraction(printed)))
    return min(error, abs(1.0 - error))


def speed_error(v, printed):
    """Relative error of a speed, with 1e-3 as the least scale."""
    return abs(float(Fraction(float(v)) - Fraction(printed))) / max(float(printed), 1e-3)


def condition(entry):
    """Largest amplification of an input error by DP, at least 1, for the near-grazing entries; 1 elsewhere."""
    if entry["category"] != "near_graze":
        return 1.0
    return max(1.0, np.abs([float(x) for x in entry["DP"]]).max())

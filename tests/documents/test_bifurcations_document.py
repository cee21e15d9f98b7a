"""The table of docs/theory/bifurcations.md, computed anew."""

import re
from pathlib import Path

import pytest

from rattle_kernels import (
    Oscillator,
    SpecialKind,
    continue_orbit,
    eccentricity_bound_single_contact,
    find_orbits,
)

DOCUMENT = (Path(__file__).parents[2] / "docs" / "theory" / "bifurcations.md").read_text()
ROWS = re.findall(r"^\| ([^|]+?) \| ([\d.]*) ?\| (\d\.\d{13}) \| (\S+) \|$", DOCUMENT, re.MULTILINE)


def orbit_at(damping, name, attracts=True):
    found = find_orbits(Oscillator(damping=damping), longest=4, cells=24)
    return [one.orbit for one in found if one.orbit.name == name and one.orbit.attracts == attracts]


def special(damping, name, kind):
    (orbit,) = orbit_at(damping, name)
    branch = continue_orbit(Oscillator(damping=damping), orbit, "damping", (0.48, 0.62))
    (point,) = (one for one in branch.special_points if one.kind == kind)
    return point.value, point.residual


@pytest.fixture(scope="module")
def computed():
    (saddle,) = orbit_at(0.6, "P(1,1,0)", attracts=False)
    second, first = orbit_at(0.6, "P(1,1,1)", attracts=False)  # by speed
    (label_a,) = orbit_at(0.527, "P(3,3,2)")
    numbers = [
        special(0.575, "P(1,2,0)", SpecialKind.SADDLE_NODE),
        special(0.575, "P(2,2,1)", SpecialKind.PERIOD_DOUBLING),
        special(0.585, "P(4,4,2)", SpecialKind.GRAZING),
    ]
    for orbit in (saddle, first, second, label_a):
        numbers += [(orbit.t[0], orbit.residual), (orbit.v[0], orbit.residual)]
    numbers += [
        special(0.527, "P(3,3,2)", SpecialKind.SADDLE_NODE),
        special(0.527, "P(3,3,2)", SpecialKind.PERIOD_DOUBLING),
        special(0.5, "P(3,3,2)", SpecialKind.PERIOD_DOUBLING),
        (eccentricity_bound_single_contact(Oscillator(0.6)), 0.0),
    ]
    return numbers


@pytest.mark.slow
def test_the_table_has_the_rows_that_are_computed(computed):
    assert len(ROWS) == len(computed) == 15


@pytest.mark.slow
def test_every_number_of_the_table_is_what_is_computed_now(computed):
    for (what, paper, printed, residual), (value, left) in zip(ROWS, computed, strict=True):
        assert float(printed) == pytest.approx(value, abs=1e-12), what
        assert left <= 10 * float(residual), what
        if paper:
            assert abs(float(paper) - value) < 1e-4, what


@pytest.mark.slow
def test_the_documents_python_runs(capsys):
    (code,) = re.findall(r"```python\n(.*?)```", DOCUMENT, re.DOTALL)
    exec(compile(code, "bifurcations.md", "exec"), {})
    assert "saddle-node 0.59971576" in capsys.readouterr().out

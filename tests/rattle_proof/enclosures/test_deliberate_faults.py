"""Each deliberate fault in the proof is caught by a test: an inflation removed, a bound halved, a branch forgotten.

The tests run on a copy of the proof with the fault; without compiling it, but for targets and cells, which take long.
The kernels that it calls are compiled once for all of these.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = [pytest.mark.planted, pytest.mark.timeout(900)]
_ROOT = Path(__file__).parents[3]
_IMAGES, _INTERVALS, _FUNCTIONS = (f"test_{each}.py" for each in ("images", "interval", "enclosed_functions"))
_LOW, _MOVING, _LATTICE, _TARGETS, _CELLS, _TURNS = (
    f"test_{each}.py" for each in ("low_bounces", "moving_sets", "lattice", "targets", "cells", "turning_points")
)
_CONDITIONS = "test_target_conditions.py"
_FAULTS = [
    (_CONDITIONS, "targets.py",
     "- 1.0 / rattling.ends.shape[1] > near_t",
     "> near_t"),
    (_CONDITIONS, "targets.py",
     "- rattling.height > near_v",
     "> near_v"),
    (_CONDITIONS, "targets.py",
     "np.minimum(distance, 1.0 - distance)",
     "distance"),
    (_CONDITIONS, "targets.py",
     "if not (apart_t | apart_v).all():",
     "if not (apart_t | apart_v).any():"),
    (_CONDITIONS, "targets.py",
     "if not (apart_t | apart_v).all():",
     "if not (apart_t & apart_v).all():"),
    (_CONDITIONS, "targets.py",
     "for disc in discs:",
     "for disc in list(discs)[:1]:"),
    (_CONDITIONS, "targets.py",
     "(rattling.first + rows.min()) * rattling.height",
     "(rattling.first + rows.max()) * rattling.height"),
    (_CONDITIONS, "targets.py",
     "> up(level * machine.greatest_acceleration)",
     "> up(0.5 * level * machine.greatest_acceleration)"),
    (_CONDITIONS, "targets.py",
     "if rows.size == 0:\n        return False",
     "if rows.size == 0:\n        return True"),
    (_CONDITIONS, "targets.py",
     "return not any(_visits(each, rattling) for each in others)",
     "return not all(_visits(each, rattling) for each in others)"),
    (_CONDITIONS, "targets.py",
     "return bool(lattice.ends[rows[inside], columns[inside]].any())",
     "return bool(lattice.ends[rows[inside], columns[inside]].all())"),
    (_CONDITIONS, "targets.py",
     "if found is not None and _holds_no_other(machine, found, level, discs.values(), others):",
     "if found is not None:"),
    (_CONDITIONS, "targets.py",
     "high = box_at(lattice, i, j).w.high",
     "high = box_at(lattice, i, j).w.low"),
    (_CONDITIONS, "targets.py",
     "box_at(lattice, 0, j).t)).low",
     "box_at(lattice, 0, j).t)).high"),
    (_INTERVALS, "interval.py",
     "Interval(down(a.low + b.low), ",
     "Interval(a.low + b.low, "),
    (_INTERVALS, "interval.py",
     "up(a.high - b.low))",
     "a.high - b.low)"),
    (_INTERVALS, "interval.py",
     "Interval(down(min(first, second, third, fourth)),",
     "Interval(min(first, second, third, fourth),"),
    (_INTERVALS, "interval.py",
     "_OUTWARDS = 2.0**-51",
     "_OUTWARDS = 2.0**-54"),
    (_INTERVALS, "interval.py",
     "_LEAST = 2.0**-1000",
     "_LEAST = 0.0"),
    (_INTERVALS, "interval.py",
     "a.low <= 0.0 and a.high >= 0.0",
     "a.low < a.high < 0.0"),
    (_FUNCTIONS, "enclosed_functions.py",
     "_ERROR = 2.0**-49",
     "_ERROR = 2.0**-50"),
    (_FUNCTIONS, "enclosed_functions.py",
     "bend = up(0.5 * up(angle * angle))",
     "bend = up(0.25 * up(angle * angle))"),
    (_FUNCTIONS, "enclosed_functions.py",
     "up(up(abs(slope) + _ERROR) * angle)",
     "0.5 * up(up(abs(slope) + _ERROR) * angle)"),
    (_FUNCTIONS, "enclosed_functions.py",
     "for _ in range(halvings):",
     "for _ in range(halvings - 1):"),
    (_IMAGES, "flight.py",
     "velocity, over = _slopes(machine, wide, sought)",
     "velocity, over = _slopes(machine, start, sought)"),
    (_IMAGES, "flight.py",
     "times = add(arrival, within)",
     "times = arrival"),
    (_IMAGES, "flight.py",
     "change = add(add(multiply(over.vt, dt), multiply(over.vv, dw)), drift.w)",
     "change = multiply(over.vv, dw)"),
    (_IMAGES, "flight.py",
     "within = add(_time_spread(over, dt, dw), drift.t)",
     "within = _time_spread(over, dt, dw)"),
    (_IMAGES, "flight.py",
     "multiply(over.vv, dw)), drift.w)",
     "multiply(over.vv, dw)), point(0.0))"),
    (_IMAGES, "flight.py",
     "change = subtract(machine.damping, one.damping)",
     "change = point(0.0)"),
    (_IMAGES, "flight.py",
     "turned = multiply(multiply(TWO_PI, amplitude),",
     "turned = multiply(amplitude,"),
    (_MOVING, "impact.py",
     "less = multiply(subtract(kept, one), arrivals.all.w)",
     "less = point(0.0)"),
    (_MOVING, "impact.py",
     "carried = spread(upper.slope, lower.drift.t, lower.drift.w)",
     "carried = Box(point(0.0), point(0.0))"),
    (_IMAGES, "impact.py",
     "both = Box(hull(over.all.t, below.t), hull(over.all.w, below.w))",
     "both = over.all"),
    (_IMAGES, "impact.py",
     "fastest = up(before * up(most",
     "fastest = up(0.5 * before * up(most"),
    (_IMAGES, "impact.py",
     "turn.height.low > -scale",
     "turn.height.high > -scale"),
    (_IMAGES, "impact.py",
     "kept, one = negative(machine.restitution)",
     "kept, one = point(-machine.restitution.low)"),
    (_IMAGES, "flight.py",
     "lagging = negative(multiply(tau, departure.lag))",
     "lagging = multiply(tau, departure.lag)"),
    (_TURNS, "turning_point.py",
     "return by_t, by_w, negative(lowered), reached",
     "return by_t, by_w, lowered, reached"),
    (_TURNS, "turning_point.py",
     "TurningPoints(height.low <= height.high, ",
     "TurningPoints(True, "),
    (_TURNS, "impact.py",
     "multiply(machine.restitution, Interval(0.0, fastest))",
     "multiply(machine.restitution, Interval(0.5 * fastest, fastest))"),
    (_MOVING, "moving_set.py",
     "turns = max(math.floor(moved.t), 0)",
     "turns = math.floor(moved.t)"),
    (_TARGETS, "targets.py",
     "return not any(_visits(each, rattling) for each in others)",
     "return True"),
    (_IMAGES, "machine.py",
     "Interval(machine.harmonics[n, 1], machine.harmonics[n, 2])",
     "point(machine.harmonics[n, 1])"),
    (_IMAGES, "machine.py",
     "safe_speed=down(math.sqrt(deepest))",
     "safe_speed=down(2.0 * math.sqrt(deepest))"),
    (_LOW, "low_bounces.py",
     "during if k == ORDER else t",
     "t"),
    (_MOVING, "moving_set.py",
     "rest = Box(add(add(rest.t, off_t), mapped.drift.t), add(add(rest.w, off_v), mapped.drift.w))",
     "rest = Box(add(rest.t, mapped.drift.t), add(rest.w, mapped.drift.w))"),
    (_MOVING, "moving_set.py",
     "add(add(rest.t, off_t), mapped.drift.t)",
     "add(rest.t, off_t)"),
    (_MOVING, "moving_set.py",
     "slope = product(mapped.slope, moving.slope)",
     "slope = product(moving.slope, mapped.slope)"),
    (_MOVING, "growth.py",
     "_OUTWARDS = 2.0**-22",
     "_OUTWARDS = 0.0"),
    (_LATTICE, "lattice.py",
     "for i in range(bottom, top + 1):",
     "for i in range(bottom, top):"),
    (_LATTICE, "lattice.py",
     "min((j + 1) / columns, strip.t.high)",
     "j / columns"),
    (_LATTICE, "lattice.py",
     "(each == each[0]).all(axis=0)",
     "(each == each[0]).any(axis=0)"),
    (_CELLS, "growth.py",
     "ends[boxes[k, 0] // ends.shape[1]]",
     "ends[0]"),
    (_TARGETS, "quiet_core.py",
     "multiply(square(v), v)",
     "square(v)"),
    (_TARGETS, "quiet_core.py",
     ".high < before.low, before.low",
     ".low < before.high, before.low"),
    (_TARGETS, "quiet_core.py",
     "falls and bounces.speed.high <= machine.safe_speed",
     "falls"),
    (_TARGETS, "orbit_disc.py",
     "waiting += 2",
     "waiting += 1"),
    (_TARGETS, "orbit_disc.py",
     "root(scale(add(squares, gap), 0.5))",
     "root(scale(add(squares, gap), 0.25))"),
    (_TARGETS, "orbit_disc.py",
     "moving.slope), inverse)) < 1.0",
     "moving.slope), inverse)) < 2.0"),
    (_TARGETS, "targets.py",
     "box_at(lattice, 0, j).t)).low",
     "box_at(lattice, 0, j).t)).high"),
    (_TARGETS, "machine.py",
     "one: Any = point(middle(half))",
     "one: Any = getattr(machine.centre, place.name)"),
    (_TARGETS, "machine.py",
     "Interval(middle(a), a.high)",
     "Interval(middle(a), middle(a))"),
    (_TARGETS, "rattling_set.py",
     "range(span.left, span.right + 1)",
     "range(span.left, span.right)"),
]  # fmt: skip


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    return tmp_path_factory.mktemp("compiled")


@pytest.mark.parametrize(("tests", "file", "right", "wrong"), _FAULTS)
def test_a_fault_is_caught(tmp_path, compiled, tests, file, right, wrong):
    for folder in ("rattle_proof", "tests/rattle_proof/enclosures"):
        shutil.copytree(_ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for each in ("pyproject.toml", "tests/__init__.py", "tests/rattle_proof/__init__.py"):
        shutil.copy(_ROOT / each, tmp_path / each)
    faulty = tmp_path / "rattle_proof" / "enclosures" / file
    text = faulty.read_text()
    assert right in text
    faulty.write_text(text.replace(right, wrong, 1))
    options = ["-q", "-x", "-p", "no:cacheprovider", "--timeout", "800"]
    command = [sys.executable, "-m", "pytest", *options, f"tests/rattle_proof/enclosures/{tests}"]
    plain = "0" if tests in (_TARGETS, _CELLS) else "1"
    environment = {
        **{name: value for name, value in os.environ.items() if name != "PYTEST_ADDOPTS"},
        "NUMBA_DISABLE_JIT": plain,
        "PYTHONPATH": os.pathsep.join([str(tmp_path), str(_ROOT)]),
        "NUMBA_CACHE_DIR": str(compiled),
    }
    ran = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    # 1: tests ran, and some failed. Without the fault they pass: that is their own business.
    assert ran.returncode == 1, ran.stdout[-2000:] + ran.stderr[-2000:]
    assert "Error" in ran.stdout or "assert" in ran.stdout

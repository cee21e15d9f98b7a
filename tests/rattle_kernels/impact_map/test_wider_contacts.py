"""P with contacts under several harmonics and damping, against digits proven in ball arithmetic (`balls`)."""

import json
from collections import Counter

import pytest

from rattle_kernels import Oscillator, Outcome, check_domain
from tests.rattle_kernels.impact_map import balls
from tests.rattle_kernels.impact_map.scalar_map import departure
from tests.rattle_kernels.reference import phase_error, spare_compiling, speed_error

_ENTRIES = json.loads(balls.TABLE.read_text())["entries"]
_PARAMETERS = ("damping", "eccentricity", "half_backlash", "stiffness", "contact_damping")
_RESULTS = ("outcome", "duration", "t_next", "v_next", "lower_impacts")


def _case(entry):
    harmonics = tuple(map(tuple, entry["harmonics"]))
    oscillator = Oscillator(**{name: entry[name] for name in _PARAMETERS}, harmonics=harmonics)
    return oscillator, float.fromhex(entry["t"]), float.fromhex(entry["v"])


def test_the_table_has_every_number_of_harmonics_ending_in_every_way():
    ways = Counter((len(entry["harmonics"]), entry["outcome"], entry.get("lower_impacts")) for entry in _ENTRIES)
    endings = [("permanent contact", None), ("returned", 0), ("returned", 1)]
    assert min(ways[harmonics, *ending] for harmonics in range(4) for ending in endings) >= 5
    assert {entry["contact_damping"] for entry in _ENTRIES} == {0.0, 0.01, 0.05, 0.3, 0.7}


@pytest.mark.parametrize(
    "entry", spare_compiling(_ENTRIES), ids=lambda entry: f"{len(entry['harmonics'])}-{entry['contact_damping']}"
)
def test_next_departure_agrees_with_the_reference(entry):
    oscillator, t, v = _case(entry)
    impact = departure(check_domain(oscillator), t, v)
    if entry["outcome"] == "permanent contact":
        assert impact.outcome == Outcome.PERMANENT_CONTACT
        return
    assert impact.outcome == Outcome.RETURNED and impact.lower_impacts == entry["lower_impacts"]
    assert phase_error(impact.t, entry["t_next"]) <= 1e-12
    assert impact.duration == pytest.approx(float(entry["duration"]), rel=1e-12)
    assert speed_error(impact.v, entry["v_next"]) <= 1e-12


@pytest.mark.parametrize("entry", _ENTRIES[::8], ids=lambda entry: f"{len(entry['harmonics'])}-{entry['outcome']}")
def test_the_table_is_what_ball_arithmetic_gives(entry):
    assert balls.results(*_case(entry)) == {name: entry[name] for name in _RESULTS if name in entry}

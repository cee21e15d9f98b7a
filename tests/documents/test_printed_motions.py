"""The motions and exponents that docs/paper/figures.md prints, found again from a thousand other departures."""

import re
from pathlib import Path

import pytest

import rattle

pytestmark = [pytest.mark.slow, pytest.mark.timeout(900)]

DOCUMENT = " ".join((Path(__file__).parents[2] / "docs" / "paper" / "figures.md").read_text().split())
PAPER = {"damping": 0.6, "eccentricity": 0.1, "half_backlash": 0.6}
# An error is the standard deviation of a mean: with this many, one test in ten thousand fails by chance.
ERRORS = 4


@pytest.fixture
def motions(tmp_path):
    """Tables of the rattling motions at some values of a parameter, by value."""

    def found(parameter, values):
        store = tmp_path / f"{parameter}-{values[0]:g}.zarr"
        sweep = rattle.sweep(**PAPER | {parameter: values}, sample=1000, store=store, progress=False)
        table = sweep.rattle.to_table()
        table = table[~table["name"].isin(["permanent contact", "P(1,1,0)", "P(1,2,0)"])]
        return {value: table[table[parameter] == value].set_index("name") for value in values}

    return found


def printed(pattern):
    """What groups of a pattern match in the page; white space in it stands for any."""
    match = re.search(pattern, DOCUMENT)
    assert match is not None, f"the page no longer says {pattern}"
    return match.groups()


def numbers(text):
    """Numbers in a list of words and commas."""
    return [float(number) for number in re.findall(r"\d[\d.e]*\d|\d", text)]


def assert_chaos_within(table, low, high):
    (chaos,) = table.itertuples()
    assert chaos.Index == "chaotic"
    slack = ERRORS * chaos.lyapunov_error
    # Printed with two digits.
    assert low - 0.005 - slack <= chaos.lyapunov_exponent <= high + 0.005 + slack


def test_chaos_and_windows_of_high_stiffness(motions):
    values, low, high = printed(
        r"At (6\.8e5[^a-z]*(?:e\d[^a-z]*)*and 1e7) the catalogue holds chaos, with exponents of (\S+) to (\S+)\."
    )
    for table in motions("stiffness", numbers(values)).values():
        assert_chaos_within(table, float(low), float(high))
    first, first_orbits, second, second_orbits = printed(r"At (1\.01e6) it holds (.*?), at (1\.5e6) (.*?), from")
    windows = motions("stiffness", [float(first), float(second)])
    for value, orbits in ((first, first_orbits), (second, second_orbits)):
        assert sorted(windows[float(value)].index) == sorted(orbits.split(" and "))


def test_chaos_above_the_graze_and_transients_below_it(motions):
    values, low, high = printed(
        r"At (0\.5923[^a-z]*and 0\.5975) the catalogue holds chaos, with exponents of (\S+) to (\S+)\."
    )
    for table in motions("damping", numbers(values)).values():
        assert_chaos_within(table, float(low), float(high))
    below, alone = printed(
        r"Below the graze, at (.*?), that chaos is a transient.*?; at (.*?) there is P\(4,4,2\) alone"
    )
    for table in motions("damping", numbers(below)).values():
        assert sorted(table.index) == ["P(4,4,2)", "chaotic transient"]
    for table in motions("damping", numbers(alone)).values():
        assert list(table.index) == ["P(4,4,2)"]


def test_exponents_of_the_tables(motions):
    stiff = motions("stiffness", [1e3, 1e4, 1e5])
    for kappa, orbit in (("1e3", "P(3,3,2)"), ("1e4", "P(6,6,4)"), ("1e5", "P(2,2,1)")):
        (exponent,) = printed(rf"\| {kappa} \|[^\n]*?{re.escape(orbit)} [\d.]+ \| (-[\d.]+) \|")
        assert stiff[float(kappa)].lyapunov_exponent[orbit] == pytest.approx(float(exponent), abs=0.0006)
    chaos, error = printed(r"exponent (\S+) \+- (\S+) per rotation")
    basins = motions("damping", [0.527, 0.6])
    found = basins[0.6].loc["chaotic"]
    assert abs(found.lyapunov_exponent - float(chaos)) < ERRORS * (found.lyapunov_error**2 + float(error) ** 2) ** 0.5
    of_orbit, of_chaos, error = printed(r"exponent (-[\d.]+), as a multiplier .*?exponent (\S+) \+- (\S+), v from")
    found = basins[0.527]
    assert found.lyapunov_exponent["P(3,3,2)"] == pytest.approx(float(of_orbit), abs=6e-5)
    transient = found.loc["chaotic transient"]
    slack = ERRORS * (transient.lyapunov_error**2 + float(error) ** 2) ** 0.5
    assert abs(transient.lyapunov_exponent - float(of_chaos)) < slack


def test_the_window_at_a_stiffness_of_a_million(tmp_path):
    node, doubling = printed(r"P\(8,8,5\) is born in a saddle-node at (\S+) .*? and doubles its period at (\S+) ")
    oscillator = PAPER | {"stiffness": 1e6}
    seed = (0.7192846538523887, 4.371361270666657, 8)
    store = tmp_path / "orbits.zarr"
    orbits = rattle.orbits(
        **oscillator, seeds=[seed], continuation={"stiffness": (9.9e5, 1.01e6)}, store=store, progress=False
    )
    assert list(orbits.rattle.to_table("orbit")["name"]) == ["P(8,8,5)"]
    special = orbits.rattle.to_table("special").set_index("special_kind").special_value
    assert f"{special['saddle-node'] / 1e5:.3f}e5" == node
    assert f"{special['period_doubling'] / 1e6:.5f}e6" == doubling

"""Motions of a diagram are named at each value, as the catalogue of attractors there names them."""

import numpy as np
import pytest

import rattle
from rattle_kernels import Oscillator, find_attractors
from worker.results import motion_names
from worker.results.motion_names import NO_PERIOD, itinerary
from worker.results.tables import table_of


@pytest.fixture(scope="module")
def diagram(tmp_path_factory):
    store = tmp_path_factory.mktemp("diagram") / "diagram.zarr"
    values = {"damping": [0.575, 0.582, 0.59, 0.6]}
    return rattle.bifurcation(
        **values, seeds=[(0.553, 4.703)], transient=4000, kept=24, store=store, progress=False, eccentricity=0.1,
        half_backlash=0.6,
    )  # fmt: skip


def test_a_branch_has_at_each_value_the_name_of_what_is_there(diagram):
    table = table_of(diagram, "impact_period")
    names = dict(zip(table["damping"], table["name"], strict=True))
    for (value, name), last in zip(names.items(), diagram.isel(seed=0, kept=-1).velocity.values, strict=True):
        t = float(diagram.isel(seed=0, kept=-1).sel(visit=list(names).index(value)).time)
        (_, *found) = find_attractors(Oscillator(value, 0.1, 0.6), np.array([t]), np.array([last]))
        expected = found[0].name if found[0].upper_contacts and found[0].upper_contacts <= 12 else NO_PERIOD
        assert name == expected, value
    assert names[0.582] == "P(4,4,2)" and names[0.6] == NO_PERIOD


def test_a_name_counts_periods_and_contacts_of_both_walls():
    """The P(2,2,1) of delta = 0.55, by the catalogue."""
    found = {each.name: each for each in find_attractors(Oscillator(0.55, 0.1, 0.6), [0.55, 0.9], [4.7, 3.7])}
    for name, motion in found.items():
        if name.startswith("P("):
            t, v = float(motion.time[0]), float(motion.velocity[0])
            assert itinerary(Oscillator(0.55, 0.1, 0.6), t, v, motion.upper_contacts) == name
    assert any(name.startswith("P(") for name in found)


def test_a_motion_that_rests_has_the_name_of_the_catalogue():
    """Gears that rest on +beta once a turn; their histories list the bounces before."""
    loose = {"damping": 0.6, "half_backlash": 0.6, "restitution": 0.7}
    values = {"eccentricity": [0.2, 0.22, 0.24]}
    table = rattle.bifurcation(**values, seeds=[(0.5, 2.0)], transient=500, kept=24, progress=False, **loose)
    names = table.rattle.to_table("impact_period")["name"].tolist()
    for value, name in zip(values["eccentricity"], names, strict=True):
        (_, *found) = find_attractors(Oscillator(eccentricity=value, **loose), [0.5], [2.0])
        assert [name] == [each.name for each in found]
    assert names[1] == "P(1,1,0)*"


def test_motions_are_followed_once_whatever_reads_their_names(diagram, monkeypatch):
    followed = []
    follow = motion_names.time_history

    def counting(*arguments, **options):
        followed.append(arguments)
        return follow(*arguments, **options)

    monkeypatch.setattr(motion_names, "time_history", counting)
    itinerary.cache_clear()
    tables = [table_of(diagram, "impact_period") for _ in range(2)]
    assert tables[0]["name"].tolist() == tables[1]["name"].tolist()
    assert len(followed) == sum(name.startswith("P(") for name in tables[0]["name"]) > 0
    # One diagram of as many motions as are named at all finds room.
    assert itinerary.cache_info().maxsize >= motion_names.MOST_NAMED

"""Every column of the tables of orbits, branches, special points and curves, against the objects it comes from."""

from types import SimpleNamespace

import numpy as np
import pytest

from rattle_kernels import Oscillator, SpecialKind, graze_kind
from tests.rattle_kernels.orbits.grazes import BETWEEN, graze_of_single_contact
from worker.analyses.curves import PIECES
from worker.analyses.orbit_tables import CURVES, ORBITS, SPECIALS, branch_table, summarise_specials

NAN = np.nan


def numbers(seed, *shape):
    """Numbers that no other column has."""
    return np.random.default_rng(seed).random(shape)


def special(seed, contacts):
    return SimpleNamespace(
        kind=list(SpecialKind)[seed], value=1.0 + seed, oscillator=Oscillator(), error=2.0 + seed, residual=3.0 + seed,
        forcing_periods=10 + seed, upper_contacts=contacts, lower_contacts=30 + seed,
        t=numbers(40 + seed, contacts), v=numbers(50 + seed, contacts),
        multipliers=numbers(60 + seed, 2) + 1j * numbers(70 + seed, 2),
    )  # fmt: skip


def padded(*rows):
    length = max(len(row) for row in rows)
    return np.array([np.pad(row, [(0, length - len(row))] + [(0, 0)] * (row.ndim - 1), constant_values=NAN)
                     for row in rows])  # fmt: skip


def demand(table, objects, expected, filled_elsewhere=(), without=()):
    """The columns of the objects are those that are expected, and those that say nothing of them; no others."""
    found = table.of(objects)
    assert set(found) == {*expected, *without}
    assert all(value == "" or np.isnan(value) for name in without for value in found[name].ravel())
    assert {column.name for column in table.columns} - set(found) == set(filled_elsewhere)
    for name, values in expected.items():
        np.testing.assert_array_equal(found[name], np.asarray(values, found[name].dtype), err_msg=name)
    # No two columns of numbers are alike: each was held against its own.
    flat = [tuple(np.ravel(found[name]).tolist()) for name in expected]
    assert len({repr(each) for each in flat}) == len(flat)
    return found


def test_special_points():
    one, two = special(0, 2), special(1, 3)
    demand(
        SPECIALS,
        [one, two],
        {
            "special_kind": [1, 2],
            "special_value": [1.0, 2.0],
            "special_error": [2.0, 3.0],
            "special_residual": [3.0, 4.0],
            "special_forcing_periods": [10, 11],
            "special_upper_contacts": [2, 3],
            "special_lower_contacts": [30, 31],
            "special_time": padded(one.t, two.t),
            "special_velocity": padded(one.v, two.v),
            "special_multiplier_real": [one.multipliers.real, two.multipliers.real],
            "special_multiplier_imaginary": [one.multipliers.imag, two.multipliers.imag],
        },
        filled_elsewhere=["special_branch"],
        without=["special_turn", "special_beyond", "special_beyond_value"],
    )


def test_a_graze_has_its_turn_and_the_orbit_beside_it():
    point = graze_of_single_contact(BETWEEN)
    found, kind = SPECIALS.of([point]), graze_kind(point)
    assert found["special_turn"].tolist() == [kind.monodromy.tolist()]
    assert found["special_beyond"].tolist() == ["P(1,1,1)"]
    ((beyond,),) = (found["special_beyond_value"],)
    assert (beyond > point.value) == (kind.hits > 0)
    (told,) = summarise_specials(found | {"special_branch": np.array([0])}, "damping")
    assert told.graze.scenario == kind.scenario and told.graze.response == kind.response
    assert told.graze.small_attractor_follows and "a small attractor takes its place at once" in told.graze.says


def test_curves_of_special_points():
    one, two = (
        SimpleNamespace(
            values=numbers(seed, size, 2), t=numbers(seed + 1, size), v=numbers(seed + 2, size),
            residual=numbers(seed + 3, size), ends=(f"begins {seed}", f"stops {seed}"),
        )
        for seed, size in ((10, 2), (20, 4))
    )  # fmt: skip
    demand(
        CURVES,
        [one, two],
        {
            "curve_size": [2, 4],
            "curve_end": [["begins 10", "stops 10"], ["begins 20", "stops 20"]],
            "curve_first": [*one.values[:, 0], *two.values[:, 0]],
            "curve_second": [*one.values[:, 1], *two.values[:, 1]],
            "curve_time": [*one.t, *two.t],
            "curve_velocity": [*one.v, *two.v],
            "curve_residual": [*one.residual, *two.residual],
        },
        filled_elsewhere=["curve_special"],
    )


def branch(seed, points, contacts):
    ends = [
        SimpleNamespace(reason=SimpleNamespace(name=f"{side}{seed}"), message=f"at the {side} {seed}", value=seed + n)
        for n, side in enumerate(("FIRST", "LAST"))
    ]
    return SimpleNamespace(
        values=numbers(seed, points), forcing_periods=100 + seed, upper_contacts=contacts,
        t=numbers(seed + 1, points, contacts), v=numbers(seed + 2, points, contacts),
        grazing_margin=numbers(seed + 3, points, contacts), lower_speed=numbers(seed + 4, points, contacts),
        trace=numbers(seed + 5, points), area=numbers(seed + 6, points),
        attracts=np.arange(points) % 2 == seed % 2, ends=ends,
    )  # fmt: skip


def test_branches():
    one, two = branch(10, 2, 3), branch(21, 4, 1)

    def joined(name):
        first, second = getattr(one, name), getattr(two, name)
        return [*first, *np.pad(second, ((0, 0), (0, 2)), constant_values=NAN)]

    demand(
        branch_table("damping"),
        [one, two],
        {
            "damping": [*one.values, *two.values],
            "branch_forcing_periods": [110, 121],
            "branch_upper_contacts": [3, 1],
            "branch_size": [2, 4],
            "branch_end_reason": [["first10", "last10"], ["first21", "last21"]],
            "branch_end_message": [["at the FIRST 10", "at the LAST 10"], ["at the FIRST 21", "at the LAST 21"]],
            "branch_end_value": [[10.0, 11.0], [21.0, 22.0]],
            "branch_time": joined("t"),
            "branch_velocity": joined("v"),
            "branch_grazing_margin": joined("grazing_margin"),
            "branch_lower_speed": joined("lower_speed"),
            "branch_trace": [*one.trace, *two.trace],
            "branch_area": [*one.area, *two.area],
            "branch_attracts": [1, 0, 0, 1, 0, 1],
        },
        filled_elsewhere=["orbit_branch", "branch_orbit"],
    )


def orbit(seed, contacts, attracts):
    return SimpleNamespace(
        orbit=SimpleNamespace(
            name=f"P({seed})", forcing_periods=seed + 1, upper_contacts=contacts, lower_contacts=seed + 2,
            attracts=attracts, multipliers=numbers(seed, 2) + 1j * numbers(seed + 1, 2), lyapunov_exponent=seed + 0.25,
            residual=seed + 0.5, t=numbers(seed + 2, contacts), v=numbers(seed + 3, contacts),
            jacobians=numbers(seed + 4, contacts, 2, 2),
        ),
        grazing_distance=seed + 0.75, grazing_margin=numbers(seed + 5, contacts),
        lower_speed=numbers(seed + 6, contacts),
    )  # fmt: skip


def test_orbits():
    one, two = orbit(10, 2, True), orbit(30, 3, False)
    demand(
        ORBITS,
        [one, two],
        {
            "name": ["P(10)", "P(30)"],
            "forcing_periods": [11, 31],
            "upper_contacts": [2, 3],
            "lower_contacts": [12, 32],
            "attracts": [1, 0],
            "multiplier_real": [one.orbit.multipliers.real, two.orbit.multipliers.real],
            "multiplier_imaginary": [one.orbit.multipliers.imag, two.orbit.multipliers.imag],
            "lyapunov_exponent": [10.25, 30.25],
            "residual": [10.5, 30.5],
            "grazing_distance": [10.75, 30.75],
            "orbit_time": padded(one.orbit.t, two.orbit.t),
            "orbit_velocity": padded(one.orbit.v, two.orbit.v),
            "grazing_margin": padded(one.grazing_margin, two.grazing_margin),
            "lower_speed": padded(one.lower_speed, two.lower_speed),
            "jacobian": padded(one.orbit.jacobians, two.orbit.jacobians),
        },
    )


def test_pieces_of_curves():
    one, two = (SimpleNamespace(t=numbers(seed, size), v=numbers(seed + 1, size)) for seed, size in ((1, 2), (5, 3)))
    columns = {"piece_size": [2, 3], "time": [*one.t, *two.t], "velocity": [*one.v, *two.v]}
    demand(PIECES, [one, two], columns, filled_elsewhere=["piece_end"])


@pytest.mark.parametrize("table", [SPECIALS, CURVES, branch_table("damping"), ORBITS, PIECES])
def test_no_two_columns_of_a_table_mean_the_same(table):
    meanings = [column.meaning for column in table.columns]
    assert len(set(meanings)) == len(meanings)

"""What the shell prints of a result: every row and number that it holds, and how many more there are."""

import json

import pytest

from rattle.cli.result_tables import print_result, what_is_missing

ORBIT = {
    "name": "P(1,1,0)", "attracts": False, "multipliers": [[3.25, 0.0], [0.125, 0.0]], "grazing_distance": 0.5,
    "residual": 2e-15, "departures": [{"time": 0.6017, "velocity": 3.77}, {"time": 0.2, "velocity": 4.5}],
}  # fmt: skip
TURNING = ORBIT | {"name": "P(2,2,1)", "multipliers": [[0.5, 0.25], [0.5, -0.25]]}


def printed(capsys, kind, **result):
    print_result(kind, result | {"seconds": None})
    return [" ".join(line.replace("│", " ").split()) for line in capsys.readouterr().out.splitlines()]


def rows(lines, first):
    return [line for line in lines if line.startswith(first)]


def test_orders_of_a_grazing_curve(capsys):
    orders = [
        {"order": 0, "pieces": 1, "vertices": 513, "arclength": 1.25, "complete": True},
        {"order": 1, "pieces": 7, "vertices": 999, "arclength": 20.5, "complete": False},
    ]
    lines = printed(capsys, "grazing_curve", orders=orders)
    assert rows(lines, "0 ") == ["0 1 513 1.2500"]
    assert rows(lines, "1 ") == ["1 7 999 20.5000 incomplete: it needs more points than allowed"]
    assert "order 1 is incomplete" in what_is_missing("grazing_curve", {"orders": orders})
    assert what_is_missing("grazing_curve", {"orders": orders[:1]}) is None


GRAZING = {"kind": "grazing", "graze": {"scenario": "folds"}, "residual": 5e-14}


def test_orbits_their_branches_special_points_and_curves(capsys):
    point = {"kind": "saddle-node", "value": 0.57512345678, "orbit": "P(1,1,0)", "branch": 1, "error": 3e-12}
    branch = {"orbit": 1, "points": 77, "ends": [{"message": "it folds"}, {"message": "it grazes"}]}
    lines = printed(
        capsys, "orbits", orbits=[ORBIT, TURNING | {"attracts": True}, TURNING], branches=[branch],
        special_points=[point | {"residual": 4e-14, "graze": None}, point | GRAZING],
        curves=[{"special_point": 5, "points": 66, "ends": ["a", "b"]}],
    )  # fmt: skip
    assert "0 P(1,1,0) 0.6017000000 3.7700000000 3.25 0.5 2e-15" in lines and "saddle 0.125" in lines
    assert "1 P(2,2,1) 0.6017000000 3.7700000000 0.5+0.25i 0.5 2e-15" in lines
    assert "attracts 0.5-0.25i" in lines and "unstable 0.5-0.25i" in lines
    assert "branch 0 of P(2,2,1), 77 points: it folds; it grazes" in lines
    assert "0 saddle-node 0.57512345678 P(1,1,0) 1 3e-12 4e-14" in lines
    assert "1 grazing, folds 0.57512345678 P(1,1,0) 1 3e-12 5e-14" in lines
    assert "curve of special point 5, 66 points: a; b" in lines


def test_branches_of_manifolds(capsys):
    branch = {
        "saddle": 1, "departure": 2, "side": 1, "arclength": 3.5, "pieces": 4, "vertices": 55, "manifold": "stable",
        "end": "it is as long as asked",
    }  # fmt: skip
    other = branch | {"saddle": 0, "side": -1, "manifold": "unstable"}
    lines = printed(capsys, "manifold", saddles=[ORBIT, TURNING], branches=[branch, other])
    told = "arclength 3.5000, 4 pieces, 55 vertices; it is as long as asked"
    assert f"stable branch of 1: P(2,2,1), departure 2, later phases: {told}" in lines
    assert f"unstable branch of 0: P(1,1,0), departure 2, earlier phases: {told}" in lines


@pytest.mark.parametrize("total", [40, 41, 47])
def test_long_tables_say_how_many_more_there_are(capsys, total):
    runs = [{"way": "up", "start": 0.5 + i, "stop": 0.75 + i, "what": "P(1,1,0)"} for i in range(total)]
    motions = [{"name": "given", "stretches": runs, "stretches_total": total}]
    lines = printed(capsys, "bifurcation", parameter="damping", motions=motions)
    assert len(rows(lines, "0: given up")) == 40 and "0: given up 1.5 1.75 P(1,1,0)" in lines
    assert any("along damping" in line for line in lines)
    assert [line for line in lines if "more" in line] == (
        [f"and {total - 40} more, in the store"] if total > 40 else []
    )
    lines = printed(capsys, "orbits", orbits=[ORBIT] * total, branches=[], special_points=[], curves=[])
    assert sum("P(1,1,0)" in line for line in lines) == 40
    assert [line for line in lines if "more" in line] == (
        [f"and {total - 40} more, in the store"] if total > 40 else []
    )


def test_json_is_the_result_unchanged(capsys):
    print_result("orbits", {"orbits": [ORBIT], "seconds": 3.0}, as_json=True)
    assert json.loads(capsys.readouterr().out) == {"orbits": [ORBIT], "seconds": 3.0}

"""The lines and marks of a picture are the numbers of its columns, each with its colour, style and name."""

from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure

from rattle_kernels import BranchEnd, FirstCurve, Oscillator, SpecialKind, grazing_velocity, time_history
from worker.analyses import bifurcation
from worker.analyses.bifurcation import draw_diagram
from worker.analyses.grazing_curves import draw_grazing_curves
from worker.analyses.manifolds import draw_manifolds
from worker.analyses.orbits import draw_orbits
from worker.jobs.bifurcation_job import Direction
from worker.pictures.history import draw_history_panel, history_figure
from worker.stores.layout import MISSING

NAN = np.nan


def lines(axes, **looks):
    """Points and names of the lines that look so, without gaps."""
    found = []
    for line in axes.lines:
        seen = {
            "marker": line.get_marker(), "style": line.get_linestyle(), "width": line.get_linewidth(),
            "alpha": line.get_alpha(), "colour": to_rgba(line.get_color()),
        }  # fmt: skip
        if all(seen[look] == (to_rgba(value) if look == "colour" else value) for look, value in looks.items()):
            points = np.column_stack([line.get_xdata(), line.get_ydata()]).astype(float)
            found.append((line.get_label(), points[~np.isnan(points).any(axis=1)].tolist()))
    return found


def drawn(draw, job, columns):
    figure = Figure()
    draw(job, columns, figure)
    return figure


def diagram(columns, direction=Direction.BOTH):
    job = SimpleNamespace(vary=SimpleNamespace(parameter="damping"), oscillator=Oscillator(), direction=direction)
    return drawn(draw_diagram, job, columns).axes[0]


DIAGRAM = {
    "damping": np.array([0.5, 0.6, 0.7, 0.7, 0.6, 0.5]), "way": np.array([1, 1, 1, -1, -1, -1]),
    # By visit, seed and departure kept.
    "velocity": np.arange(24.0).reshape(6, 2, 2) / 8.0, "outcome": np.zeros((6, 2), np.int8),
    "seed_time": np.array([0.1, 0.2]), "seed_velocity": np.array([3.25, 4.5]), "seed_name": np.array(["one", "two"]),
}  # fmt: skip


def test_a_diagram_says_what_is_missing_and_which_ways_were_gone(monkeypatch):
    monkeypatch.setattr(bifurcation, "names_of", lambda job, columns: np.full(columns["outcome"].shape, "P(1,1,0)"))
    axes = diagram(DIAGRAM)
    assert axes.get_xlim() == (0.5, 0.7) and axes.get_xlabel().startswith("damping")
    assert axes.get_title().endswith("; upwards, then downwards") and "incomplete" not in axes.get_title()
    up = {name: values[:3] if len(values) == 6 else values for name, values in DIAGRAM.items()}
    up["outcome"] = up["outcome"].copy()
    up["outcome"][2, 1] = MISSING
    assert diagram(up, Direction.UP).get_title().endswith("; incomplete; upwards")


def orbits_job(**fields):
    along = {name: SimpleNamespace(parameter=parameter) for name, parameter in fields.items()}
    return SimpleNamespace(oscillator=Oscillator(), **({"continuation": None, "curves": None} | along))


ORBITS = {
    "name": np.array(["P(1,1,0)", "P(2,2,1)"]), "attracts": np.array([1, 0]),
    "orbit_time": np.array([[0.25, NAN], [0.125, 0.75]]), "orbit_velocity": np.array([[3.5, NAN], [2.0, 4.0]]),
}  # fmt: skip
BRANCHES = {
    "damping": np.array([0.5, 0.55, 0.6, 0.4, 0.45]), "branch_size": np.array([3, 2]),
    "branch_velocity": np.array([[3.0, NAN], [3.25, NAN], [3.5, NAN], [1.0, 5.0], [1.5, 5.5]]),
    "branch_attracts": np.array([0, 1, 1, 0, 0]), "branch_orbit": np.array([1, 0]),
    "branch_end_reason": np.array([[BranchEnd.BOUND.name.lower()] * 2] * 2),
    # Values between those of branches; each kind has a mark of its own.
    "special_kind": np.array([2, 1, 3, 4, 5, 6]), "special_value": np.array([0.51, 0.52, 0.53, 0.54, 0.56, 0.57]),
    "special_velocity": np.array([[3.1, NAN], [3.2, 4.2], [3.3, NAN], [3.4, NAN], [3.6, NAN], [3.7, NAN]]),
    # A turn only where one grazes: N_12 and det(I - N) are positive.
    "special_turn": np.array([[[0.5, 0.25], [0.0, 0.5]] if row == 2 else [[NAN, NAN]] * 2 for row in range(6)]),
}  # fmt: skip
CURVES = {
    "curve_special": np.array([1, 0]), "curve_size": np.array([2, 3]),
    "curve_first": np.array([0.1, 0.2, 0.3, 0.4, 0.5]), "curve_second": np.array([1.1, 1.2, 1.3, 1.4, 1.5]),
}  # fmt: skip


def test_orbits_are_marked_at_their_departures_by_what_they_are():
    axes = drawn(draw_orbits, orbits_job(), ORBITS).axes[0]
    assert lines(axes, marker="x") == [("P(1,1,0) attracts", [[0.25, 3.5]])]
    assert lines(axes, marker="+") == [("P(2,2,1) unstable", [[0.125, 2.0], [0.75, 4.0]])]
    ((_, curve),) = lines(axes, colour="gray")
    t, v = np.array(curve).T
    assert v == pytest.approx(grazing_velocity(Oscillator(), t)) and (t[0], t[-1]) == (0.0, 1.0)


def test_branches_are_thick_where_they_attract_and_special_points_have_the_mark_of_their_kind():
    axes = drawn(draw_orbits, orbits_job(continuation="damping"), ORBITS | BRANCHES).axes[0]
    thick = [points for _, points in lines(axes, width=2.0)]
    assert [[0.55, 3.25], [0.6, 3.5]] in thick and sum(map(len, thick)) == 2
    thin = [points for _, points in lines(axes, width=0.6)]
    assert [[0.5, 3.0], [0.55, 3.25], [0.6, 3.5]] in thin
    assert [[0.4, 1.0], [0.45, 1.5]] in thin and [[0.4, 5.0], [0.45, 5.5]] in thin
    # A branch bears the name of the orbit that it was followed from.
    assert [(label, line) for label, line in lines(axes, colour="C0") if "branch" in label] == [
        ("branch of P(2,2,1)", [])
    ]
    marked = {"o": (SpecialKind.SADDLE_NODE, [[0.52, 3.2], [0.52, 4.2]])}
    marked["s"] = (SpecialKind.PERIOD_DOUBLING, [[0.51, 3.1]])
    marked["^"] = (SpecialKind.GRAZING, [[0.53, 3.3]])
    marked["v"] = (SpecialKind.CONTACT_LOSS, [[0.54, 3.4]])
    marked["<"] = (SpecialKind.UPPER_GRAZING, [[0.56, 3.6]])
    marked["D"] = (SpecialKind.RELEASE, [[0.57, 3.7]])
    for marker, (kind, points) in marked.items():
        assert lines(axes, marker=marker, colour="black") == [(kind.value, points)]
    assert axes.get_xlabel().startswith("damping")


def test_a_graze_that_is_a_fold_is_filled():
    folding = {"special_turn": np.where(np.isnan(BRANCHES["special_turn"]), NAN, [[0.5, -0.25], [0.0, 0.5]])}
    axes = drawn(draw_orbits, orbits_job(continuation="damping"), ORBITS | BRANCHES | folding).axes[0]
    assert lines(axes, marker="^") == [("grazing, a fold", [[0.53, 3.3]])]
    (mark,) = (line for line in axes.lines if line.get_marker() == "^")
    assert mark.get_fillstyle() == "full"


def test_curves_lie_in_the_plane_of_their_two_parameters_below_the_branches():
    job = orbits_job(continuation="damping", curves="eccentricity")
    above, below = drawn(draw_orbits, job, ORBITS | BRANCHES | CURVES).axes
    assert lines(above, marker="o") and below.get_position().y1 < above.get_position().y0
    assert lines(below) == [
        (f"{SpecialKind.SADDLE_NODE.value} at 0.52", [[0.1, 1.1], [0.2, 1.2]]),
        (f"{SpecialKind.PERIOD_DOUBLING.value} at 0.51", [[0.3, 1.3], [0.4, 1.4], [0.5, 1.5]]),
    ]
    assert below.get_xlabel().startswith("damping") and below.get_ylabel().startswith("eccentricity")


PIECES = {
    "piece_size": np.array([2, 3, 2, 2]), "piece_end": np.array([3, 1, 3, 3]),
    "time": np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]),
    "velocity": np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 5.5, 4.5, 3.5]),
}  # fmt: skip
POINTS = np.column_stack([PIECES["time"], PIECES["velocity"]]).tolist()


def test_manifolds_are_solid_or_dotted_in_the_colour_of_their_saddle():
    limits = SimpleNamespace(lowest_velocity=0.5, highest_velocity=6.5)
    job = SimpleNamespace(oscillator=Oscillator(), limits=limits)
    columns = PIECES | {
        "name": np.array(["P(1,1,0)", "P(1,1,1)"]), "orbit_time": np.array([[0.6], [0.9]]),
        "orbit_velocity": np.array([[3.75], [4.0]]),
        # Pieces 0, and 1 and 2, and 3.
        "branch_size": np.array([1, 2, 1]), "branch_kind": np.array([1, 2, 1]), "branch_orbit": np.array([0, 1, 1]),
    }  # fmt: skip
    axes = drawn(draw_manifolds, job, columns).axes[0]
    assert lines(axes, colour="C0") == [("stable manifold of P(1,1,0)", POINTS[:2])]
    assert lines(axes, colour="C1", style="-") == [("stable manifold of P(1,1,1)", POINTS[7:])]
    assert lines(axes, colour="C1", style=":") == [("unstable manifold of P(1,1,1)", POINTS[2:7])]
    assert lines(axes, marker="+") == [("saddle P(1,1,0)", [[0.6, 3.75]]), ("saddle P(1,1,1)", [[0.9, 4.0]])]
    assert axes.get_xlim() == (0.0, 1.0) and axes.get_ylim() == (0.5, 6.5)


def test_pre_images_have_a_colour_for_each_order_and_say_where_one_is_incomplete():
    window = SimpleNamespace(ends=(0.0, 7.0))
    job = SimpleNamespace(oscillator=Oscillator(), velocity=window, first=FirstCurve.LOWER)
    columns = PIECES | {"order_size": np.array([1, 2, 1]), "order_complete": np.array([1, 1, 0])}
    axes = drawn(draw_grazing_curves, job, columns).axes[0]
    assert lines(axes, colour="C0") == [("grazing curve", POINTS[:2])]
    assert lines(axes, colour="C1") == [("pre-image of order 1", POINTS[2:7])]
    assert lines(axes, colour="C2") == [("pre-image of order 2, incomplete", POINTS[7:])]
    assert axes.get_ylim() == (0.0, 7.0)
    job.first = FirstCurve.UPPER
    axes = drawn(draw_grazing_curves, job, columns).axes[0]
    assert lines(axes, colour="C0") == [("grazes of +beta", POINTS[:2])]


@pytest.mark.parametrize("stiffness", [100.0, np.inf])
def test_contacts_of_a_time_history_are_marked_on_their_wall_at_their_time(stiffness):
    oscillator = Oscillator(stiffness=stiffness)
    history = time_history(oscillator, 0.3, 0.6, -6.0, periods=6.0)
    axes, contacts = history_figure(oscillator, history).axes[0], history.contacts
    curve = np.column_stack([history.time, history.displacement]).tolist()
    assert [points for label, points in lines(axes, style="-", colour="tab:blue")] == [curve]
    walls = [points for _, points in lines(axes, style=":")]
    assert walls == [[[0.0, 0.6], [1.0, 0.6]], [[0.0, -0.6], [1.0, -0.6]]]
    on = {"impact": "o", "into contact": "v", "into freeplay": "^"}
    marked = {label: points for marker in on.values() for label, points in lines(axes, marker=marker)}
    kinds = ["impact"] if np.isinf(stiffness) else ["into contact", "into freeplay"]
    assert sorted(marked) == sorted(kinds)
    for kind, points in marked.items():
        assert on[kind] in {line.get_marker() for line in axes.lines if line.get_label() == kind}
        for t, level in points:
            nearest = np.abs(contacts.time - t).argmin()
            assert contacts.time[nearest] == t and contacts.wall[nearest] * 0.6 == level
    assert sum(map(len, marked.values())) == contacts.time.size > 4
    # Both walls are met, and a contact ends after it begins.
    assert {level for points in marked.values() for _, level in points} == {0.6, -0.6}
    assert np.isinf(stiffness) or min(marked["into contact"])[0] < min(marked["into freeplay"])[0]


@pytest.mark.parametrize(("velocity", "enlarged"), [(-4.0, False), (-0.2, True)])
def test_a_panel_begins_at_0_and_enlarges_what_stays_in_the_upper_half(velocity, enlarged):
    oscillator, axes = Oscillator(), Figure().subplots()
    history = time_history(oscillator, 0.25, 0.6, velocity, periods=3.0)
    draw_history_panel(axes, oscillator, history, "label")
    assert (history.displacement.min() > 0.0) == enlarged
    assert axes.get_title(loc="left") == ("label (enlarged)" if enlarged else "label")
    ((_, curve),) = lines(axes, style="-")
    assert curve == np.column_stack([history.time - 0.25, history.displacement]).tolist()
    assert [points[0][1] for _, points in lines(axes, style=":")] == ([0.6] if enlarged else [0.6, -0.6])
    low, high = axes.get_ylim()
    lowest, highest = min(history.displacement.min(), 0.6 if enlarged else -0.6), max(history.displacement.max(), 0.6)
    assert low < lowest and high > highest and lowest - low == pytest.approx(high - highest)

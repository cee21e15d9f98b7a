"""Each figure at a tiny size: its numbers carry what the paper says, or what docs/paper/figures.md says instead."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from rattle import local
from rattle_kernels import CellGrid, Oscillator, Outcome, next_impacts
from rattle_paper.figures import assembly, crises, fig1, fig11, fig17, machine, machine_sweep, sequel
from rattle_paper.production import produce, store_name
from rattle_paper.registry import PAPER_FIGURES, figure_named
from worker.errors import InvalidJob, JobCancelled

ROOT = Path(__file__).parents[2]
SMALL = CellGrid(time_cells=60, velocity_cells=60)


def ignore(*progress):
    pass


def produced(name, folder, report=ignore):
    done = produce(figure_named(name), folder, SMALL, report=report, workers=2)
    assert imread(done.picture).size > 100_000
    return json.loads(done.numbers.read_text())


def produced_again(name, folder):
    """From the basins that are there: none is computed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(local, "run_here", None)
        return produced(name, folder)


def shares(panel):
    return {solution["name"]: solution["share"] for solution in panel["solutions"]}


def lasting(damping, eccentricity, impacts):
    """Whether any of some motions beside the saddle P(1,1,0) rattles on for so many impacts."""
    t, v = np.meshgrid(np.linspace(0.715, 0.76, 12), np.linspace(4.75, 4.9, 12))
    landed = next_impacts(Oscillator(damping, eccentricity), t.ravel(), v.ravel(), impacts, shortcuts=True)
    return bool((landed.outcome == Outcome.RETURNED).any())


pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("figures")


@pytest.fixture(scope="module")
def fig7(folder):
    return produced("fig7", folder)


def test_both_models_of_fig7_have_permanent_contact_and_p110_and_only_the_stiff_one_p120(fig7):
    stiff, limit = (shares(fig7["panels"][name]) for name in ("piecewise linear", "impacting"))
    assert stiff.keys() == {"permanent contact", "P(1,1,0)", "P(1,2,0)", "P(8,8,5)"}
    assert limit.keys() == {"permanent contact", "P(1,1,0)", "chaotic"}
    assert stiff["permanent contact"] == pytest.approx(limit["permanent contact"], abs=0.04)
    assert stiff["P(8,8,5)"] == pytest.approx(limit["chaotic"], abs=0.03)
    assert 0.0 < stiff["P(1,2,0)"] < 0.03


def test_what_fig7_shows_as_chaos_at_kappa_1e6_is_a_transient_of_six_thousand_impacts(fig7):
    panel = fig7["panels"]["piecewise linear"]
    (orbit,) = [solution for solution in panel["solutions"] if solution["name"] == "P(8,8,5)"]
    assert orbit["lyapunov_exponent"] == pytest.approx(-0.3, abs=1e-9)
    assert orbit["share_not_settled"] == pytest.approx(orbit["share"] * math.exp(-1499 / 6100), rel=0.15)
    transient = panel["transient"]
    assert transient["settles_on"] == "P(8,8,5)" and transient["lyapunov_exponent"] > 0.1
    assert abs(transient["mean_life_impacts"] - 6100) < 4 * transient["mean_life_error"] < 1500


def test_fig6_draws_near_to_the_impacting_model_as_stiffness_grows_and_its_stores_are_shared(fig7, folder):
    panels = produced("fig6", folder)["panels"]
    quiet_or_not = [panel["differs_from_impacting"]["quiet_or_not"] for panel in panels.values()]
    quiet_or_not.append(fig7["differs_from_impacting"]["quiet_or_not"])
    assert np.all(np.diff(quiet_or_not) < 0.0) and quiet_or_not[0] > 0.4 and quiet_or_not[-1] < 0.06
    names = [set(shares(panel)) for panel in panels.values()]
    common = {"permanent contact", "P(1,1,0)", "P(1,2,0)"}
    assert names == [common | more for more in ({"P(1,1,1)"}, {"P(1,1,1)", "P(3,3,2)"}, {"P(6,6,4)"}, {"P(2,2,1)"})]
    assert len(list(folder.glob("impacting-*.zarr"))) == 1
    assert produced_again("fig6", folder)["panels"] == panels


def test_a_motion_of_fig4_swings_back_one_leaves_after_several_maxima_and_one_stays(tmp_path):
    panels = produced("fig4", tmp_path)["panels"]
    assert panels["a"]["maxima"] == 1 and panels["a"]["departures_within_one_rotation"] >= 3
    assert panels["b"]["maxima"] >= 3 and panels["b"]["minima"] == panels["b"]["maxima"] - 1
    assert panels["b"]["stay"] < 1.0
    assert panels["c"]["stay"] == "permanent" and panels["c"]["departures_within_one_rotation"] == 0
    assert len({panel["enters_at"][0] for panel in panels.values()}) == 1


def test_stable_rattle_coexists_with_quiet_at_the_machines_parameters(tmp_path, monkeypatch):
    monkeypatch.setattr(fig1, "_DEPARTURES", 40)
    numbers = produced("fig1", tmp_path)
    assert numbers["quiet"]["least_displacement"] > numbers["oscillator"]["half_backlash"]
    names = [motion["name"] for motion in numbers["rattling"]]
    assert "P(1,1,0)" in names and len(names) >= 3
    assert all(motion["lyapunov_exponent"] < 0.0 for motion in numbers["rattling"])
    settled = sum(motion["departures"] for motion in numbers["rattling"]) + numbers["quiet"]["departures"]
    assert settled + numbers["not_settled"] == 40
    assert numbers["half_swing_of_contact"] == pytest.approx(math.pi / math.sqrt(2000.0), rel=1e-6)


def changes(numbers, what):
    return {change["name"]: tuple(change["between"]) for change in numbers["changes"] if change["what"] == what}


def names_of(numbers):
    return {name: set(shares(panel)) for name, panel in numbers["panels"].items()}


def test_rattle_of_fig8_is_born_at_the_bound_and_coexists_with_quiet_alone_at_first(tmp_path):
    numbers = produced("fig8", tmp_path)
    names, quiet = names_of(numbers), "permanent contact"
    assert numbers["values"] == [0.056, 0.0615, 0.067, 0.0725, 0.078, 0.0835, 0.089, 0.0945, 0.1]
    assert names["eccentricity 0.056"] == {quiet}
    assert names["eccentricity 0.067"] == names["eccentricity 0.0615"] == {quiet, "P(1,1,0)"}
    assert names["eccentricity 0.1"] == {quiet, "P(1,1,0)", "chaotic"}
    assert all("P(1,1,0)" in names[f"eccentricity {value:g}"] for value in numbers["values"][1:])
    before, after = changes(numbers, "birth")["P(1,1,0)"]
    assert before < 0.0596431 < after and "P(1,1,0)" not in changes(numbers, "death")
    assert len(list(tmp_path.glob("*-over-eccentricity-*.zarr"))) == 1
    assert produced_again("fig8", tmp_path) == numbers


def test_solutions_of_fig9_die_where_the_paper_says_until_all_is_quiet(tmp_path):
    numbers = produced("fig9", tmp_path)
    names, died = names_of(numbers), changes(numbers, "death")
    assert names["damping 0.7"] == {"permanent contact"}
    assert died["P(1,2,0)"] == (0.575, 0.6) and died["P(1,3,0)"] == (0.5, 0.525)
    assert died["P(1,1,0)"] == died["chaotic"] == (0.675, 0.7)
    # At 0.65 chaos does not last.
    born = [
        change["between"] for change in numbers["changes"] if (change["what"], change["name"]) == ("birth", "chaotic")
    ]
    assert born == [[0.575, 0.6], [0.65, 0.675]]
    assert "chaotic transient" in names["damping 0.65"] and "chaotic" not in names["damping 0.65"]
    assert "P(3,3,2)" in names["damping 0.525"] and "P(2,2,1)" in names["damping 0.575"]
    quiet = [shares(panel)["permanent contact"] for panel in numbers["panels"].values()]
    assert np.all(np.diff(quiet) > 0.0) and quiet[-1] == 1.0
    for panel in numbers["panels"].values():
        assert sum(shares(panel).values()) == pytest.approx(1.0)
        numbered = {solution["number"]: solution["name"] for solution in panel["solutions"]}
        assert all(numbers["solutions"][number] == name for number, name in numbered.items())


def test_the_three_flights_of_figs_2_and_3_meet_what_their_types_say(tmp_path):
    panels, fig3 = produced("fig2", tmp_path)["panels"], produced("fig3", tmp_path)
    assert [[met["wall"] for met in panels[label]["meets"]] for label in "ab"] == [["+beta"], ["-beta", "+beta"]]
    assert panels["c"]["lowest_displacement"] == pytest.approx(-0.6, abs=1e-6)
    assert fig3["flights"] == panels
    curve = fig3["grazing_curve"]
    assert all(abs(point["newton_differs"]) < 1e-12 and point["newton_steps"] < 10 for point in curve["points"])
    assert all(point["t_hat"] > point["t"] for point in curve["points"])
    speeds = [point["v"] for point in curve["points"]]
    assert curve["lowest"][1] <= min(speeds) and max(speeds) <= curve["highest"][1]


def test_what_fig5_puts_back_to_cell_centres_goes_another_way_than_what_it_does_not(tmp_path):
    maps = produced("fig5", tmp_path)["maps"]
    corrected, true = maps["P_cell"]["images"], maps["P_corr o P^4"]["images"]
    assert corrected[0] == true[0] and corrected[1] != true[1]
    landed = next_impacts(Oscillator(), 0.9375, 3.55, 4)
    assert true[3] == pytest.approx([float(landed.t), float(landed.v)], abs=1e-10)


def test_p120_of_fig10_ends_in_a_saddle_node_and_its_basin_with_it(folder):
    numbers = produced("fig10", folder)
    assert numbers["saddle_node"]["damping"] == pytest.approx(0.5997157625984, abs=1e-11)
    assert numbers["last_followed"] == pytest.approx(0.5997, abs=1e-9)
    orbits = {label: [orbit["attracts"] for orbit in panel["orbits"]] for label, panel in numbers["panels"].items()}
    assert orbits == {"b": [True, False], "c": [True, False], "d": []}
    assert shares(numbers["panels"]["b"])["P(1,2,0)"] == pytest.approx(0.0705, abs=0.01)
    assert "P(1,2,0)" not in shares(numbers["panels"]["d"])


def test_motions_of_fig11_depend_on_the_way_and_its_points_are_the_papers(tmp_path, monkeypatch):
    monkeypatch.setattr(fig11, "_VALUES", 201)
    numbers = produced("fig11", tmp_path)
    stretches = {
        way: [(each["impact_period"], each["from"], each["to"]) for each in numbers["stretches"][way]]
        for way in ("up", "down")
    }
    at_a = {way: [period for period, *ends in stretches[way] if min(ends) <= 0.527 <= max(ends)] for way in stretches}
    assert at_a == {"up": [3], "down": [0]}
    points = {what: point["damping"] for what, point in numbers["special_points"].items()}
    assert points["B"] == pytest.approx(0.5818436719138, abs=1e-11)
    assert points["C"] == pytest.approx(0.5922073480957, abs=1e-11)


def test_chaos_of_fig12_coexists_with_p332_which_lives_between_its_birth_and_its_doubling(folder):
    numbers = produced("fig12", folder)
    assert shares(numbers).keys() >= {"P(3,3,2)", "chaotic transient", "P(1,1,0)", "P(1,2,0)", "permanent contact"}
    window = numbers["windows"]["P(3,3,2)"]
    assert [(side, window[side]["kind"]) for side in window] == [("below", "saddle-node"), ("above", "period doubling")]
    assert window["below"]["damping"] < 0.527 < window["above"]["damping"]


def test_the_orbit_of_fig13_is_about_to_graze_and_has_lost_its_basin(folder):
    before, at = produced("fig13", folder)["panels"].values()
    assert before["orbit"]["name"] == "P(2,2,1)" and shares(before)["P(2,2,1)"] > 0.25
    assert at["orbit"]["name"] == "P(4,4,2)" and at["orbit"]["grazing_distance"] < 1e-4
    assert shares(at).get("P(4,4,2)", 0.0) < 0.001 and shares(at)["P(24,24,14)"] > 0.23
    assert at["windows"]["P(24,24,14)"]["above"]["damping"] < 0.592207


def test_manifolds_of_figs_14_to_16_are_the_boundaries_and_preimages_only_some(folder):
    fig14, fig15, fig16 = (produced(name, folder) for name in ("fig14", "fig15", "fig16"))
    orders = [order["share_of_boundaries"] for order in fig14["orders"]]
    assert orders == sorted(orders) and fig14["share_of_boundaries"] < 0.7
    assert [each["saddle"]["name"] for each in fig15["manifolds"].values()] == ["P(1,1,0)", "P(1,1,1)"]
    assert all(each["saddle"]["residual"] < 1e-13 for each in fig15["manifolds"].values())
    assert fig15["share_of_boundaries"] == fig16["shares_of_boundaries"]["both manifolds"] == 1.0
    assert fig16["shares_of_boundaries"]["grazing curve and pre-images 1, 2"] < 0.7


def test_manifolds_of_fig17_reach_v_40_where_an_impact_costs_4_beta_delta(tmp_path, monkeypatch):
    monkeypatch.setattr(fig17, "_ARCLENGTH", 60.0)
    numbers = produced("fig17", tmp_path)
    b = numbers["manifolds"]["B"]["branches"]
    assert all("faster than asked for" in branch["end"] for branch in b)
    assert [branch["arclength"] for branch in b] == pytest.approx([22.355, 25.859], abs=0.01)
    least, greatest = numbers["speed_lost_there"]
    assert least < 4 * 0.6 * 0.6 < greatest < least + 0.06


def test_a_figure_that_is_stopped_goes_on_where_it_was(tmp_path):
    def stop_at_the_second(what, done, total):
        if what.startswith("basin 2"):
            raise JobCancelled("enough")

    with pytest.raises(JobCancelled, match="enough"):
        produced("fig6", tmp_path, stop_at_the_second)
    assert not list(tmp_path.glob("fig6.*"))
    first = tmp_path / store_name(figure_named("fig6").jobs(SMALL)["kappa 1e2"])
    before = {path: path.stat().st_mtime_ns for path in first.rglob("*")}
    assert before and len(produced("fig6", tmp_path)["panels"]) == 4
    assert {path: path.stat().st_mtime_ns for path in first.rglob("*")} == before


def test_a_figure_that_is_not_there_is_refused_and_those_that_are_listed():
    with pytest.raises(InvalidJob, match=", ".join(PAPER_FIGURES)):
        figure_named("fig99")


def test_the_machine_s_basins_are_told_by_share_with_their_lowest_rattle(folder, monkeypatch):
    monkeypatch.setattr(machine, "_DAMPINGS", {"delta 0.06": 0.06, "delta 6e-3": 6e-3})
    for panel in produced("machine", folder)["panels"].values():
        told = [solution["share"] for solution in panel["solutions"]]
        assert told == sorted(told, reverse=True) and sum(told) == pytest.approx(1.0)
        assert {"permanent contact", "P(1,2,0)"} <= {solution["name"] for solution in panel["solutions"]}
        assert 0.2 < panel["least_rattle"]["velocity"] / panel["oscillator"]["damping"] < 3.0


def test_the_assembly_angle_decides_how_much_is_quiet(folder, monkeypatch):
    monkeypatch.setattr(assembly, "_POINTS", 512)
    monkeypatch.setattr(assembly, "_PHASES", (0.0, 0.375, 0.7, 1.0))
    told = produced("assembly", folder)
    quiet = told["quiet"]
    assert quiet[0] == quiet[3] and quiet[2] < told["one_gear"]["quiet"] < quiet[1]
    for name, share, error in (("worst", quiet[2], told["quiet_error"][2]), ("best", quiet[1], told["quiet_error"][1])):
        # A sample of 512 and a grid of 3600, each of which misses the area by its own error.
        assert abs(shares(told["panels"][name])["permanent contact"] - share) < 5 * error
    one_gear, *others = (store_name(job) for job in figure_named("assembly").jobs(SMALL).values())
    assert len({one_gear, *others}) == 4


def test_quiet_of_the_machine_grows_with_damping_and_falls_with_eccentricity(folder, monkeypatch):
    monkeypatch.setattr(machine_sweep, "_MACHINE", machine.machine_oscillator(6e-3))
    monkeypatch.setattr(machine_sweep, "_DAMPINGS", (6e-3, 12e-3))
    monkeypatch.setattr(machine_sweep, "_ECCENTRICITIES", (0.4e-3, 1e-3))
    monkeypatch.setattr(machine_sweep, "_POINTS", 128)
    panels = produced("machine-sweep", folder)["panels"]
    quiet = np.array([panel["quiet"] for panel in panels]).reshape(2, 2)
    assert (quiet[1] > quiet[0]).all() and (quiet[:, 0] > quiet[:, 1]).all()
    for panel in panels:
        assert panel["undecided"] == 0.0 and 0.0 < panel["proven_quiet_below"]
        assert panel["least_rattle"] is None or panel["least_rattle"] > panel["proven_quiet_below"]


def test_chaos_of_the_sequel_begins_at_its_graze_and_grows_like_the_root_of_the_distance(folder, monkeypatch):
    monkeypatch.setattr(sequel, "_PIXELS", 2)
    monkeypatch.setattr(sequel, "_DISTANCES", (1e-8, 1e-6, 3e-5))
    told = produced("sequel", folder)
    assert told["points"]["neutral graze"] == pytest.approx([0.7601647632, 0.0957060530], abs=1e-9)
    assert told["points"]["saddle-node and graze"] == pytest.approx([0.770147130934, 0.097890812717], abs=1e-11)
    assert told["graze"]["scenario"] == "persists" and told["graze"]["damping"] == pytest.approx(0.764661554, abs=1e-9)
    for row in told["chaos"]:
        # Terms of the size of the push are left out: relative to the turn's own size, 20 times the root of the depth.
        left_out = 20.0 * math.sqrt(row["distance"]) * row["leading_exponent"]
        error = left_out + 5.0 * row["exponent_error"]
        assert row["exponent"] == pytest.approx(row["leading_exponent"], abs=error) and row["exponent"] > 0.0
    # Up to the powers of the multipliers between two impacts, which are whole numbers of turns.
    assert told["size_grows_with_the_power"] == pytest.approx(0.5, abs=0.1)
    assert told["sides"]["above"].keys() == {"permanent contact", "P(1,1,0)"}
    assert told["sides"]["below"].keys() == {"permanent contact", "chaotic"}
    dampings, eccentricities = np.array(told["chaos_ends"]).T
    assert (np.diff(dampings) > 0.0).all() and (np.diff(eccentricities) > 0.0).all()
    for damping, eccentricity in zip(dampings[::8].tolist(), eccentricities[::8].tolist(), strict=True):
        # Chaos outlasts 200,000 impacts on one side of it, and none of it 20,000 on the other.
        assert lasting(damping, eccentricity - 1e-5, 200_000) and not lasting(damping, eccentricity + 1e-4, 20_000)


def test_chaos_lasts_longer_the_nearer_to_its_end_and_the_numbers_of_the_document_are_these(folder, monkeypatch):
    monkeypatch.setattr(crises, "_IMPACTS", 5e7)
    told = produced("crises", folder)
    document = (ROOT / "docs" / "theory" / "crises.md").read_text()
    for what, parameter, name in (
        ("crisis", "damping", "delta"), ("homoclinic", "eccentricity", "eps"), ("birth", "damping", "delta"),
    ):  # fmt: skip
        assert f"| {name} = {told[what][parameter]:.11f} |" in document
    for what in ("crisis", "homoclinic"):
        assert "({:.7f}, {:.7f})".format(*told[what]["tip"]) in document
        assert f"| {told[what]['exponent']:.3f}" in document and abs(told[what]["distance"]) < 1e-12
    for rows in told["lives"].values():
        seen = [row for row in rows if row["left"] >= 50]
        assert len(seen) >= 2
        for near, far in zip(seen[:-1], seen[1:], strict=True):
            # But for five errors of both a life falls at least with the power 3/4 of the distance: that of the birth,
            # whose basin grows from nothing, with less than 1.
            errors = 5.0 * math.hypot(1.0 / math.sqrt(near["left"]), 1.0 / math.sqrt(far["left"]))
            assert near["mean_life"] / far["mean_life"] > (far["distance"] / near["distance"]) ** 0.75 * (1.0 - errors)
    values = np.array(told["curve"])
    assert (np.diff(values[:, 0]) < 0.0).all() and len(values) == 21

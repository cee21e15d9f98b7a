"""One page for the person who decides: it says what was computed, needs no network, and is the same each time."""

import re
from html.parser import HTMLParser

import pytest

import rattle
from rattle_machine.numbers import RPM
from rattle_machine.proven import Proven
from rattle_machine.pulses import pulses
from rattle_machine.report import report
from rattle_machine.tolerances import tolerances
from worker.errors import InvalidJob

# A machine of the paper's numbers, nearly: some of its departures end in rattle.
PAIR = rattle.GearPair(
    speed=100.0, inertia=0.01, drag_torque=9.5493, base_radius=0.1, backlash=0.12, transmission_error=0.01
)
RATE, SIZE = 1 / 60, 2.5 * PAIR.scales.impulse
WITHIN = {"transmission_error.1.amplitude": "10 +- 2 mm", "backlash": (0.11, 0.13)}
QUICK = {"cells": 24, "speeds": 3, "departures": 64, "progress": False}


class _Page(HTMLParser):
    """Tags that are open at the end, attributes that lead elsewhere, and the text."""

    def __init__(self) -> None:
        super().__init__()
        self.open, self.leads, self.text, self.tags = [], [], [], []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        if tag not in ("meta", "link", "br"):
            self.open.append(tag)
        self.leads += [value for name, value in attrs if name in ("src", "href", "xlink:href", "data", "action")]

    def handle_startendtag(self, tag, attrs):
        self.leads += [value for name, value in attrs if name in ("src", "href", "xlink:href")]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def _read(path):
    page = _Page()
    page.feed(path.read_text(encoding="utf-8"))
    return page


@pytest.fixture(scope="module", autouse=True)
def proven():
    """Stands for a proof, whose kernels take minutes to compile."""
    with pytest.MonkeyPatch.context() as patched:
        said = Proven(0.125, 0.5, None, tightened=True)
        patched.setattr("rattle_machine.tolerances.prove_quiet", lambda *given, **options: said)
        yield said


@pytest.fixture(scope="module")
def written(tmp_path_factory, proven):
    path = tmp_path_factory.mktemp("report") / "pump.html"
    return report(PAIR, path, rate=RATE, size=SIZE, numbers=WITHIN, machines=64, title="Pump <3>", **QUICK)


def test_it_is_one_page_that_needs_no_other(written):
    page = _read(written)
    assert page.open == [] and page.tags.count("svg") == 3
    assert not {"script", "iframe", "img", "object"} & set(page.tags)
    # A picture refers to its own parts and holds images in itself.
    assert all(lead.startswith(("#", "data:image/png;base64,")) for lead in page.leads)
    assert "Pump <3>: does it rattle?" in "".join(page.text), "a title is text, whatever it holds"
    assert not re.search(r"url\((?!#|&quot;#)", written.read_text(encoding="utf-8"))


def test_it_says_what_the_studies_say(written, proven):
    text = "".join(_read(written).text)
    assert text.count(str(proven)) == 1
    hit = pulses(PAIR, rate=RATE, size=SIZE, departures=64)
    production = tolerances(PAIR, WITHIN, machines=64, departures=32, size=SIZE, rate=RATE)
    assert f"{hit.lasting.times(100.0).value:.3g} % end in rattle that lasts" in text
    assert f"Of the production {production.production.bad.times(100.0)} %" in text
    assert f"Γ = {PAIR.gamma:.4g} at 954.93 rpm" in text
    basin = rattle.basin(PAIR, cells=24, progress=False)
    assert f"{100.0 * float(basin.share.values[0]):.3g} % end in quiet" in text
    for name, share in zip(basin["name"].values, basin.share.values, strict=True):
        assert f"{name}{100.0 * share:.3g} %" in text.replace("\n", "")


@pytest.mark.slow
def test_the_same_questions_give_the_same_bytes(written, tmp_path):
    rattle.cache.clear()
    again = report(
        PAIR, tmp_path / "other.html", rate=RATE, size=SIZE, numbers=WITHIN, machines=64, title="Pump <3>", **QUICK
    )
    assert again.read_bytes() == written.read_bytes()


@pytest.mark.slow
def test_a_page_is_written_where_nothing_can_be_proven(monkeypatch, tmp_path, proven):
    monkeypatch.setattr("rattle_machine.report.can_prove", lambda: False)
    text = "".join(_read(report(PAIR, tmp_path / "page.html", numbers=WITHIN, machines=64, **QUICK)).text)
    assert "Which tolerance" in text and "of the tightened production" not in text


def test_a_page_without_pulses_and_tolerances_says_nothing_of_them(tmp_path):
    text = "".join(_read(report(PAIR, tmp_path / "short.html", **QUICK)).text)
    assert "How often" not in text and "Which tolerance" not in text and "What is not modelled" in text


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"rate": 1.0}, "give both, or neither"),
        ({"size": 1.0}, "give both, or neither"),
        ({"speeds": 1}, "speeds must be a whole number from 2 on"),
        ({"numbers": {"backlash": "wide"}}, "is no tolerance"),
    ],
)
def test_what_cannot_be_asked_is_said_and_nothing_is_written(tmp_path, asked, said):
    with pytest.raises(InvalidJob, match=said):
        report(PAIR, tmp_path / "none.html", **QUICK | asked)
    assert not list(tmp_path.iterdir())


FAST = rattle.GearPair(**PAIR.model_dump() | {"restitution": 0.8}).at_speed(1.5 * PAIR.threshold_speed)


def test_a_machine_that_always_rattles_has_a_page_that_never_calls_it_quiet(tmp_path):
    text = "".join(_read(report(FAST, tmp_path / "fast.html", prove=False, **QUICK)).text)
    power = rattle.basin(FAST, cells=24, progress=False).rattle.loudness().expected_impact_power_w.item()
    assert "the machine always rattles: inertia torque is 225 % of drag torque" in text
    assert re.search(r"up to [\d.]+ m/s: ([\d.]+) kW", text)[1] == f"{power / 1e3:.4g}"
    assert f"From {PAIR.threshold_speed * RPM:.6g} rpm on" in text and "what differs is how loud" in text
    for said in ("can run quietly", "Permanent contact is quiet", "fall quiet", "permanent contact"):
        assert said not in text


@pytest.mark.slow
def test_a_page_says_which_speeds_and_machines_lie_beyond_the_threshold(tmp_path):
    pair, within = FAST.at_speed(130.0), {"speed": (125.0, 150.0)}
    asked = {"numbers": within, "machines": 32, "prove": False}
    text = "".join(_read(report(pair, tmp_path / "page.html", **asked, **QUICK)).text)
    found = tolerances(pair, within, machines=32, departures=32)
    part = 100.0 * (found.table["gamma"] >= 1.0).mean()
    assert "the machine can run quietly" in text and f"From {PAIR.threshold_speed * RPM:.6g} rpm on" in text
    assert text.count(f"{part:.3g} % of all machines of the production always rattle") == 2
    assert f"over all for which it is known: {found.production.power} W" in text


def test_pulses_beyond_the_threshold_are_refused_with_the_speed(tmp_path):
    with pytest.raises(InvalidJob, match=f"below {PAIR.threshold_speed * RPM:.6g} rpm"):
        report(FAST, tmp_path / "none.html", rate=RATE, size=SIZE, **QUICK)
    assert not list(tmp_path.iterdir())


def test_the_page_of_a_machine_with_a_mesh_stiffness_beyond_the_threshold(tmp_path):
    stiff = rattle.GearPair(**FAST.model_dump() | {"restitution": None, "mesh_stiffness": 3e5})
    assert stiff.gamma > 1.0 and not stiff.can_be_quiet
    text = "".join(_read(report(stiff, tmp_path / "stiff.html", prove=False, **QUICK)).text)
    assert "the machine always rattles" in text and "No motion presses the teeth together all the time" in text
    assert "end in quiet" not in text

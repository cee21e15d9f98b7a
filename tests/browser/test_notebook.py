"""The explorer as a widget, in a fresh JupyterLab and in marimo: no service, and both directions."""

import re

import pytest
from playwright.sync_api import expect

from tests.browser.chromium import Explorer
from tests.browser.notebooks import running, write_notebook

pytestmark = pytest.mark.browser

FRAME = "iframe[title='Explorer of gear-rattle']"
SHOWS = "import rattle\nwidget = rattle.explore(rattle.Oscillator(damping=0.65))\nwidget"
MARIMO = """
import marimo
app = marimo.App()

@app.cell
def _():
    import marimo as mo
    import rattle
    return mo, rattle

@app.cell
def _(mo, rattle):
    widget = mo.ui.anywidget(rattle.explore(rattle.Oscillator(damping=0.7)))
    widget
    return (widget,)

@app.cell
def _(mo, widget):
    mo.md(f"departs {widget.departure}, highlights {widget.solution}")

if __name__ == "__main__":
    app.run()
"""


class Lab:
    """A notebook in JupyterLab, whose cells are run one after another."""

    def __init__(self, page):
        self.page = page
        self.frame = page.frame_locator(FRAME)
        self.run = 0

    def run_next(self):
        """Run the next cell; its output once it has ended."""
        self.run += 1
        self.page.keyboard.press("Shift+Enter")
        cell = self.page.locator(".jp-CodeCell").nth(self.run - 1)
        expect(cell.locator(".jp-InputPrompt").first).to_have_text(f"[{self.run}]:", timeout=90_000)
        return cell.locator(".jp-OutputArea-output")


@pytest.fixture
def lab(chromium_here, tmp_path, request):
    """JupyterLab with a notebook of the cells that a test names."""
    write_notebook(tmp_path / "looking.ipynb", *request.param)
    arguments = ["-m", "jupyterlab", "--no-browser", "--allow-root", "--port={port}", "--IdentityProvider.token="]
    with running(arguments, tmp_path, "/api") as address:
        explorer = Explorer(chromium_here, address)
        explorer.page.goto(f"{address}/lab/tree/looking.ipynb?reset")
        expect(explorer.page.locator(".jp-CodeCell")).to_have_count(len(request.param), timeout=60_000)
        expect(explorer.page.get_by_text("| Idle")).to_be_visible(timeout=60_000)
        explorer.page.locator(".jp-CodeCell .jp-InputArea-editor").first.click()
        yield Lab(explorer.page)
        explorer.context.close()


def departs(frame, across, up):
    """Click a place of the plot in the frame."""
    plane = frame.locator("#plane")
    left, top, width, height = map(float, plane.get_attribute("data-frame").split(","))
    plane.click(position={"x": left + across * width, "y": top + (1 - up) * height})


SAME_VIEW = """
other = rattle.explore()
for line in widget.history:
    exec(line, {"widget": other, "rattle": rattle})
other
"""


@pytest.mark.parametrize(
    "lab",
    [(SHOWS, "widget.departure, widget.solution, widget.oscillator.damping", "widget.oscillator = rattle.Oscillator(damping=0.6)\nwidget.solution = 'P(1,1,0)'", SAME_VIEW, "other.address == widget.address, other.address")],
    indirect=True,
)  # fmt: skip
def test_what_is_seen_is_in_traits_and_what_is_set_is_seen(lab):
    lab.run_next()
    frame = lab.frame
    expect(frame.locator("#standing")).to_contain_text("Preview", timeout=90_000)
    expect(frame.locator("#shown")).to_contain_text("δ = 0.65")
    departs(frame, 0.4, 0.6)
    expect(frame.locator("#histories")).to_contain_text(re.compile("falls quiet|ends in|rattles"), timeout=30_000)
    frame.locator("#legend button").first.click()
    told = lab.run_next().inner_text()
    assert re.match(r"\(\(0\.[34]\d*, 4\.\d+\), '.+', 0\.65\)", told), told
    lab.run_next()
    expect(frame.locator("#shown")).to_contain_text("δ = 0.6", timeout=30_000)
    expect(frame.locator("#legend button[aria-pressed=true]")).to_have_attribute("data-solution", "P(1,1,0)", timeout=30_000)
    lab.run_next()
    other = lab.page.frame_locator(f"{FRAME} >> nth=1")
    expect(other.locator("#shown")).to_contain_text("δ = 0.6", timeout=90_000)
    expect(other.locator("#legend button[aria-pressed=true]")).to_have_count(1, timeout=30_000)
    assert lab.run_next().inner_text().startswith("(True, "), lab.page.locator(".jp-CodeCell").last.inner_text()


COMPUTES = "import rattle\nwidget = rattle.explore(rattle.basin(cells=100, progress=False))\nwidget"


@pytest.mark.parametrize(
    "lab", [(COMPUTES, "widget.result.solution.shape")], indirect=True
)
def test_a_basin_that_was_computed_is_shown_as_it_is(lab):
    lab.run_next()
    expect(lab.frame.locator("#state")).to_contain_text("Complete", timeout=90_000)
    assert lab.run_next().inner_text() == "(100, 100)"


def test_marimo_follows_it(chromium_here, tmp_path):
    (tmp_path / "looking.py").write_text(MARIMO)
    arguments = ["-m", "marimo", "run", "looking.py", "--headless", "--port", "{port}", "--no-token"]
    with running(arguments, tmp_path, "/health") as address:
        explorer = Explorer(chromium_here, address)
        explorer.page.goto(address)
        frame = explorer.page.frame_locator(FRAME)
        expect(frame.locator("#standing")).to_contain_text("Preview", timeout=90_000)
        departs(frame, 0.4, 0.6)
        expect(explorer.page.locator("body")).to_contain_text(re.compile(r"departs \[?\(?0\.[34]\d*, 4\.\d+"), timeout=30_000)
        explorer.context.close()

"""The explorer as a widget, in a fresh JupyterLab and in marimo: no service, and both directions."""

import re

import pytest
from playwright.sync_api import expect

from tests.browser.chromium import Explorer
from tests.browser.notebooks import running, write_notebook
from tests.waiting import wait_until

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
    widget = mo.ui.anywidget(rattle.explore(rattle.Oscillator(damping=0.65)))
    widget
    return (widget,)

@app.cell
def _(mo, widget):
    mo.md(f"departs {widget.departure}, highlights {widget.solution}")

if __name__ == "__main__":
    app.run()
"""


class Lab:
    """A notebook in JupyterLab, and the frames of its outputs."""

    def __init__(self, page):
        self.page = page
        self.executed = 0

    def run(self, number):
        """Run a cell; what it prints once it has ended."""
        self.executed += 1
        cell = self.page.locator(".jp-CodeCell").nth(number)
        cell.locator(".jp-InputArea-editor").click()
        self.page.keyboard.press("Shift+Enter")
        expect(cell.locator(".jp-InputPrompt").first).to_have_text(f"[{self.executed}]:", timeout=90_000)
        return "".join(cell.locator(".jp-OutputArea-output").all_inner_texts())

    def run_until(self, number, expected):
        """Run a cell until it prints something, as messages arrive between two runs alone."""
        wait_until(f"cell {number} prints {expected}", lambda: re.search(expected, self.run(number)))

    def frame(self, number=0):
        """Frame of a widget."""
        return self.page.frame_locator(f"{FRAME} >> nth={number}")


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
        yield Lab(explorer.page)
        explorer.context.close()


def departs(frame, across, up):
    """Click a place of the plot in the frame."""
    plane = frame.locator("#plane")
    left, top, width, height = map(float, plane.get_attribute("data-frame").split(","))
    plane.click(position={"x": left + across * width, "y": top + (1 - up) * height})


LOOKS = (
    SHOWS,
    "widget.departure, widget.solution, widget.oscillator.damping",
    "widget.oscillator = rattle.Oscillator(damping=0.58)\nwidget.solution = 'P(1,1,0)'",
    "' '.join(widget.history)",
    "other = rattle.explore()\nfor line in widget.history:\n    exec(line, {'widget': other, 'rattle': rattle})\nother",
    "other.address == widget.address, widget.address",
)


@pytest.mark.parametrize("lab", [LOOKS], indirect=True)
def test_what_is_seen_is_in_traits_and_what_is_set_is_seen(lab):
    lab.run(0)
    frame = lab.frame()
    expect(frame.locator("#standing")).to_contain_text("Preview", timeout=90_000)
    expect(frame.locator("#shown")).to_contain_text("δ = 0.65")
    departs(frame, 0.4, 0.6)
    expect(frame.locator("#histories")).to_contain_text(re.compile("falls quiet|ends in|rattles"), timeout=30_000)
    frame.locator("#legend button").first.click()
    lab.run_until(1, r"\(\(0\.[34]\d*, 4\.\d+\), '.+', 0\.65\)")
    lab.run(2)
    expect(frame.locator("#shown")).to_contain_text("δ = 0.58", timeout=30_000)
    chosen = frame.locator("#legend button[aria-pressed=true]")
    expect(chosen).to_have_attribute("data-solution", "P(1,1,0)", timeout=30_000)
    lab.run_until(3, r"damping=0.58.*P\(1,1,0\)")
    lab.run(4)
    expect(lab.frame(1).locator("#shown")).to_contain_text("δ = 0.58", timeout=90_000)
    lab.run_until(5, r"True,\s.*damping=0.58.*highlight=P\(1,1,0\)")


COMPUTED = "import rattle\nwidget = rattle.explore(rattle.basin(cells=100, progress=False))\nwidget"


@pytest.mark.parametrize("lab", [(COMPUTED, "widget.result.solution.shape")], indirect=True)
def test_a_basin_that_was_computed_is_shown_as_it_is(lab):
    lab.run(0)
    expect(lab.frame().locator("#state")).to_contain_text("Complete", timeout=90_000)
    lab.run_until(1, r"\(100, 100\)")


def test_marimo_follows_it(chromium_here, tmp_path):
    (tmp_path / "looking.py").write_text(MARIMO)
    arguments = ["-m", "marimo", "run", "looking.py", "--headless", "--port", "{port}", "--no-token"]
    with running(arguments, tmp_path, "/health") as address:
        explorer = Explorer(chromium_here, address)
        explorer.page.goto(address)
        frame = explorer.page.frame_locator(FRAME)
        expect(frame.locator("#standing")).to_contain_text("Preview", timeout=90_000)
        departs(frame, 0.4, 0.6)
        expect(explorer.page.locator("body")).to_contain_text(
            re.compile(r"departs \[?\(?0\.[34]\d*, 4\.\d+"), timeout=30_000
        )
        explorer.context.close()

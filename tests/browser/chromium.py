"""Chromium of the system, driven by Playwright, and a page that notices what a user would not see."""

import contextlib
import shutil

from playwright.sync_api import expect, sync_playwright


def chromium():
    """Where the system keeps Chromium."""
    found = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    assert found, "there is no Chromium here: `make test-browser` installs it where it may"
    return found


@contextlib.contextmanager
def browser():
    """A browser until the context ends."""
    with sync_playwright() as playwright:
        # Without a sandbox, as tests may be run by root, where Chromium refuses one.
        started = playwright.chromium.launch(executable_path=chromium(), args=["--no-sandbox"])
        yield started
        started.close()


class Explorer:
    """The page as a user has it before them; `complaints` are what its console says."""

    def __init__(self, browser, url, **context):
        self.url = url
        self.context = browser.new_context(**({"viewport": {"width": 1440, "height": 980}} | context))
        self.page = self.context.new_page()
        self.complaints = []
        # What reading the colours of the canvas, which only these tests do, is told.
        self.forgiven = ("willReadFrequently",)
        self.page.on("console", self._heard)
        self.page.on("pageerror", lambda error: self.complaints.append(f"uncaught: {error}"))

    def _heard(self, message):
        if message.type in ("error", "warning"):
            self.complaints.append(f"{message.text} at {message.location['url']}")

    def unforgiven(self):
        """Complaints but for those that belong to what is tested."""
        return [told for told in self.complaints if not any(part in told for part in self.forgiven)]

    def visit(self, query=""):
        """Open the page."""
        self.page.goto(f"{self.url}/{query}")
        expect(self.page.locator("#preset option")).not_to_have_count(1)
        return self

    def pictured(self, words="Preview"):
        """Wait until a picture is seen that says so."""
        expect(self.page.locator("#standing")).to_contain_text(words, timeout=30_000)
        return self

    def ask(self, query):
        """Open a link, and compute what it asks for."""
        self.visit(query).pictured("Compute refines it").compute()
        return self

    def state(self, text, seconds=60):
        """Wait until the job's line says so."""
        expect(self.page.locator("#state")).to_contain_text(text, timeout=1000 * seconds)

    def open_drawer(self):
        """Open the drawer with the request, unless it is open."""
        if not self.page.locator("#ask").is_visible():
            self.page.locator("#open-drawer").click()

    def fill(self, **fields):
        """Fill fields of the form, by their names with an underscore for a dot."""
        self.open_drawer()
        for name, value in fields.items():
            self.page.locator(f"#ask [name='{name.replace('__', '.')}']").fill(str(value))

    def compute(self):
        """Press the button, once the form has been checked."""
        expect(self.page.locator("#compute")).to_be_enabled()
        self.page.locator("#compute").click()

    def film(self, of, as_="WebM", **fields):
        """Have the page make a film; its download."""
        if not self.page.locator(".film").is_visible():
            self.page.locator("#away summary").click()
        self.page.locator(".film select[name='film.of']").select_option(of)
        self.page.locator(".film select[name='film.as']").select_option(as_)
        for name, value in fields.items():
            self.page.locator(f".film input[name='film.{name}']").fill(value)
        with self.page.expect_download(timeout=300_000) as download:
            self.page.get_by_role("button", name="Make the film").click()
        return download.value

    def frame(self, plane="#plane"):
        """Left, top, width and height of the plot on the screen."""
        box = self.page.locator(plane).bounding_box()
        left, top, width, height = map(float, self.page.locator(plane).get_attribute("data-frame").split(","))
        return box["x"] + left, box["y"] + top, width, height

    def spot(self, across, up, plane="#plane"):
        """Place on the screen of a part of the plot, from its lower left corner."""
        left, top, width, height = self.frame(plane)
        return left + across * width, top + (1 - up) * height

    def hover(self, across, up, plane="#plane"):
        """Move the pointer there, and read what the page says of it."""
        self.page.mouse.move(*self.spot(across, up, plane))
        return self.page.locator("#reading").inner_text()

    def colour(self, across, up, plane="#plane", canvas=None):
        """Colour of the plot at a place, or of another canvas over it: red, green, blue."""
        x, y = self.spot(across, up, plane)
        box = self.page.locator(plane).bounding_box()
        script = """(canvas, [x, y]) => {
            const ratio = canvas.width / canvas.clientWidth;
            return [...canvas.getContext("2d").getImageData(x * ratio, y * ratio, 1, 1).data].slice(0, 3);
        }"""
        return tuple(self.page.locator(canvas or plane).evaluate(script, [x - box["x"], y - box["y"]]))

"""A real browser before real processes, for the tests of the page."""

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
FLAGS = ("--no-sandbox", "--disable-dev-shm-usage", "--mute-audio")
STARTS = 600.0  # s: a fresh clone compiles first
PATIENCE = 120.0  # s for a page on a busy machine
ENDS = 120.0  # s
LEASH = ("--duration", "1200")  # s, if nobody is left to end it
DESK = {"width": 1280, "height": 720}
CODE = (
    "import signal\n"
    "signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background ignores it\n"
    "from skinfield.cli.main import main; main()\n"
)
NOISE = ("GL Driver Message", "WebGL-0x")  # what rendering in software says of itself
SCREEN = """window.requestAnimationFrame = (draw) => setTimeout(draw, 80);
window.cancelAnimationFrame = clearTimeout;"""  # a slow one: a processor draws all pictures


def browser_path() -> str:
    """Where a browser is; skips where there is none, but where one is required."""
    found = next((path for name in NAMES if (path := shutil.which(name))), None)
    if found is None:
        without = f"the page is tested in a browser, and there is none of {', '.join(NAMES)}"
        assert os.environ.get("SKINFIELD_BROWSER") != "required", without
        pytest.skip(without)
    return found


@contextmanager
def running_browser() -> Iterator[Any]:
    """A headless browser."""
    path = browser_path()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=path, args=list(FLAGS))
        try:
            yield browser
        finally:
            browser.close()


AXE = Path(__file__).parent.parent / "page" / "node_modules" / "axe-core" / "axe.min.js"
VIOLATIONS = """() => axe.run(document, { resultTypes: ["violations"] }).then(({ violations }) =>
  violations.flatMap(({ id, nodes }) => nodes.map(({ target, failureSummary: why }) =>
    `${id}: ${target.join(" ")}: ${why}`)))"""

SETTLED = """() => new Promise(requestAnimationFrame).then(() => Promise.allSettled(
    document.getAnimations().map(({ finished }) => finished)))"""  # colours change slowly


def axe_script() -> str:
    """Checks of a page's accessibility; skips where `npm ci` of page/ has not brought them.

    They must be there where a browser is required and npm is.
    """
    if AXE.is_file():
        return AXE.read_text(encoding="utf-8")
    without = "axe-core is not here: `npm ci` in page/ brings it"
    required = os.environ.get("SKINFIELD_BROWSER") == "required" and shutil.which("npm")
    assert not required, without
    pytest.skip(without)


class Served:
    """A `skinfield` command that serves the page.

    Parameters
    ----------
    words : str
        The command and its options.
    folder : Path
        That it works in.
    port : int
    """

    def __init__(self, *words: str, folder: Path, port: int = 0) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-c", CODE, *words, "--no-browser", "--port", str(port), *LEASH],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            cwd=folder,
            process_group=0,
            env=os.environ | {"OMP_NUM_THREADS": "1", "COLUMNS": "300"},
        )
        self.said: list[str] = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.said.append(line.rstrip())

    @property
    def address(self) -> str:
        """Of the page, as the command prints it."""
        end = time.monotonic() + STARTS
        while time.monotonic() < end:
            for line in self.said:
                if line.startswith("page: "):
                    return line.removeprefix("page: ").strip()
            if self.process.poll() is not None:
                self._reader.join(ENDS)
                break
            time.sleep(0.05)
        raise AssertionError(f"no address was printed: {self.said}")

    @property
    def port(self) -> int:
        """Of the page."""
        port = urlsplit(self.address).port
        assert port is not None
        return port

    def ask(self, path: str) -> Any:
        """JSON of a path such as /api/status."""
        from urllib.request import urlopen

        parts = urlsplit(self.address)
        query = f"?{parts.query}" if parts.query else ""
        with urlopen(f"http://{parts.netloc}{path}{query}", timeout=PATIENCE) as answer:
            return json.load(answer)

    def wait_running(self) -> None:
        """Wait until its engine answers."""
        end = time.monotonic() + STARTS
        while self.ask("/api/status")["state"] != "running":
            assert self.process.poll() is None, self.said
            assert time.monotonic() < end, self.said
            time.sleep(0.1)

    def kill(self) -> None:
        """End it without a word, and all that it started."""
        with suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait(ENDS)

    def close(self) -> None:
        """End it as Ctrl-C does; kill what is left."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            with suppress(subprocess.TimeoutExpired):
                self.process.wait(ENDS)
        self.kill()
        self._reader.join(ENDS)
        if self.process.stdout is not None:
            self.process.stdout.close()


@contextmanager
def served(*words: str, folder: Path, port: int = 0) -> Iterator[Served]:
    """A command as long as the block lasts."""
    made = Served(*words, folder=folder, port=port)
    try:
        yield made
    finally:
        made.close()


@dataclass
class Look:
    """A page that is open, and all that went wrong in it.

    Attributes
    ----------
    page : playwright's Page
    wrong : list of str
        Errors and warnings of the console, exceptions, failed requests.
    """

    page: Any
    wrong: list[str] = field(default_factory=list)

    def listen(self) -> None:
        """Note what goes wrong."""
        page = self.page
        page.on("console", self._console)
        page.on("pageerror", lambda error: self.wrong.append(f"exception: {error}"))
        page.on("requestfailed", lambda each: self.wrong.append(f"failed: {each.url}"))
        page.on("response", self._response)

    def _console(self, message: Any) -> None:
        noise = any(part in message.text for part in NOISE)
        if message.type in ("error", "warning") and not noise:
            self.wrong.append(f"{message.type}: {message.text}")

    def _response(self, response: Any) -> None:
        if response.status >= 400:
            self.wrong.append(f"{response.status}: {response.url}")

    def open(self, address: str) -> None:
        """Load the page and wait for its first pictures."""
        self.page.goto(address, timeout=1e3 * PATIENCE)
        self.until("window.skinfield && skinfield.state.updates > 0")

    def until(self, condition: str, given: Any = None, patience: float = PATIENCE) -> Any:
        """Wait until a JavaScript expression, or function of `given`, is true; what it is then.

        The page's own rules forbid what playwright does for this.
        """
        end = time.monotonic() + patience
        while time.monotonic() < end:
            if found := self.value(condition, given):
                return found
            self.page.wait_for_timeout(40)
        raise AssertionError(f"it did not come to be: {condition} ({given}); {self.wrong}")

    def value(self, expression: str, given: Any = None) -> Any:
        """What a JavaScript expression, or function of `given`, gives."""
        return self.page.evaluate(expression, given)

    def at(self, name: str) -> Any:
        """Locator of a control by its name."""
        return self.page.locator(f'[data-testid="{name}"]')

    def rows(self) -> list[dict[str, str]]:
        """Data of the contacts' rows."""
        found = self.value(ROWS)
        assert isinstance(found, list)
        return found

    def wait_rows(self, condition: Callable[[list[dict[str, str]]], bool]) -> list[dict[str, str]]:
        """Rows of contacts as soon as they are so, in two looks one after the other."""
        end, met = time.monotonic() + PATIENCE, 0
        while time.monotonic() < end:
            rows = self.rows()
            met = met + 1 if condition(rows) else 0
            if met > 1:
                return rows
            self.page.wait_for_timeout(60)
        raise AssertionError(f"the contacts did not become so: {rows}")

    def stand_still(self) -> None:
        """Pause a recording, wherever it is; at its end, where it stops by itself, as well."""
        self.until("skinfield.state.controls.replay")
        if self.value("skinfield.state.controls.replay.playing"):
            self.at("play").click()  # should it end just then, this begins it anew: to the end
        self.until("!skinfield.state.controls.replay.playing")

    def seek(self, t_s: float) -> None:
        """Move the time bar of a recording, which has steps, and wait until it is there.

        Where no cycle was recorded, as an engine on a busy machine misses some, the next one is
        shown, and a few updates later it still is.
        """
        before = self.value("skinfield.state.updates")
        self.at("time-bar").evaluate(
            """(bar, t) => { bar.value = t;
            bar.dispatchEvent(new Event('input', { bubbles: true }));
            bar.dispatchEvent(new Event('change', { bubbles: true })); }""",
            t_s,
        )
        self.until(
            """([t, before]) => { const late = skinfield.state.lastUpdate.time_s - t;
            return late > -0.021 && (late < 0.021 || skinfield.state.updates > before + 4); }""",
            [t_s, before],
        )

    def accessible(self) -> list[str]:
        """What axe finds wrong with the page as it is now, in both themes."""
        if not self.value("Boolean(window.axe)"):
            self.value(axe_script())
        found: list[str] = []
        for _ in range(2):
            theme = self.value("document.documentElement.dataset.theme")
            self.value(SETTLED)
            found += [f"{theme}: {each}" for each in self.value(VIOLATIONS)]
            self.value("document.getElementById('theme').click()")  # below a dialog, too
        return found

    def draw(self) -> None:
        """Wait until the page shows what it knows."""
        self.value("skinfield.scene.whenDrawn()")

    def shoot(self, name: str, after_ms: float = 0.0) -> None:
        """Keep a picture, after a while, where `SKINFIELD_PICTURES` names a folder for them."""
        if asked := os.environ.get("SKINFIELD_PICTURES"):
            self.page.wait_for_timeout(after_ms)
            self.page.screenshot(path=Path(asked) / "page" / f"{name}.png")


ROWS = """() => [...document.querySelectorAll(
    '[data-testid="contacts-table"] tbody tr[data-track]')].map(
    (row) => ({ ...row.dataset, text: row.innerText }))"""


@contextmanager
def looking(browser: Any, size: dict[str, int] = DESK, **more: Any) -> Iterator[Look]:
    """A page of its own, at first empty."""
    context = browser.new_context(viewport=size, **more)
    try:
        context.add_init_script(SCREEN)
        look = Look(context.new_page())
        look.listen()
        yield look
    finally:
        context.close()

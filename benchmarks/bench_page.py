"""How quick the page is: updates and bytes a second, and from a press to its picture.

    python benchmarks/bench_page.py [--seconds 10] [--presses 20]

Starts `skinfield run` with the virtual skin. The floor is a client that draws nothing and asks for
the next update at once. Then a headless Chromium does the same and draws: by the processor, where
there is no graphics card. Last, presses by the mouse: from the event in the page to the drawn
update that first shows a contact within 3 mm of it, the readings' own 10 ms included.
"""

import argparse
import json
import shutil
import subprocess
import sys
import time
from pathlib import Path
from statistics import median

from playwright.sync_api import sync_playwright
from websockets.sync.client import connect

NAMES = ("chromium", "chromium-browser", "google-chrome")
STARTS = 600.0  # s
COUNTED = "() => [skinfield.state.updates, skinfield.state.bytes, performance.now()]"
WATCH = """() => {
  window.laps = [];
  let began = null;
  document.addEventListener('pointerdown', (event) => { began = event.timeStamp; }, true);
  const look = () => {
    const { contacts, truth } = skinfield.state;
    const near = (c) => truth.some((t) => Math.hypot(
      ...c.position.map((each, i) => each - t.position[i])) < 3e-3);
    if (began !== null && contacts.some(near)) {
      window.laps.push(performance.now() - began);
      began = null;
    }
    requestAnimationFrame(look);
  };
  look();
}"""


def floor(address: str, seconds: float) -> tuple[float, float]:
    """Updates and bytes a second of a client that draws nothing."""
    updates = octets = 0
    with connect(address.replace("http", "ws") + "socket", max_size=None) as socket:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            message = socket.recv()
            octets += len(message)
            if not isinstance(message, bytes):
                continue
            head = json.loads(message[8 : 8 + int.from_bytes(message[4:8], "little")])
            if head["kind"] == "update":
                updates += 1
                socket.send(json.dumps({"do": "ack", "number": head["number"]}))
    return updates / seconds, octets / seconds


def drawn(page, seconds: float) -> tuple[float, float]:
    """Updates and bytes a second of the page."""
    first = page.evaluate(COUNTED)
    page.wait_for_timeout(1e3 * seconds)
    last = page.evaluate(COUNTED)
    span = (last[2] - first[2]) / 1e3
    return (last[0] - first[0]) / span, (last[1] - first[1]) / span


def presses(page, count: int) -> list[float]:
    """Times, ms, from the press of the button to the picture."""
    page.evaluate(WATCH)
    box = page.locator('[data-testid="skin-canvas"]').bounding_box()
    for number in range(count):
        x, y = 0.42 + 0.16 * (number % 5) / 4, 0.45 + 0.1 * (number % 3) / 2
        page.mouse.move(box["x"] + x * box["width"], box["y"] + y * box["height"])
        page.mouse.down()
        page.wait_for_timeout(900)
        page.mouse.up()
        page.keyboard.press("Escape")
        page.wait_for_timeout(700)
    return sorted(page.evaluate("() => window.laps"))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--presses", type=int, default=20)
    given = parser.parse_args()
    browser = next((path for name in NAMES if (path := shutil.which(name))), None)
    if browser is None:
        raise SystemExit(f"no browser is here, expected one of {', '.join(NAMES)}")
    command = [str(Path(sys.executable).with_name("skinfield")), "run", "--port", "0"]
    more = ["--no-browser", "--headless", "--name", "bench-page", "--scene", "slide"]
    child = subprocess.Popen([*command, *more], stdout=subprocess.PIPE, text=True)
    try:
        assert child.stdout is not None
        address = next(line for line in child.stdout if line.startswith("page: "))[6:].strip()
        measure(address, browser, given)
    finally:
        child.terminate()
        child.wait(30)


def wait_ready(page) -> None:
    end = time.monotonic() + STARTS
    ready = "() => !!skinfield.state.controls && !skinfield.state.controls.busy"
    while not page.evaluate(ready):
        if time.monotonic() > end:
            raise SystemExit("the skin did not get ready")
        page.wait_for_timeout(200)


def measure(address: str, browser: str, given: argparse.Namespace) -> None:
    with sync_playwright() as play:
        chromium = play.chromium.launch(executable_path=browser, args=["--no-sandbox"])
        page = chromium.new_page(viewport={"width": 1280, "height": 720})
        page.goto(address)
        page.wait_for_function("() => window.skinfield && skinfield.state.updates > 0")
        wait_ready(page)
        page.wait_for_timeout(5000)  # deformation is prepared by then
        rate, octets = drawn(page, given.seconds)
        page.goto("about:blank")
        floor_rate, floor_octets = floor(address, given.seconds)
        print("slide, 40 x 40          updates/s   kB/s")
        print(f"asks at once (floor)      {floor_rate:7.1f} {floor_octets / 1e3:6.0f}")
        print(f"Chromium, drawn           {rate:7.1f} {octets / 1e3:6.0f}")
        page.goto(address)
        page.wait_for_function("() => window.skinfield && skinfield.state.updates > 0")
        found = presses(page, given.presses)
        chromium.close()
    print(f"press to picture, ms: {len(found)} of {given.presses} seen", end="")
    if found:
        print(f", p50 {median(found):.0f}, shortest {found[0]:.0f}, longest {found[-1]:.0f}")


if __name__ == "__main__":
    main()

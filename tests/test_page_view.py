"""The page of recordings in a real browser, who may open it, and its picture, pixel by pixel."""

import signal
from collections.abc import Iterator
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any
from urllib.error import HTTPError
from urllib.request import urlopen

import numpy as np
import pytest
from browser import DESK, ENDS, PATIENCE, Look, Served, looking, served
from live_skins import unique_name
from page_fixtures import *  # noqa: F403
from page_gestures import LABELS, Hand
from page_sources import StillSource
from replay_sample import PERIOD, ROWS, Known, write

from skinfield.page.server import serve_page
from skinfield.page.settings import PageSettings

TOKEN = "a-long-enough-secret"
CYCLES = 400
SECOND = 1_000_000_000


@pytest.fixture(scope="module")
def made(folder: Path) -> list[Known]:
    return write(folder / "touch.mcap", CYCLES)


@pytest.fixture(scope="module")
def view(folder: Path, made: list[Known]) -> Iterator[Served]:
    """The page of a recording, for others too."""
    words = ("view", "touch.mcap", "--host", "0.0.0.0", "--token", TOKEN)
    with served(*words, folder=folder) as running:
        yield running


@pytest.fixture(scope="module")
def opened(browser: Any, view: Served) -> Iterator[Look]:
    with looking(browser) as look:
        look.open(view.address)
        yield look


@pytest.fixture
def look(opened: Look) -> Iterator[Look]:
    yield opened
    assert opened.wrong == []
    assert opened.value("skinfield.state.malformed") == []


def one_within(low: float, high: float, rows: list[dict[str, str]]) -> bool:
    """Whether there is one contact with a force between these."""
    return len(rows) == 1 and low < float(rows[0]["force"]) < high


# a recording


def test_a_recording_is_shown_as_it_was(look: Look, made: list[Known]) -> None:
    assert look.value("skinfield.state.hello.mode") == "replay"
    assert look.value("skinfield.state.hello.replay.end_s") == pytest.approx((CYCLES - 1) * 0.01)
    look.stand_still()
    for place in (112, 180, 262):
        look.seek(place * PERIOD / SECOND)
        # the bar has steps, and a cycle lasts 10 ms: it is one of the nearest
        near = [made[place + off].force for off in (-2, -1, 0, 1, 2)]
        look.wait_rows(partial(one_within, min(near) - 5e-3, max(near) + 5e-3))
    look.shoot("view")
    for name in ("tare", "record", "press-middle", "solver", "recordings"):  # of no use here
        assert not look.at(name).is_visible(), name
    assert "This page only looks on" not in look.page.inner_text("body")


def test_it_plays_at_the_asked_speed_and_starts_again_at_the_end(look: Look) -> None:
    look.at("speed").select_option("10")
    look.until("skinfield.state.controls.replay.speed === 10")
    if not look.value("skinfield.state.controls.replay.playing"):
        look.at("play").click()
    look.until("!skinfield.state.controls.replay.playing")  # at the end
    end = look.value("skinfield.state.hello.replay.end_s")
    look.until("(end) => Math.abs(skinfield.state.lastUpdate.time_s - end) < 0.02", end)
    look.at("speed").select_option("0.5")
    look.page.keyboard.press("Space")
    look.until("skinfield.state.controls.replay.playing && skinfield.state.lastUpdate.time_s < 2")
    look.page.keyboard.press("Space")
    look.until("!skinfield.state.controls.replay.playing")


def test_it_steps_by_readings_and_loops(look: Look) -> None:
    look.stand_still()
    look.seek(1.0)
    first = look.value("skinfield.state.lastUpdate.time_s")
    period = PERIOD / SECOND
    for button, time_s in (("step-on", first + period), ("step-back", first)):
        look.at(button).click()
        look.until("(t) => Math.abs(skinfield.state.lastUpdate.time_s - t) < 1e-3", time_s)
    look.at("loop").click()
    look.until("skinfield.state.controls.replay.loop")
    end = look.value("skinfield.state.hello.replay.end_s")
    look.seek(end - 0.2)
    look.at("speed").select_option("1")
    look.at("play").click()
    look.until("(end) => skinfield.state.lastUpdate.time_s < end / 2", end)
    look.at("play").click()
    look.until("!skinfield.state.controls.replay.playing")
    look.at("loop").click()
    look.until("!skinfield.state.controls.replay.loop")


def test_its_timeline_is_drawn_and_its_contacts_are_saved(look: Look, made: list[Known]) -> None:
    inked = """() => { const it = document.getElementById("time-strip");
      const { data } = it.getContext("2d").getImageData(0, 0, it.width, it.height);
      return data.filter((value, i) => i % 4 === 3 && value > 0).length / (data.length / 4); }"""
    look.until(f"({inked})() > 0.15")
    assert look.at("replay-events").locator("option").count() > 1
    with look.page.expect_download() as saved:
        look.at("export-csv").click()
    lines = Path(saved.value.path()).read_text().splitlines()
    contacts = sum(len(np.frombuffer(each.contacts, ROWS.contact)) for each in made)
    assert len(lines) == 1 + contacts
    assert look.accessible() == []


def test_the_force_before_where_it_is_gone_to_is_plotted(look: Look, made: list[Known]) -> None:
    look.stand_still()
    for time_s in (0.1, 2.5):  # nothing was played in between
        look.seek(time_s)
    box = look.at("force-plot").bounding_box()
    a_second = (box["width"] - 50) / 10  # beside the axis
    look.page.mouse.move(box["x"] + box["width"] - 10 - a_second, box["y"] + 40)
    tip = look.until("document.querySelector('#force-plot .plot-tip')?.innerText").split("\n")
    before = float(tip[0].removesuffix(" s").replace("−", "-"))
    assert before == pytest.approx(-1.0, abs=0.15)
    place = round((2.5 + before) * SECOND / PERIOD)
    near = [each.force for each in made[place - 10 : place + 11]]
    assert min(near) - 0.01 < sum(map(float, tip[1:])) < max(near) + 0.01
    look.shoot("force-before")
    look.page.mouse.move(2, 2)


def test_several_browsers_play_it_together(browser: Any, view: Served, look: Look) -> None:
    with looking(browser) as other:
        other.open(view.address)
        look.seek(1.5)
        other.until("Math.abs(skinfield.state.lastUpdate.time_s - 1.5) < 0.03")
        assert other.wrong == []


# who may


def test_the_token_is_asked_for(view: Served) -> None:
    assert f"token={TOKEN}" in view.address
    with pytest.raises(HTTPError, match="401") as refused:
        urlopen(f"http://127.0.0.1:{view.port}/api/status", timeout=PATIENCE)
    refused.value.close()
    found = view.ask("/api/status")
    assert found["mode"] == "replay"
    assert found["engines"][0]["name"] == "touch.mcap"


def test_a_page_without_the_token_says_so(browser: Any, view: Served) -> None:
    with looking(browser) as look:
        look.page.goto(f"http://127.0.0.1:{view.port}/")
        look.until("!document.querySelector('#refused').hidden")
        assert "token" in look.page.locator("#refused").inner_text()


# an engine that dies, a curved skin


def test_a_curved_skin_is_pressed_and_its_page_connects_again(folder: Path, browser: Any) -> None:
    words = ("run", "--name", unique_name(), "--skin", "cylinder", "--headless", "--scene", "idle",
             "--grid", "20", "--rate-hz", "100", "--priority", "0")  # fmt: skip
    with served(*words, folder=folder) as running:
        running.wait_running()
        with looking(browser) as look:
            look.open(running.address)
            curved(look)
            reconnects(look, running)


def curved(look: Look) -> None:
    """A curved patch is pressed where one clicks."""
    assert look.value("skinfield.state.hello.patches[0].flat") is False
    hand = Hand(look)
    hand.click(3.0, 4.0)
    rows = look.wait_rows(lambda rows: len(rows) == 1 and "truthXMm" in rows[0])
    assert float(rows[0]["truthXMm"]) == pytest.approx(3.0, abs=0.2)
    assert float(rows[0]["truthYMm"]) == pytest.approx(4.0, abs=0.2)
    look.wait_rows(lambda rows: len(rows) == 1 and float(rows[0]["errorMm"]) < 3.0)
    look.shoot("curved", 1000)
    hand.lift()
    assert look.wrong == []


def reconnects(look: Look, running: Served) -> None:
    """The page goes on by itself when a server is there again, here of forces that are relative."""
    source, port = StillSource(relative=True), running.port
    assert texts(look, ".force-unit") == ["N"] * 3
    source.read(1.0)
    running.kill()
    look.until("!skinfield.socket.open")
    look.until("document.querySelector('#status-line').textContent.includes('lost')")
    look.shoot("connection-lost")
    look.value("skinfield.state.lastUpdate = null")
    with serve_page(PageSettings(port=port), lambda: (source,)):
        look.until("skinfield.socket.open && skinfield.state.lastUpdate !== null")
        assert look.value("skinfield.state.connections") == 2
        look.until("skinfield.state.status.state === 'running'")
        look.wait_rows(lambda rows: len(rows) == 1)
        assert texts(look, ".force-unit") == ["rel."] * 3
        assert texts(look, "#contacts-total")[0].endswith(" rel. in all")
        assert texts(look, "#colour-name, #range-unit") == ["Pressure, relative", "relative"]
        look.shoot("relative")


def texts(look: Look, selector: str) -> list[str]:
    """Of all elements of a selector, in the page's order."""
    script = f"[...document.querySelectorAll({selector!r})].map((each) => each.textContent)"
    return list(look.value(script))


# the command


def test_it_ends_when_told_to(folder: Path, made: list[Known]) -> None:
    with served("view", "touch.mcap", folder=folder) as running:
        assert running.address.startswith("http://127.0.0.1:")
        running.process.send_signal(signal.SIGTERM)
        assert running.process.wait(ENDS) == 0


# A picture of a skin made up here: no server is behind it

SITE = "http://skin.test/"
COUNT, PITCH = 40, 1.3e-3  # nodes on a side, m
HIGH = 80e3  # Pa, end of the colour bar

# A flat skin of COUNT² nodes around the origin, with four taxels near its corners
BEGIN = """([count, pitch]) => {
  const scene = window.skinfield.scene, places = [], normals = [], plane = [];
  const middle = (count - 1) / 2;
  for (let r = 0; r < count; r++) for (let c = 0; c < count; c++) {
    plane.push((c - middle) * pitch, (r - middle) * pitch);
    places.push((c - middle) * pitch, (r - middle) * pitch, 0);
    normals.push(0, 0, 1);
  }
  const far = 0.8 * middle * pitch, taxels = [], outward = [];
  for (const [x, y] of [[-far, -far], [far, -far], [far, far], [-far, far]]) {
    taxels.push(x, y, 0); outward.push(0, 0, 1);
  }
  const about = { i: 0, name: "sheet", taxels: 4, flat: true, side: count * pitch, pitch: 5e-3 };
  scene.setTheme("dark");
  scene.setSkin({ name: "made up", patches: [about], size: count * pitch, press: null });
  scene.setGeometry({ patch: 0, rung: count, rows: count, columns: count }, {
    positions: places, normals, plane, covered: new Uint8Array(count * count).fill(1),
    taxels, taxel_normals: outward });
  scene.showTaxels(false);
  scene.showLabels(false);
}"""

# The same value everywhere, the middle pressed in by a smooth dent; then a look at some places
SHOW = """([count, pitch, high, value, answer, quantity, spots, dead, repaired]) => {
  const scene = window.skinfield.scene, k = count * count, middle = (count - 1) / 2;
  const height = Uint16Array.from({ length: k }, (_, i) => {
    const away = Math.hypot(i % count - middle, Math.floor(i / count) - middle) / count;
    return 65535 * Math.exp(-((away / 0.2) ** 4));
  });
  const colour = new Uint16Array(k).fill(65535 * value);
  scene.setQuantity(quantity);
  scene.setColours({ lo: 0, hi: high, map: "viridis" });
  scene.update({ quantity, range: [0, high], contacts: [], truth: [], patches: [{
    i: 0, answer, rung: count, height: 0, colour: 1, taxels: 2, repaired: 3,
    height_scale: 1e-4 / 65535, colour_lo: 0, colour_hi: high }] },
    [height, colour, Uint8Array.from([0, 127, dead ? 255 : 0, 254]),
      Uint8Array.from(repaired === null ? [] : [0, 0, repaired, 0])]);
  return spots.map(([x, y]) => {
    const out = { position: [0, 0, 0], normal: [0, 0, 1] };
    scene.patches.at(0, x, y, out);
    const at = scene.project(out.position);
    return scene.colourAt(at.x, at.y);
  });
}"""


@pytest.fixture(scope="module")
def page(browser: Any) -> Any:
    shipped = files("skinfield.page") / "static"
    page = browser.new_page(viewport=DESK)
    page.route("**/*", lambda route: answer(route, shipped))
    page.goto(SITE)
    page.evaluate(BEGIN, [COUNT, PITCH])
    return page


FRAMES = """new Promise((done) => {  // three pictures later
    const next = (left) => (left ? requestAnimationFrame(() => next(left - 1)) : done());
    next(3); })"""


def resize(page: Any, size: dict[str, int]) -> None:
    """Give the window a size, and wait until the page shows it."""
    page.set_viewport_size(size)
    page.evaluate(f"{FRAMES}.then(() => skinfield.scene.whenDrawn())")


def answer(route: Any, shipped: Any) -> None:
    name = route.request.url.removeprefix(SITE) or "index.html"
    part = shipped / name
    if part.is_file():
        route.fulfill(path=str(part))
    else:
        route.abort()


def colours_at(
    page: Any,
    spots: list[tuple[float, float]],
    value: float = 0.0,
    answer: str = "contacts",
    quantity: str = "pressure",
    dead: bool = False,
    repaired: int | None = None,
) -> np.ndarray:
    given = [COUNT, PITCH, HIGH, value, answer, quantity, spots, dead, repaired]
    return np.array(page.evaluate(SHOW, given))


def viridis(value: float) -> np.ndarray:
    """The colour that matplotlib's own table gives."""
    colormaps = pytest.importorskip("matplotlib").colormaps
    return np.round(255 * np.array(colormaps["viridis"](value)[:3]))


# In the middles of cells: the lines between them are lighter
FLAT = [(-16.0 * PITCH, 1.0 * PITCH), (15.0 * PITCH, -14.0 * PITCH), (0.0, 0.0)]  # the bottom, too
CORNER = 0.8 * (COUNT - 1) / 2 * PITCH
SKIN = {"dark": (51, 58, 72), "light": (211, 217, 226)}  # that nothing presses


@pytest.mark.parametrize("value", [0.13, 0.5, 0.77, 1.0])
def test_the_skin_has_the_colours_of_the_bar(page: Any, value: float) -> None:
    """Flat skin and the bottom of a dent, between the ruled lines, within rounding."""
    assert np.abs(colours_at(page, FLAT, value) - viridis(value)).max() <= 3


@pytest.mark.parametrize("theme", SKIN)
def test_zero_pressure_is_the_skins_own_colour(page: Any, theme: str) -> None:
    """In the middle between black and white, and told from the background."""
    page.evaluate("(name) => skinfield.scene.setTheme(name)", theme)
    own = np.array(SKIN[theme])
    assert np.ptp(own) < 25
    assert np.abs(colours_at(page, FLAT) - own).max() <= 3
    corner = page.evaluate("(() => skinfield.scene.colourAt(3, 3))()")
    assert np.abs(np.array(corner) - own).min() > 20
    bright = colours_at(page, FLAT, 1.0).mean() > colours_at(page, FLAT, 0.3).mean()
    assert bright == (theme == "dark")  # more stands out more against the skin
    page.evaluate("skinfield.scene.setTheme('dark')")


def test_a_dent_has_a_bright_and_a_dark_side(page: Any) -> None:
    """Lit from the left and above: the wall that faces the light is the bright one."""
    side = 0.17 * COUNT * PITCH  # from the middle, where walls are steep
    walls = [(-0.9 * side, 0.4 * side), (0.9 * side, -0.4 * side)]
    flat, shades = viridis(0.5).mean(), []
    for times in (6.0, 20.0):  # it is shallow
        page.evaluate("(times) => skinfield.scene.setExaggeration(times)", times)
        shades.append(colours_at(page, walls, 0.5).mean(axis=1))
    page.evaluate("skinfield.scene.setExaggeration(3)")
    [near, far], [nearer, farther] = shades
    assert nearer < near - 4 < flat - 8
    assert farther > far + 4 > flat + 8


FILLED = """(colour) => {
  const { scene } = skinfield, gl = scene.picture.renderer.getContext();
  scene.draw();
  const [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
  const bytes = new Uint8Array(4 * width * height);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  let [left, right, low, high] = [width, 0, height, 0];
  for (let k = 0; k < width * height; k += 1) {
    if (!colour.every((value, a) => Math.abs(bytes[4 * k + a] - value) < 4)) continue;
    const [x, y] = [k % width, Math.floor(k / width)];
    [left, right] = [Math.min(left, x), Math.max(right, x)];
    [low, high] = [Math.min(low, y), Math.max(high, y)];
  }
  return [(right - left) / width, (high - low) / height];
}"""


@pytest.mark.parametrize(
    "size", [DESK, {"width": 900, "height": 1100}, {"width": 1600, "height": 640}]
)
def test_the_skin_fills_the_picture(page: Any, size: dict[str, int]) -> None:
    """In the direction that limits it, also after the window has changed."""
    colours_at(page, FLAT)
    resize(page, size)
    across, along = page.evaluate(FILLED, SKIN["dark"])
    resize(page, DESK)
    assert 0.80 < max(across, along) < 0.97
    assert min(across, along) > 0.3


TOUCH = """([x, y, times, shear]) => {
  const { scene } = skinfield, round = Array.from({ length: 33 }, (_, i) => [
    x + 3e-3 * Math.cos(i * Math.PI / 16), y + 3e-3 * Math.sin(i * Math.PI / 16), 0]);
  scene.setExaggeration(times);
  const place = { patch: 0, x, y, position: [x, y, 0], normal: [0, 0, 1], force: 1.0,
    shear: shear && { size: Math.hypot(...shear), angle: 0, vector: shear } };
  scene.marks.contacts = [{ ...place, key: "a", track: 1, force_std: 0.1, area: 28e-6,
    place_cov: [4e-7, 1e-7, 2e-7], outline: round }];
  scene.marks.truth = [{ ...place, id: "p", contact_radius: 3e-3 }];
  scene.showLabels(true);
  scene.draw();
  const { data } = scene.marks.arrows;
  const tips = [3, 13].map((at) => scene.project(data.slice(at, at + 3)));
  const middle = [0, 1].map((a) => round.slice(0, 32).reduce((sum, at) => sum + at[a], 0) / 32);
  const labels = scene.marks.labels.placed.filter((each) => each.accent).map(
    ({ x, y, width, height, anchorX, anchorY }) => ({ x, y, width, height, anchorX, anchorY }));
  const pushes = [0, 10].map((at) => [0, 1, 2].map((a) => data[at + 3 + a] - data[at + a]));
  const found = { tips, pushes, middle: scene.project([...middle, 0]), labels };
  scene.marks.contacts = scene.marks.truth = [];
  scene.showLabels(false);
  scene.setExaggeration(3);
  scene.draw();
  return found;
}"""


@pytest.mark.parametrize("shear", [None, [0.5, 0.0, 0.0], [-0.3, -0.6, 0.0]])
@pytest.mark.parametrize("times", [1.0, 3.0, 30.0])
def test_arrows_end_in_the_middle_of_the_ring_on_the_skin_at_rest(
    page: Any, times: float, shear: list[float] | None
) -> None:
    """However deep the dent is drawn; they point as the force does, and a label covers neither."""
    colours_at(page, FLAT)
    found = page.evaluate(TOUCH, [2e-3, 1e-3, times, shear])
    middle, force = found["middle"], np.array(shear or [0.0, 0.0, 0.0]) - [0.0, 0.0, 1.0]
    for push in np.array(found["pushes"]):
        assert np.allclose(push / np.linalg.norm(push), force / np.linalg.norm(force), atol=1e-3)
    for tip in found["tips"]:
        assert np.hypot(tip["x"] - middle["x"], tip["y"] - middle["y"]) < 3.0  # px
    [label] = found["labels"]
    across = label["x"] <= middle["x"] <= label["x"] + label["width"]
    assert not (across and label["y"] <= middle["y"] <= label["y"] + label["height"])


FOUR = [(-9.0, 2.0), (13.0, 5.0), (0.0, 13.0), (4.0, -12.0)]  # mm
EIGHT = [*FOUR, (-2.0, 3.0), (6.0, 4.0), (-5.0, -7.0), (12.0, -6.0)]
TOUCHES = """(places) => {
  const { scene } = skinfield;
  const touches = places.map(([x, y], i) => ({ patch: 0, x: 1e-3 * x, y: 1e-3 * y,
    position: [1e-3 * x, 1e-3 * y, 0], normal: [0, 0, 1], force: 1 + 0.1 * i }));
  scene.marks.contacts = touches.map((each, i) => ({ ...each, key: `c${i}`, track: 100 + i,
    force_std: 0.6, area: 20e-6, place_cov: [3e-7 * (1 + i % 3), 2e-7, 6e-7] }));
  scene.marks.truth = touches.map((each, i) => ({ ...each, id: `p${i}`, contact_radius: 2.5e-3 }));
  scene.showLabels(true);
  scene.draw();
}"""


@pytest.mark.parametrize("places", [FOUR, EIGHT], ids=["four", "eight"])
@pytest.mark.parametrize(("width", "height"), [(1280, 720), (960, 700), (390, 844)])
def test_labels_cover_neither_each_other_nor_the_ellipse_of_a_place(
    page: Any, places: list[tuple[float, float]], width: int, height: int
) -> None:
    resize(page, {"width": width, "height": height})
    try:
        page.evaluate(TOUCHES, places)
        shown, covered = page.evaluate(LABELS)
        assert covered == []
        # a phone has no room for eight labels: the table tells the others
        assert (shown == len(places)) or (width < 480 and len(places) == 8 and shown >= 4)
    finally:
        page.evaluate("""() => { const { scene } = skinfield;
          scene.marks.contacts = scene.marks.truth = []; scene.showLabels(false); }""")
        resize(page, DESK)


def test_a_patch_without_reading_is_grey(page: Any) -> None:
    colours = colours_at(page, FLAT, 0.5, answer="missing")
    assert np.ptp(colours.astype(int), axis=1).max() < 40
    assert np.abs(colours - viridis(0.5)).max(axis=1).min() > 40


def test_raw_readings_are_dots_of_the_bars_colours(page: Any) -> None:
    spots = [(-CORNER, -CORNER), (CORNER, -CORNER), (-CORNER, CORNER)]
    colours = colours_at(page, spots, quantity="taxels")
    wanted = [SKIN["dark"], viridis(127 / 254), viridis(1.0)]
    assert np.abs(colours - wanted).max() <= 3


@pytest.mark.parametrize("quantity", ["pressure", "taxels"])
def test_a_dead_taxel_is_marked(page: Any, quantity: str) -> None:
    """In red, also where no other taxel is shown."""
    [colour] = colours_at(page, [(CORNER, CORNER)], quantity=quantity, dead=True)
    assert colour[0] > 200
    assert colour[1:].max() < 130
    [alive] = colours_at(page, [(CORNER, CORNER)], quantity=quantity)
    assert alive[0] < 120


def test_a_dead_taxel_is_a_cross_over_what_it_would_read(page: Any) -> None:
    spots = [(CORNER, CORNER), (CORNER + 0.9e-3, CORNER)]
    [middle, aside] = colours_at(page, spots, quantity="taxels", dead=True, repaired=127)
    assert middle[0] > 200
    assert np.abs(aside - viridis(127 / 254)).max() <= 3
    [_, unknown] = colours_at(page, spots, quantity="taxels", dead=True)
    assert np.abs(unknown - viridis(127 / 254)).max() > 40


def test_nothing_is_drawn_while_nothing_changes(page: Any) -> None:
    colours_at(page, FLAT)
    drawn = [page.evaluate(f"{FRAMES}.then(() => skinfield.scene.drawn)") for _ in range(30)]
    assert drawn[-1] == drawn[10]


def test_a_lost_picture_comes_back(page: Any) -> None:
    before = colours_at(page, [*FLAT, (1.0, 1.0)], 0.77)
    lose = "window.lost = skinfield.scene.picture.renderer.getContext()"
    page.evaluate(f"{lose}.getExtension('WEBGL_lose_context'), lost.loseContext()")
    is_lost = "skinfield.scene.picture.renderer.getContext().isContextLost()"
    for state in (True, False):
        for _ in range(200):
            if page.evaluate(is_lost) == state:
                break
            page.wait_for_timeout(50)
        if state:
            page.evaluate("lost.restoreContext()")
    for _ in range(200):
        after = colours_at(page, [*FLAT, (1.0, 1.0)], 0.77)
        if np.array_equal(after, before):
            break
        page.wait_for_timeout(50)
    assert np.array_equal(after, before)


def test_a_place_and_its_pixel_find_each_other(page: Any) -> None:
    """In the dent as well as beside it."""
    colours_at(page, FLAT)
    look = """(place) => {
      const scene = skinfield.scene, out = { position: [0, 0, 0], normal: [0, 0, 1] };
      scene.patches.at(0, place[0], place[1], out);
      const at = scene.project(out.position);
      return scene.pick(at.x, at.y).position;
    }"""
    for place in [(0.0, 0.0), (4e-3, -3e-3), (-0.02, 0.015)]:
        found = page.evaluate(look, place)
        assert np.allclose(found, [*place, 0.0], atol=2e-5)

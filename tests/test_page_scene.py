"""What the page's picture shows, pixel by pixel, of a skin made up here: no server is behind it."""

from collections.abc import Iterator
from importlib.resources import files
from typing import Any

import numpy as np
import pytest
from browser import DESK, running_browser

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
SHOW = """([count, pitch, high, value, answer, quantity, spots, dead]) => {
  const scene = window.skinfield.scene, k = count * count, middle = (count - 1) / 2;
  const height = Uint16Array.from({ length: k }, (_, i) => {
    const away = Math.hypot(i % count - middle, Math.floor(i / count) - middle) / count;
    return 65535 * Math.exp(-((away / 0.2) ** 4));
  });
  const colour = new Uint16Array(k).fill(65535 * value);
  scene.setQuantity(quantity);
  scene.setColours({ lo: 0, hi: high, map: "viridis" });
  scene.update({ quantity, range: [0, high], contacts: [], truth: [], patches: [{
    i: 0, answer, rung: count, height: 0, colour: 1, taxels: 2, height_scale: 1e-4 / 65535,
    colour_lo: 0, colour_hi: high }] },
    [height, colour, Uint8Array.from([0, 127, dead ? 255 : 0, 254])]);
  return spots.map(([x, y]) => {
    const out = { position: [0, 0, 0], normal: [0, 0, 1] };
    scene.patches.at(0, x, y, out);
    const at = scene.project(out.position);
    return scene.colourAt(at.x, at.y);
  });
}"""


@pytest.fixture(scope="module")
def page() -> Iterator[Any]:
    shipped = files("skinfield.page") / "static"
    with running_browser() as browser:
        page = browser.new_page(viewport=DESK)
        page.route("**/*", lambda route: _answer(route, shipped))
        page.goto(SITE)
        page.evaluate(BEGIN, [COUNT, PITCH])
        yield page


def _answer(route: Any, shipped: Any) -> None:
    name = route.request.url.removeprefix(SITE) or "index.html"
    part = shipped / name
    if part.is_file():
        route.fulfill(path=str(part))
    else:
        route.abort()


def _seen(
    page: Any,
    spots: list[tuple[float, float]],
    value: float = 0.0,
    answer: str = "searched",
    quantity: str = "pressure",
    dead: bool = False,
) -> np.ndarray:
    given = [COUNT, PITCH, HIGH, value, answer, quantity, spots, dead]
    return np.array(page.evaluate(SHOW, given))


def _viridis(value: float) -> np.ndarray:
    """The colour that matplotlib's own table gives."""
    colormaps = pytest.importorskip("matplotlib").colormaps
    return np.round(255 * np.array(colormaps["viridis"](value)[:3]))


# In the middles of cells: the lines between them are lighter
FLAT = [(-16.0 * PITCH, 1.0 * PITCH), (15.0 * PITCH, -14.0 * PITCH), (0.0, 0.0)]  # the bottom, too
CORNER = 0.8 * (COUNT - 1) / 2 * PITCH


@pytest.mark.parametrize("value", [0.0, 0.13, 0.5, 0.77, 1.0])
def test_the_skin_has_the_colours_of_the_bar(page: Any, value: float) -> None:
    """Flat skin and the bottom of a dent, between the lines of the grid, within rounding."""
    assert np.abs(_seen(page, FLAT, value) - _viridis(value)).max() <= 3


def test_a_patch_without_reading_is_grey(page: Any) -> None:
    colours = _seen(page, FLAT, 0.5, answer="missing")
    assert np.ptp(colours.astype(int), axis=1).max() < 40
    assert np.abs(colours - _viridis(0.5)).max(axis=1).min() > 40


def test_raw_readings_are_dots_of_the_bars_colours(page: Any) -> None:
    spots = [(-CORNER, -CORNER), (CORNER, -CORNER), (-CORNER, CORNER)]
    colours = _seen(page, spots, quantity="taxels")
    wanted = [_viridis(reading / 254) for reading in (0, 127, 254)]
    assert np.abs(colours - wanted).max() <= 3


@pytest.mark.parametrize("quantity", ["pressure", "taxels"])
def test_a_dead_taxel_is_marked(page: Any, quantity: str) -> None:
    """In red, also where no other taxel is shown."""
    [colour] = _seen(page, [(CORNER, CORNER)], quantity=quantity, dead=True)
    assert colour[0] > 200
    assert colour[1:].max() < 130
    [alive] = _seen(page, [(CORNER, CORNER)], quantity=quantity)
    assert alive[0] < 120


def test_nothing_is_drawn_while_nothing_changes(page: Any) -> None:
    _seen(page, FLAT)
    page.wait_for_timeout(300)
    before = page.evaluate("skinfield.scene.drawn")
    page.wait_for_timeout(400)
    assert page.evaluate("skinfield.scene.drawn") == before


def test_a_lost_picture_comes_back(page: Any) -> None:
    before = _seen(page, [*FLAT, (1.0, 1.0)], 0.77)
    lose = "window.lost = skinfield.scene.picture.renderer.getContext()"
    page.evaluate(f"{lose}.getExtension('WEBGL_lose_context'), lost.loseContext()")
    page.wait_for_timeout(200)
    page.evaluate("lost.restoreContext()")
    for _ in range(200):
        if not page.evaluate("skinfield.scene.picture.renderer.getContext().isContextLost()"):
            break
        page.wait_for_timeout(50)
    page.wait_for_timeout(200)
    assert np.array_equal(_seen(page, [*FLAT, (1.0, 1.0)], 0.77), before)


def test_a_place_and_its_pixel_find_each_other(page: Any) -> None:
    """In the dent as well as beside it."""
    _seen(page, FLAT)
    look = """(place) => {
      const scene = skinfield.scene, out = { position: [0, 0, 0], normal: [0, 0, 1] };
      scene.patches.at(0, place[0], place[1], out);
      const at = scene.project(out.position);
      return scene.pick(at.x, at.y).position;
    }"""
    for place in [(0.0, 0.0), (4e-3, -3e-3), (-0.02, 0.015)]:
        found = page.evaluate(look, place)
        assert np.allclose(found, [*place, 0.0], atol=2e-5)

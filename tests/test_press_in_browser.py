"""A skin to press in the documentation: its tables are the library's, its fit finds the press."""

import importlib.util
import json
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from browser import running_browser

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "docs" / "press"
PAGE = ROOT / "docs" / "tutorials" / "press-in-browser.md"
TRIES = """(seeds) => seeds.map((seed) => {
  const angle = 2.4 * seed, away = 20 * Math.sqrt((seed * 0.618) % 1);
  const [x, y] = [away * Math.cos(angle), away * Math.sin(angle)];
  const press = { x, y, force: 0.5 + ((seed * 0.37) % 2.5), tool: "ball 8 mm" };
  const found = PressedSkin.answer(PressedSkin.read([press], 0.002, seed), 0.002);
  return { press, found };
})"""


@pytest.fixture(scope="module")
def make_tables() -> ModuleType:
    spec = importlib.util.spec_from_file_location("make_tables", FOLDER / "make_tables.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """The page as the site shows it, without its surroundings."""
    raw = re.search(r"```\{raw\} html\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert raw is not None
    body = raw[1].replace("../_static/", FOLDER.as_uri() + "/")
    file = tmp_path_factory.mktemp("press") / "index.html"
    style = (FOLDER / "press.css").read_text(encoding="utf-8")
    head = f'<!doctype html><html lang="en"><meta charset="utf-8"><style>{style}</style>'
    file.write_text(f"{head}<body>{body}</body></html>", encoding="utf-8")
    with running_browser() as browser:
        page = browser.new_context(viewport={"width": 1000, "height": 640}).new_page()
        page.wrong = []
        page.on("pageerror", lambda error: page.wrong.append(str(error)))
        page.goto(file.as_uri() + "#noise=0.002&press=8.0,6.0,2.00,0")
        page.wait_for_selector("tr[data-force]")
        yield page


def test_tables_are_what_the_library_gives(make_tables: ModuleType) -> None:
    text = (FOLDER / "tables.js").read_text(encoding="utf-8")
    tables = json.loads(text.removeprefix("const SKINFIELD_TABLES = ").rstrip().rstrip(";"))
    np.testing.assert_allclose(
        tables["taxels"], make_tables.PATCH.positions[:, :2] * 1e3, atol=1e-3
    )
    np.testing.assert_allclose(tables["forces"], make_tables.FORCES, rtol=1e-4)
    force = float(make_tables.FORCES[6])
    pressed = make_tables.pressed(make_tables.TOOLS["ball 8 mm"], force)
    np.testing.assert_allclose(tables["tools"]["ball 8 mm"][6], pressed, atol=2e-4)
    h = make_tables.LAYER.thickness
    gap = make_tables.RoundGap.of(make_tables.PATCH.pad_diameter / h, make_tables.DISTANCES / h)
    names = ("readings", "pressure", "indentation")
    for name, unit, exact in zip(
        names, (1, 1e-3, 1e3), make_tables.fitted(6.75e-3, force, gap), strict=True
    ):
        np.testing.assert_allclose(
            tables[name][2][6], exact * unit, atol=6e-3 * np.max(exact) * unit
        )


def test_what_is_pressed_is_found(page: Any) -> None:
    tries = page.evaluate(TRIES, list(range(1, 41)))
    forces, places, held = [], [], []
    for one in tries:
        press = one["press"]
        near = min(
            one["found"],
            key=lambda c: np.hypot(c["x"] - press["x"], c["y"] - press["y"]),
            default=None,
        )
        if near is None:
            continue
        forces.append(abs(near["force"] / press["force"] - 1))
        places.append(np.hypot(near["x"] - press["x"], near["y"] - press["y"]))
        held.append(abs(near["force"] - press["force"]) < 1.645 * near["forceStd"])
    assert len(forces) >= 37
    assert 0.02 < np.median(forces) < 0.13
    assert 0.1 < np.median(places) < 0.7
    assert 0.75 < np.mean(held) < 0.99
    assert np.mean([len(one["found"]) for one in tries]) < 1.2


def test_it_is_pressed_by_mouse_and_keys_and_shared_by_its_link(page: Any) -> None:
    from playwright.sync_api import expect

    box = page.locator("canvas").bounding_box()
    row = page.locator("tr[data-force]")
    assert float(row.get_attribute("data-force")) == pytest.approx(2.0, rel=0.2)
    page.mouse.click(box["x"] + box["width"] * 0.6, box["y"] + box["height"] * 0.4)
    page.keyboard.press("ArrowLeft")
    expect(row.locator("td").nth(2)).to_have_text("5.4, 6.4")
    page.get_by_role("button", name="One more press").click()
    assert row.count() == 2
    link = page.evaluate("location.href")
    forces = [row.nth(index).get_attribute("data-force") for index in range(2)]
    again = page.context.new_page()
    again.goto(link)
    again.wait_for_selector("tr[data-force]")
    rows = again.locator("tr[data-force]")
    assert [
        float(rows.nth(index).get_attribute("data-force")) for index in range(2)
    ] == pytest.approx([float(force) for force in forces], rel=0.05)
    page.get_by_role("button", name="Lift").click()
    page.get_by_role("button", name="Lift").click()
    assert row.count() == 0
    assert "Click" in page.locator(".press-note").inner_text()
    assert not page.wrong


def test_a_link_that_is_none_shows_the_usual_press(page: Any) -> None:
    for text in ("#press=1,2", "#press=a,b,c,d", "#press=0,0,99,0", "#press=0,0,1,9", "#%%%"):
        assert page.evaluate("(text) => PressedSkin.fromLink(text)", text) is None

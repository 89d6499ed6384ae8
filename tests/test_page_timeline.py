"""Tools, keys and timeline of the page of a running skin, in a real browser; small windows."""

import csv
from pathlib import Path
from typing import Any

import pytest
from browser import STARTS, Look, Served, looking
from page_fixtures import *  # noqa: F403
from page_gestures import NEAR, Hand

# tools and keys


def test_common_tools_are_ready_and_others_say_how_far_they_are(look: Look, hand: Hand) -> None:
    ready = """(wanted) => skinfield.state.controls.tools.ready.some(
        ({ shape, radius }) => `${shape} ${radius}` === wanted)"""
    for tool in ("ball 0.005", "ball 0.01", "ball 0.02", "flat 0.003", "flat 0.006", "finger 0.01"):
        look.until(ready, tool, patience=STARTS)
    look.at("tool-finger-10").click()
    hand.click(2.0, 2.0)
    look.until("skinfield.state.truth.some((each) => each.shape === 'finger')")
    hand.lift()
    look.at("tool-ball-5").click()
    slider = look.at("radius-slider")
    assert [slider.get_attribute(name) for name in ("min", "max")] == ["0", "2"]
    slider.evaluate("(it) => { it.value = 2; it.dispatchEvent(new Event('input')); }")
    assert look.at("radius").input_value() == "20"
    look.at("radius").fill("7.7")  # that nobody has prepared, unless these tests ran here before
    look.at("radius").press("Tab")
    hand.click(2.0, 2.0)
    look.until("document.getElementById('tool-progress').hidden || /%/.test("
               "document.getElementById('tool-words').textContent)")  # fmt: skip
    look.until("skinfield.state.truth.some((each) => each.radius === 0.0077)", patience=STARTS)
    look.until("document.getElementById('tool-progress').hidden")
    look.until("document.getElementById('radius-slider').max === '3'")  # and it snaps to it
    look.at("tool-ball-10").click()


def test_keys_move_a_press_and_its_force(look: Look, hand: Hand) -> None:
    keyboard = look.page.keyboard
    keyboard.press("p")
    look.until("skinfield.state.truth.length === 1")
    camera = "skinfield.scene.view.camera.position.toArray()"
    first, view = look.value("skinfield.state.truth[0]"), look.value(camera)
    steps = {
        "ArrowRight": (1, 0),
        "Shift+ArrowUp": (0, 5),
        "ArrowLeft": (-1, 0),
        "ArrowDown": (0, -1),
    }
    x, y = first["x"], first["y"]
    there = """([x, y]) => { const [press] = skinfield.state.truth;
        return Math.hypot(press.x - x, press.y - y) < 3e-5; }"""
    for key, (right, up) in steps.items():
        keyboard.press(key)
        x, y = x + 1e-3 * right, y + 1e-3 * up
        look.until(there, [x, y])
    for key, force in (("+", 1.1), ("+", 1.2), ("-", 1.1)):
        keyboard.press(key)
        look.until("(force) => Math.abs(skinfield.state.truth[0].force - force) < 1e-6", force)
    assert look.value(camera) == view
    for _ in range(12):
        keyboard.press("Shift+ArrowRight")  # not beyond the skin's edge
    look.until("skinfield.state.truth[0].x > 0.0149")
    keyboard.press("Shift+ArrowUp")  # after all of them
    look.until("(y) => Math.abs(skinfield.state.truth[0].y - y) < 3e-5", y + 5e-3)
    assert look.value("skinfield.state.truth[0].x") < 0.025
    keyboard.press("Escape")
    look.until("skinfield.state.truth.length === 0")
    look.at("force").fill("1")
    look.at("force").press("Tab")


# looking back


LOOK_AT = (
    """(bar, s) => { bar.value = s; bar.dispatchEvent(new Event("input", { bubbles: true })); }"""
)


def test_the_newest_half_minute_is_looked_back_at(look: Look, hand: Hand) -> None:
    hand.click(4.0, 2.0)
    look.wait_rows(lambda rows: len(rows) == 1)
    assert look.at("total-force").inner_text().split()[0] != "0.00"
    pressed = look.value("skinfield.state.lastUpdate.stamp_ns")
    hand.lift()
    look.at("play").click()
    updates = look.value("skinfield.state.updates")
    ago = look.value("(then) => (skinfield.state.lastUpdate.stamp_ns - then) * 1e-9", pressed)
    look.at("time-bar").evaluate(LOOK_AT, 0.011 - ago)  # the bar has steps of 10 ms
    rows = look.wait_rows(lambda rows: len(rows) == 1)
    assert look.value("skinfield.state.lastUpdate.stamp_ns") <= pressed + 0.02e9
    total = float(look.at("total-force").inner_text().split()[0])
    assert total == pytest.approx(float(rows[0]["force"]), abs=0.0051)
    shown = look.value("skinfield.state.lastUpdate.number")
    look.at("step-back").click()
    assert look.value("skinfield.state.lastUpdate.number") < shown
    look.at("step-on").click()
    assert look.value("skinfield.state.lastUpdate.number") == shown
    look.until("(before) => skinfield.state.updates > before + 3", updates)  # they go on, unseen
    assert look.value("skinfield.state.lastUpdate.number") == shown
    look.shoot("looking-back", 300)
    assert look.accessible() == []
    with look.page.expect_download() as saved:
        look.at("export-csv").click()
    table = list(csv.DictReader(Path(saved.value.path()).read_text().splitlines()))
    stamps = [int(row["stamp_ns"]) for row in table]
    assert stamps == sorted(stamps)
    assert any(abs(float(row["x_m"]) - 4e-3) < 1e-3 * NEAR for row in table)
    with look.page.expect_download() as saved:
        look.at("export-png").click()
    assert Path(saved.value.path()).read_bytes().startswith(b"\x89PNG")
    look.at("back-to-live").click()
    look.until("(shown) => skinfield.state.lastUpdate.number > shown + 3", shown)
    look.wait_rows(lambda rows: not rows)
    look.page.keyboard.press(" ")
    hand.click(0.0, 3.0)  # what is pressed is to be seen
    look.wait_rows(lambda rows: len(rows) == 1)


def test_plots_tell_the_value_at_the_pointer(look: Look, hand: Hand) -> None:
    hand.click(0.0, 3.0)
    look.wait_rows(lambda rows: len(rows) == 1)
    before = look.value("skinfield.state.updates")
    look.until("(before) => skinfield.state.updates > before + 10", before)
    box = look.at("force-plot").bounding_box()
    look.page.mouse.move(box["x"] + box["width"] - 14, box["y"] + 40)
    look.until(r"/−?0\.\d s/.test(document.querySelector('#force-plot .plot-tip')?.textContent)")
    look.until(r"/truth 1\.00/.test(document.querySelector('#force-plot .plot-tip')?.textContent)")
    look.page.mouse.move(2, 2)
    look.until("!document.querySelector('.plot-tip')")


def test_axe_finds_nothing_wrong(look: Look, hand: Hand) -> None:
    assert look.accessible() == []
    hand.click(0.0, 3.0)
    look.wait_rows(lambda rows: len(rows) == 1)
    assert look.accessible() == []
    look.at("help").click()
    assert look.accessible() == []
    look.page.keyboard.press("Escape")


# small windows


IN_SIGHT = """() => {  // of the picture and of the force, while the panel's force is in the window
  const force = document.getElementById("force");
  force.scrollIntoView({ block: "end" });
  const inside = (name) => {
    const { top, bottom } = document.querySelector(name).getBoundingClientRect();
    return top >= -1 && bottom <= innerHeight + 1; };
  return ["#force", "#readout", "[data-testid=skin-canvas]"].map(inside);
}"""


@pytest.mark.parametrize(("width", "height"), [(390, 844), (853, 480), (960, 600)])
def test_the_result_is_in_sight_while_the_panel_presses(
    browser: Any, skin: Served, width: int, height: int
) -> None:
    """A phone, 1280 x 720 at 150 %, and a narrow window."""
    with looking(browser, size={"width": width, "height": height}, has_touch=width < 500) as look:
        look.open(skin.address)
        assert look.value(IN_SIGHT) == [True, True, True]
        asked = "tap" if width < 500 else "click"
        look.until("(word) => invitation.textContent.includes(word)", f" {asked} ")
        look.at("press-middle").click()
        look.until("skinfield.state.truth.length === 1")
        look.until("document.getElementById('readout-count').textContent === '1 contact'")
        wide = look.value("[document.documentElement.scrollWidth, window.innerWidth]")
        assert wide[0] <= wide[1] == width
        look.at("play").click()
        look.until("document.body.classList.contains('looking-back')")
        wide = look.value("[document.documentElement.scrollWidth, window.innerWidth]")
        assert wide[0] <= wide[1] == width
        box, bar = look.at("back-to-live").bounding_box(), look.at("time-bar").bounding_box()
        assert box["x"] + box["width"] <= width
        assert bar["width"] > 80
        look.shoot(f"pressing-{width}", 300)
        look.at("back-to-live").click()
        Hand(look).lift()
        assert look.wrong == []


def test_fingers_press_drag_and_pinch(browser: Any, skin: Served) -> None:
    with looking(browser, size={"width": 390, "height": 844}, has_touch=True) as look:
        look.open(skin.address)
        hand, talk = Hand(look), look.page.context.new_cdp_session(look.page)

        def touch(kind: str, *points: tuple[float, float]) -> None:
            there = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)]
            talk.send("Input.dispatchTouchEvent", {"type": f"touch{kind}", "touchPoints": there})

        look.page.touchscreen.tap(*hand.pixel(-8.0, 2.0))  # a tap stays
        look.until("skinfield.state.truth.length === 1")
        (x, y), (right, _) = hand.pixel(-8.0, 2.0), hand.pixel(4.0, 2.0)
        touch("Start", (x, y))  # and can be dragged
        for step in range(1, 9):
            touch("Move", (x + (right - x) * step / 8, y))
        touch("End")
        look.until("Math.abs(skinfield.state.truth[0].x - 0.004) < 1e-3")
        hand.lift()
        camera = "skinfield.scene.view.camera.position.toArray()"
        before = look.value(camera)
        touch("Start", (x, y))
        touch("Start", (x, y), (right, y))
        touch("Move", (x - 30, y), (right + 30, y))
        touch("End")
        moved = f"(before) => Math.hypot(...{camera}.map((v, i) => v - before[i])) > 1e-3"
        look.until(moved, before)
        look.until("skinfield.state.truth.length === 0")  # two fingers do not press
        assert look.value("[scrollY, visualViewport.scale]") == [0, 1]
        assert look.wrong == []

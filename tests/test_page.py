"""The page of a running skin, in a real browser: it shows, presses, changes and records."""

import math
import os
import signal
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import STARTS, Look, Served, looking
from page_fixtures import *  # noqa: F403
from page_gestures import NEAR, Hand

PLACES = [(0.0, 3.0), (-13.0, 6.0), (11.0, -8.0), (6.0, 14.0)]  # mm
MM, PERCENT = 2.0, 15.0  # what a press is found within


@pytest.fixture(scope="module")
def fitted(opened: Look) -> None:
    """An engine that answers by a fit of contacts."""
    hand = Hand(opened)
    hand.click(0.0, 0.0)
    fitted = "skinfield.state.contacts.some((each) => each.answer === 'contacts')"
    opened.until(fitted, patience=STARTS)
    hand.lift()


def is_found(row: dict[str, str]) -> bool:
    """Whether a contact is where the truth is, and as strong."""
    known = "truthForce" in row
    return known and float(row["errorMm"]) < MM and abs(float(row["errorPercent"])) < PERCENT


def distance(row: dict[str, str], x_mm: float, y_mm: float) -> float:
    return math.hypot(float(row["xMm"]) - x_mm, float(row["yMm"]) - y_mm)


# it is there, and it lives


def test_it_loads_and_goes_on(look: Look) -> None:
    before = look.value("skinfield.state.updates")
    look.until(f"skinfield.state.updates > {before + 5}")
    look.until("skinfield.state.status !== null")
    assert "skinfield" in look.page.title()
    look.until("['good', 'waiting'].includes(document.querySelector('#status-line').dataset.state)")
    assert look.value("document.querySelector('#mode').textContent") == "simulated"
    assert look.value("skinfield.state.hello.mode") == "live"
    assert look.rows() == []
    names = "resolution solver deadline quantity tare record contacts-table skin-canvas force-plot"
    for name in [*names.split(), "latency-plot"]:
        assert look.at(name).is_visible(), name
    look.shoot("rest", 300)


def test_the_latest_update_is_of_now(look: Look) -> None:
    age = look.value("skinfield.state.lastUpdate.age_s")
    assert 0.0 <= age < 5.0
    first = look.value("skinfield.state.lastUpdate.stamp_ns")
    look.until("(first) => skinfield.state.lastUpdate.stamp_ns > first", first)


# pressing it


def test_hold_and_drag_moves_it_and_lets_it_go(look: Look, hand: Hand) -> None:
    mouse = look.page.mouse
    mouse.move(*hand.pixel(-10.0, 0.0))
    mouse.down()
    look.wait_rows(lambda rows: any(distance(row, -10.0, 0.0) < NEAR for row in rows))
    for step in range(1, 11):
        mouse.move(*hand.pixel(-10.0 + 2.0 * step, 0.5 * step))
        look.page.wait_for_timeout(20)
    look.until("Math.abs(skinfield.state.truth[0].x - 0.010) < 3e-4")
    look.wait_rows(lambda rows: any(distance(row, 10.0, 5.0) < NEAR for row in rows))
    mouse.up()
    look.until("skinfield.state.truth.length === 0")
    look.wait_rows(lambda rows: not rows)


def test_the_tool_of_the_panel_is_used(look: Look, hand: Hand, skin: Served) -> None:
    look.at("shape").select_option("flat")
    look.at("radius").fill("6")
    look.at("force").fill("2")
    look.at("force").press("Tab")
    hand.click(2.0, 2.0)
    look.until("skinfield.state.truth.length === 1")
    truth = look.value("skinfield.state.truth[0]")
    assert (truth["shape"], truth["force"]) == ("flat", pytest.approx(2.0))
    assert truth["radius"] == pytest.approx(6e-3)
    presses = skin.ask("/api/truth")["presses"]
    assert [each["force"] for each in presses] == [pytest.approx(2.0)]
    look.wait_rows(lambda rows: len(rows) == 1 and distance(rows[0], 2.0, 2.0) < NEAR)
    look.at("lift").click()
    look.wait_rows(lambda rows: not rows)
    look.at("shape").select_option("ball")
    look.at("radius").fill("10")
    look.at("force").fill("1")
    look.at("force").press("Tab")


# its controls


def test_every_quantity_is_shown(look: Look, hand: Hand) -> None:
    hand.click(0.0, 3.0)
    look.until("skinfield.state.truth.length === 1")
    units = {"deformation": "m", "uncertainty": "Pa", "taxels": None, "pressure": "Pa"}
    for quantity, unit in units.items():
        look.at("quantity").select_option(quantity)
        look.until("(name) => skinfield.state.lastUpdate.quantity === name", quantity)
        if quantity != "taxels":
            assert look.value("skinfield.state.lastUpdate.unit") == unit
        look.until("skinfield.state.lastUpdate.range[1] > 0")
        look.draw()
        look.shoot(f"quantity-{quantity}", 200)


@pytest.mark.parametrize(
    ("control", "values", "key"),
    [
        ("resolution", ["10", "20", "auto"], "resolution"),
        ("deadline", ["250", "400"], "deadline_us"),
        ("smoothing", ["50", "0"], "smoothing_ms"),
        ("threshold", ["0.3", "0"], "threshold_N"),
    ],
)
def test_a_control_is_taken_over(
    look: Look, skin: Served, control: str, values: list[str], key: str
) -> None:
    for value in values:
        here = look.at(control)
        if here.evaluate("(it) => it.tagName") == "SELECT":
            here.select_option(value)
        else:
            here.fill(value)
            here.press("Enter")
        told = look.until(
            "([key, value]) => { const now = skinfield.state.controls[key].value;"
            " return String(now) === value || Math.abs(now - value) < 1e-6 }",
            [key, value],
        )
        assert told
        found = skin.ask("/api/status")["controls"][key]["value"]
        assert str(found) == value or float(found) == pytest.approx(float(value))


def test_a_lower_resolution_is_what_is_drawn(look: Look, hand: Hand) -> None:
    solver = look.value("skinfield.state.controls.solver.value")
    look.at("resolution").select_option("10")
    taken = "(name) => skinfield.state.controls.solver.value === name"
    look.at("solver").select_option("nonnegative")
    look.until(taken, "nonnegative", patience=STARTS)
    hand.click(0.0, 3.0)
    look.until("skinfield.state.lastUpdate.patches.some((each) => each.rung === 10)")
    look.at("resolution").select_option("auto")
    look.until("skinfield.state.lastUpdate.patches.some((each) => each.rung > 10)")
    look.at("solver").select_option(solver)
    look.until(taken, solver, patience=STARTS)


def test_a_threshold_hides_what_is_weaker(look: Look, hand: Hand) -> None:
    hand.click(4.0, 0.0)
    look.wait_rows(lambda rows: len(rows) == 1)
    look.at("threshold").fill("3")
    look.at("threshold").press("Enter")
    look.wait_rows(lambda rows: not rows)
    look.at("threshold").fill("0")
    look.at("threshold").press("Enter")
    look.wait_rows(lambda rows: len(rows) == 1)


def test_a_focus_window_is_drawn_and_cleared(look: Look, hand: Hand) -> None:
    mouse = look.page.mouse
    look.at("focus").click()
    mouse.move(*hand.pixel(-8.0, -6.0))
    mouse.down()
    mouse.move(*hand.pixel(0.0, 0.0))
    mouse.move(*hand.pixel(10.0, 8.0))
    mouse.up()
    window = look.until("skinfield.state.controls.focus")
    assert window["patch"] in (0, "hexagon72")
    corners = [1e3 * each for each in (*window["low"], *window["high"])]
    assert corners == pytest.approx([-8.0, -6.0, 10.0, 8.0], abs=0.7)
    look.at("focus-clear").click()
    look.until("skinfield.state.controls.focus === null")
    assert look.value("skinfield.state.truth.length") == 0  # drawing is no pressing


def test_exaggeration_deepens_the_dent(look: Look, hand: Hand) -> None:
    hand.click(0.0, 3.0)
    look.wait_rows(lambda rows: len(rows) == 1)
    for value in ("0", "1.7", "1"):
        look.at("exaggeration").fill(value)
        expected = 10 ** float(value)
        shown = look.value("skinfield.scene.patches.exaggeration")
        assert shown == pytest.approx(expected, rel=1e-6)


RING_AND_TIP = """() => {
  const { scene } = skinfield, { arrows, lines } = scene.marks, ring = [];
  for (let at = 0; at < 13 * lines.count; at += 13)  // the press that is known is dashed
    if (lines.data[at + 12] > 0) ring.push(scene.project(lines.data.slice(at, at + 3)));
  const { x, y } = scene.project(arrows.data.slice(3, 6));
  const mean = (name) => ring.reduce((sum, each) => sum + each[name], 0) / ring.length;
  const wide = Math.max(...ring.map((each) => each.x)) - Math.min(...ring.map((each) => each.x));
  return wide > 10 && { tip: [x, y], middle: [mean("x"), mean("y")], wide };  // px
}"""


def test_an_arrow_ends_in_the_middle_of_its_ring(look: Look, hand: Hand) -> None:
    hand.click(-6.0, 3.0)
    look.wait_rows(lambda rows: len(rows) == 1)
    found = look.until(RING_AND_TIP)
    assert math.dist(found["tip"], found["middle"]) < 3.0
    look.shoot("arrow")


TOLD = """() => {  // of each contact: in the table, and on its label in the picture
  const rows = document.querySelectorAll('[data-testid="contacts-table"] tbody tr[data-track]');
  const labels = [...skinfield.scene.marks.labels.shown].filter(([key]) => key.startsWith("c"));
  return {
    table: [...rows].map((row) => row.cells[3].textContent).sort(),
    picture: labels.map(([, label]) => label.written.split(" N")[0]).sort(),
  };
}"""


def test_label_and_table_tell_the_same_number(look: Look, hand: Hand) -> None:
    hand.click(-6.0, 3.0)
    hand.shift_click(9.0, -4.0)
    look.wait_rows(lambda rows: len(rows) == 2)
    told = []
    for _ in range(8):
        look.until("(n) => skinfield.state.updates > n", look.value("skinfield.state.updates"))
        for _ in range(3):
            found = look.value(TOLD)
            assert found["table"] == found["picture"]
            told += found["table"]
            look.page.wait_for_timeout(25)
    assert told


def test_dark_and_light(look: Look, hand: Hand) -> None:
    hand.click(0.0, 3.0)
    look.wait_rows(lambda rows: len(rows) == 1)
    seen = set()
    for _ in range(2):
        look.at("theme").click()
        look.draw()
        name = look.value("document.documentElement.dataset.theme")
        seen.add(name)
        look.shoot(str(name), 500)
    assert seen == {"dark", "light"}


def test_a_press_that_is_pushed_along_the_skin_leans(look: Look, hand: Hand) -> None:
    hand.click(0.0, 3.0)
    look.wait_rows(lambda rows: len(rows) == 1)
    mouse, keys = look.page.mouse, look.page.keyboard
    keys.down("Alt")
    mouse.move(*hand.pixel(0.0, 3.0))
    mouse.down()
    for x in range(1, 13):
        mouse.move(*hand.pixel(float(x), 3.0))
        look.page.wait_for_timeout(30)
    mouse.up()
    keys.up("Alt")
    look.until("skinfield.state.truth[0]?.shear?.size > 0.49", patience=STARTS)  # it is solved
    assert look.value("skinfield.state.truth[0].shear.angle") == pytest.approx(0.0, abs=0.02)
    assert look.value("skinfield.state.truth[0].y") == pytest.approx(3e-3, abs=2e-4)
    [row] = look.wait_rows(lambda rows: len(rows) == 1 and "shear" in rows[0])
    assert float(row["truthShear"]) == pytest.approx(0.5, abs=0.02)
    look.wait_rows(lambda rows: len(rows) == 1 and 0.3 < float(rows[0].get("shear", 0)) < 0.7)
    look.draw()
    look.shoot("pushed")
    push = look.value("""(() => { const { data } = skinfield.scene.marks.arrows;
      return [0, 1, 2].map((a) => data[3 + a] - data[a]); })()""")  # the truth is drawn first
    assert push[0] / -push[2] == pytest.approx(0.5, abs=0.03)


# shapes

SHAPE = """() => {  // of the strongest contact: its area and the middle of its outline, mm
  const [image] = skinfield.state.lastUpdate.shapes?.images ?? [];
  if (!image || image.readings < 12) return null;
  const { pose: [x, y, turn], outline: [line] } = image, [c, s] = [Math.cos(turn), Math.sin(turn)];
  const middle = [0, 1].map((a) => line.reduce((sum, at) => sum + at[a], 0) / line.length);
  const pen = document.getElementById("shape-canvas").getContext("2d");
  const { data } = pen.getImageData(0, 0, 300, 150);
  return { area: 1e6 * image.area, force: image.force, drawn: new Set(data).size,
    at: [1e3 * (x + c * middle[0] - s * middle[1]), 1e3 * (y + s * middle[0] + c * middle[1])] };
}"""


def test_the_shape_of_a_letter_grows_as_one_draws_with_it(look: Look, hand: Hand) -> None:
    look.at("tool-T-8").click()
    look.at("force").fill("5")
    look.at("force").press("Tab")
    look.until("skinfield.state.controls.tools.ready.some(({ shape }) => shape === 'T')")
    look.at("show-shapes").check()
    assert look.at("shape-inset").is_visible()
    look.until("skinfield.state.lastUpdate.shapes?.why === ''", patience=STARTS)  # it compiles
    mouse, way = look.page.mouse, [0.3 * k for k in range(21)]  # rad
    path = [hand.pixel(3.0 * math.sin(each), 3.0 * math.cos(each)) for each in way]
    mouse.move(*path[0])
    mouse.down()
    for place in path * 3:
        mouse.move(*place)
        look.page.wait_for_timeout(60)
    found = look.until(SHAPE)
    look.shoot("shape")
    assert 60.0 < found["area"] < 190.0  # of 96 mm²
    assert 3.0 < found["force"] < 8.0
    assert math.dist(found["at"], (0.0, 3.0)) < 6.0
    assert found["drawn"] > 20
    mouse.up()
    look.until("skinfield.state.lastUpdate.shapes.images.length === 0")
    assert look.accessible() == []
    look.at("show-shapes").uncheck()
    look.until("!skinfield.state.lastUpdate.shapes")
    assert not look.at("shape-inset").is_visible()
    look.at("tool-ball-10").click()
    look.at("force").fill("1")
    look.at("force").press("Tab")


# keys, and for all


def test_keys_do_what_the_help_says(look: Look) -> None:
    page = look.page
    page.locator("body").click(position={"x": 5, "y": 5})
    for key, quantity in zip(
        "2341", ("deformation", "uncertainty", "taxels", "pressure"), strict=True
    ):
        page.keyboard.press(key)
        look.until("(name) => skinfield.state.lastUpdate.quantity === name", quantity)
    before = look.value("skinfield.scene.view.camera.position.toArray()")
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("+")
    after = look.value("skinfield.scene.view.camera.position.toArray()")
    assert math.dist(before, after) > 1e-4
    page.keyboard.press("Home")
    home = look.value("skinfield.scene.view.camera.position.toArray()")
    assert math.dist(before, home) < 1e-6
    page.keyboard.press("p")  # without any pointer
    look.wait_rows(lambda rows: len(rows) == 1)
    page.keyboard.press("Escape")
    look.wait_rows(lambda rows: not rows)
    page.keyboard.press("?")
    look.until("document.querySelector('dialog').open")
    page.keyboard.press("Escape")
    look.until("!document.querySelector('dialog').open")


UNNAMED = """() => [...document.querySelectorAll('input, select, button, canvas, dialog')]
  .filter((each) => !each.parentElement.closest('[role=img]'))
  .filter((each) => !(each.labels?.length || each.getAttribute('aria-label')
    || each.getAttribute('aria-labelledby') || each.textContent.trim()))
  .map((each) => each.outerHTML.slice(0, 80))"""


def test_everything_has_a_name_and_the_table_says_what_it_is(look: Look) -> None:
    assert look.value(UNNAMED) == []
    assert look.value("document.documentElement.lang") == "en"
    table = look.at("contacts-table")
    assert "Contacts" in table.locator("caption").inner_text()
    assert table.locator("thead th[scope=col]").count() >= 5
    assert look.value("document.querySelectorAll('h1').length") == 1
    order = []
    for _ in range(40):  # all can be reached by keyboard
        look.page.keyboard.press("Tab")
        order.append(look.value("document.activeElement.dataset.testid ?? ''"))
    assert {"quantity", "skin-canvas", "resolution", "tare", "record"} <= set(order)


# other sizes


SIZES = {"tablet-landscape": (1024, 768), "tablet-portrait": (768, 1024), "small": (1280, 720)}


def test_it_fits_a_tablet(browser: Any, skin: Served) -> None:
    with looking(browser, has_touch=True) as look:
        look.open(skin.address)
        for name, (width, height) in SIZES.items():
            look.page.set_viewport_size({"width": width, "height": height})
            look.draw()
            wide = look.value("[document.documentElement.scrollWidth, window.innerWidth]")
            assert wide[0] <= wide[1] == width
            canvas = look.at("skin-canvas").bounding_box()
            assert canvas["width"] > 300
            assert canvas["height"] > 250
            x, y = canvas["x"] + canvas["width"] / 2, canvas["y"] + canvas["height"] / 2
            look.page.touchscreen.tap(x, y)
            look.wait_rows(lambda rows: any("truthForce" in row for row in rows))
            look.shoot(name, 700)
            Hand(look).lift()
        assert look.wrong == []


# recording, and looking at it again


DENTED = """([x, y]) => {  // the skin in the picture, where it is pressed
  const there = { position: [0, 0, 0], normal: [0, 0, 1] };
  skinfield.scene.patches.at(0, x, y, there);
  return there.position[2] < -1e-4;
}"""


@pytest.mark.usefixtures("fitted")
def test_what_is_recorded_can_be_looked_at_again(look: Look, hand: Hand) -> None:
    hand.click(4.0, 7.0)
    look.wait_rows(lambda rows: len(rows) == 1 and is_found(rows[0]))
    look.at("record").click()
    look.until(
        "skinfield.state.controls.recording && skinfield.state.controls.recording.cycles > 150"
    )
    look.wait_rows(lambda rows: len(rows) == 1 and is_found(rows[0]))  # it is in the recording
    look.at("record").click()
    look.until("skinfield.state.controls.recording === null")
    hand.lift()  # only now: however long the end took, it pressed all the time
    name = look.until("skinfield.state.hello.recordings[0]")
    look.at("recordings").select_option(name)
    look.until("skinfield.state.hello.mode === 'replay'")
    end = look.value("skinfield.state.hello.replay.end_s")
    assert end > 1.0
    look.until("skinfield.state.lastUpdate && skinfield.state.lastUpdate.time_s >= 0")
    look.stand_still()
    for part in (0.6, *np.linspace(0.02, 0.98, 49)):
        look.seek(part * end)
        rows = look.wait_rows(lambda rows: True)
        near = len(rows) == 1 and distance(rows[0], 4.0, 7.0) < MM
        if near and abs(float(rows[0]["force"]) - 1.0) < 1e-2 * PERCENT:
            break
    else:
        raise AssertionError(f"the contact is at no time as it was: {rows}")
    look.seek(0.6 * end)
    stands = look.value("skinfield.state.lastUpdate.time_s")
    assert look.at("tare").is_disabled()
    look.until(DENTED, [4e-3, 7e-3])
    look.shoot("replay")
    look.page.keyboard.press("Space")
    look.until("(then) => skinfield.state.lastUpdate.time_s > then + 0.2", stands)
    look.at("back-to-live").click()
    look.until("skinfield.state.hello.mode === 'live' && skinfield.state.lastUpdate")
    hand.click(3.0, 3.0)
    look.wait_rows(lambda rows: len(rows) == 1)


# as good as it gets: by a fit of contacts


@pytest.mark.usefixtures("fitted")
@pytest.mark.parametrize(("x_mm", "y_mm"), PLACES)
def test_a_click_presses_and_the_contact_is_found(
    look: Look, hand: Hand, x_mm: float, y_mm: float
) -> None:
    hand.click(x_mm, y_mm)
    rows = look.wait_rows(lambda rows: len(rows) == 1 and is_found(rows[0]))
    row = rows[0]
    assert distance(row, x_mm, y_mm) < MM + 0.2  # and not only beside what the page calls truth
    assert float(row["truthXMm"]) == pytest.approx(x_mm, abs=0.2)
    assert float(row["truthYMm"]) == pytest.approx(y_mm, abs=0.2)
    assert float(row["truthForce"]) == pytest.approx(1.0)
    assert row["track"] in row["text"]
    if (x_mm, y_mm) == PLACES[0]:
        look.shoot("one-press", 1500)  # for the plots
    hand.lift()


@pytest.mark.usefixtures("fitted")
def test_shift_presses_three_at_once(look: Look, hand: Hand) -> None:
    places = [(-14.0, -4.0), (13.0, -2.0), (0.0, 13.0)]
    for place in places:
        hand.shift_click(*place)
    rows = look.wait_rows(lambda rows: len(rows) == 3 and all(is_found(row) for row in rows))
    for place in places:
        assert min(distance(row, *place) for row in rows) < MM + 0.2
    assert len({row["track"] for row in rows}) == 3
    look.shoot("three-presses", 1500)
    hand.click(0.0, 0.0)  # without Shift: instead of them
    look.wait_rows(lambda rows: len(rows) == 1 and distance(rows[0], 0.0, 0.0) < MM)
    hand.lift()


@pytest.mark.usefixtures("fitted")
def test_every_solver_can_be_taken(look: Look, hand: Hand) -> None:
    options = look.value("skinfield.state.controls.solver.options")
    assert len(options) > 2
    for name in [*options[1:3], options[0]]:
        look.at("solver").select_option(name)
        look.until(
            "(name) => skinfield.state.controls.solver.value === name"
            " && !skinfield.state.controls.busy",
            name,
        )
    hand.click(0.0, 3.0)
    look.wait_rows(lambda rows: len(rows) == 1 and is_found(rows[0]))


@pytest.mark.usefixtures("fitted")
def test_tare_takes_a_new_baseline(look: Look, hand: Hand) -> None:
    look.at("tare").click()
    look.until("!document.querySelector('[data-testid=tare]').hasAttribute('aria-busy')")
    hand.click(0.0, 3.0)
    look.wait_rows(lambda rows: len(rows) == 1 and is_found(rows[0]))


def test_a_first_visit_is_invited_to_press(browser: Any, skin: Served) -> None:
    with looking(browser) as look:
        look.open(skin.address)
        look.until("!document.querySelector('#invitation').hidden")
        assert look.value("document.querySelector('#mode').textContent") == "simulated"
        groups = look.value(
            "[...document.querySelectorAll('#solver optgroup')].map((g) => g.label)"
        )
        assert groups == ["Use", "Study"]
        look.shoot("first-visit", 500)
        Hand(look).click(0.0, 3.0)
        look.until("document.querySelector('#invitation').hidden")
        look.page.reload()
        look.until("skinfield.state.status !== null")
        assert look.value("document.querySelector('#invitation').hidden")  # of this browser's first
        assert look.wrong == []


def test_a_contact_tells_how_old_its_reading_is(look: Look, hand: Hand, skin: Served) -> None:
    hand.click(0.0, 3.0)
    look.wait_rows(lambda rows: len(rows) == 1 and float(rows[0]["ageMs"]) < 500.0)
    track = look.rows()[0]["track"]
    boards = children_of(skin.process.pid, "skinfield.emulator")
    assert len(boards) == 1
    os.kill(boards[0], signal.SIGSTOP)  # a pause of readings
    try:
        (row,) = look.wait_rows(lambda rows: len(rows) == 1 and float(rows[0]["ageMs"]) > 600.0)
        assert row["track"] == track
        look.until("document.querySelectorAll('tr.old').length === 1")
        assert "last seen" in look.page.locator("#contacts-seen").inner_text()
        look.until("document.querySelector('#scene').dataset.fade === '1.00'")
        look.until("/^No reading for /.test(document.querySelector('.status-text').textContent)")
        look.shoot("pause")
    finally:
        os.kill(boards[0], signal.SIGCONT)
    look.wait_rows(lambda rows: len(rows) == 1 and float(rows[0]["ageMs"]) < 500.0)


def children_of(pid: int, module: str) -> list[int]:
    """Processes that another one has started, which run a module."""
    found = []
    for folder in Path("/proc").iterdir():
        if not folder.name.isdecimal():
            continue
        with suppress(OSError):
            words = (folder / "cmdline").read_bytes().decode().split("\0")
            parent = (folder / "stat").read_text().rpartition(")")[2].split()[1]
            if int(parent) == pid and module in words:
                found.append(int(folder.name))
    return found


def test_contacts_are_grey_once_the_engine_has_ended(look: Look, hand: Hand, skin: Served) -> None:
    hand.click(0.0, 3.0)
    look.wait_rows(lambda rows: len(rows) == 1)
    look.until("skinfield.state.contacts.every((each) => !each.old)")
    os.kill(skin.ask("/api/status")["engines"][0]["pid"], signal.SIGKILL)
    look.until("skinfield.state.contacts.length > 0 && skinfield.state.contacts[0].old")
    look.until("document.querySelectorAll('tr.old').length === 1")
    look.until("document.querySelector('#scene').dataset.fade === '1.00'")
    look.until("document.querySelector('#status-line').dataset.state === 'bad'")
    look.shoot("ended")
    skin.wait_running()
    look.until("skinfield.state.contacts.length > 0 && !skinfield.state.contacts[0].old")

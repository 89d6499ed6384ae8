"""The page's server: whom it answers, what it sends, and how it takes orders."""

import base64
import json
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from live_skins import wait_for
from numpy.testing import assert_allclose, assert_array_equal
from page_sources import NotingController, StillSource, unpacked
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

import skinfield as sf
from skinfield.errors import InputError
from skinfield.estimate.contact_table import COLUMNS
from skinfield.page.contact_shapes import NOT_HERE, follow
from skinfield.page.page_state import viewer_notes
from skinfield.page.scene_layout import PlacedPatch, SceneLayout
from skinfield.page.server import Page, serve_page
from skinfield.page.session import FULL, HUNG
from skinfield.page.settings import PageSettings
from skinfield.page.source import EngineView
from skinfield.page.updates import Updates
from skinfield.page.wire import packed, scaled
from skinfield.skin import Grid

LONG = 180.0  # s


@pytest.fixture(scope="module")
def source() -> StillSource:
    made = StillSource()
    made.read(1.0)
    return made


@pytest.fixture
def controller() -> NotingController:
    return NotingController()


@pytest.fixture
def page(source: StillSource, controller: NotingController) -> Iterator[Page]:
    with serve_page(PageSettings(port=0), lambda: (source,), controller) as served:
        wait_for(lambda: len(served.state.layout), LONG)
        yield served


def socket(page: Page, **more: Any) -> ClientConnection:
    token = f"?token={page.settings.token}" if page.settings.token else ""
    address = f"ws://127.0.0.1:{page.port}/socket{token}"
    return connect(address, max_size=None, **more)


def following(talk: ClientConnection, kind: str) -> dict[str, Any]:
    """Next text message of a kind."""
    return following_update(talk, kind)[0]


def following_update(
    talk: ClientConnection, kind: str = "update", condition: Any = lambda head: True
) -> tuple[dict[str, Any], Any]:
    """Next message of a kind, and its arrays; other updates are drawn at once."""
    end = time.monotonic() + LONG
    while time.monotonic() < end:
        message = talk.recv(LONG)
        head, arrays = (json.loads(message), []) if isinstance(message, str) else unpacked(message)
        if head["kind"] == kind and condition(head):
            return head, arrays
        if isinstance(message, bytes):
            talk.send(json.dumps({"do": "ack", "number": head.get("number")}))
    raise AssertionError(f"no {kind} came")


def with_truth(head: dict[str, Any]) -> bool:
    return bool(head["truth"])


def ask(talk: ClientConnection, **order: Any) -> dict[str, Any]:
    """Give an order; its answer. An update that comes meanwhile is drawn at once."""
    talk.send(json.dumps({**order, "tag": 7}))
    answer = following(talk, "answer")
    assert answer["tag"] == 7
    return answer


def get(page: Page, path: str, method: str = "GET", **headers: str) -> tuple[int, bytes, Any]:
    address = f"http://127.0.0.1:{page.port}{path}"
    body = None if method == "GET" else bytes(100_000)
    asked = urllib.request.Request(address, body, headers, method=method)
    try:
        with urllib.request.urlopen(asked, timeout=LONG) as answer:
            return answer.status, answer.read(), answer.headers
    except urllib.error.HTTPError as error:
        with error:
            return error.code, error.read(), error.headers


def test_one_port_serves_the_page_and_json(page: Page) -> None:
    status, text, headers = get(page, "/")
    assert (status, b"<!doctype html>") == (200, text[:15].lower())
    assert "default-src 'self'" in headers["Content-Security-Policy"]
    assert "unsafe" not in headers["Content-Security-Policy"]
    for name in ("app.js", "app.css", "licences.txt"):
        assert get(page, f"/{name}")[0] == 200
    found = json.loads(get(page, "/api/status")[1])
    assert found["mode"] == "live"
    assert [each["name"] for each in found["engines"]] == ["still"]
    contacts = json.loads(get(page, "/api/contacts")[1])["contacts"]
    assert [(each["patch"], each["shape"]) for each in contacts] == [("hexagon72", "sphere")]
    assert json.loads(get(page, "/api/truth")[1])["presses"][0]["force"] == 1.0
    status, text, _ = get(page, "/other")
    assert status == 404
    assert b"/api/status" in text
    for path in ("/../wire.py", "/page/app.js", "//etc/passwd"):
        assert get(page, path)[0] == 404


def test_other_methods_and_addresses_that_are_none_are_refused(page: Page) -> None:
    for method in ("POST", "PUT", "DELETE", "OPTIONS"):
        status, text, headers = get(page, "/api/status", method)
        assert (status, headers["Allow"]) == (405, "GET")
        assert b"expected GET" in text
    for path, host in (("//[", "localhost"), ("//[::1", "localhost"), ("/", "[")):
        status, text, _ = get(page, path, Host=host)
        assert status == 400
        assert b"expected one of this page" in text


def test_pages_and_names_elsewhere_are_refused(page: Page) -> None:
    assert get(page, "/api/status", Host="robot.example")[0] == 403
    assert get(page, "/api/status", Origin="http://elsewhere.example")[0] == 403
    here = f"http://127.0.0.1:{page.port}"
    assert get(page, "/api/status", Origin=here)[0] == 200
    with pytest.raises(InvalidStatus, match="403"):
        socket(page, origin="http://elsewhere.example")
    with pytest.raises(InvalidStatus, match="403"):
        socket(page, origin="null")
    with socket(page, origin=here) as talk:
        assert following(talk, "hello")["wire"] == 1


def test_a_token_is_asked_for_where_others_can_reach(source: StillSource) -> None:
    for host in ("0.0.0.0", "192.168.1.2", "robot.local", "::"):
        with pytest.raises(InputError, match="expected 8 or more"):
            PageSettings(host=host, token="short")
    assert PageSettings(host="::1").is_here
    settings = PageSettings(host="0.0.0.0", port=0, token="a-long-token")
    with serve_page(settings, lambda: (source,)) as page:
        assert page.address.endswith("/?token=a-long-token")
        assert get(page, "/")[0] == 200  # nothing of the skin is in it
        assert get(page, "/api/status")[0] == 401
        assert get(page, "/api/status?token=another-one")[0] == 401
        assert get(page, "/api/status?token=a-long-token", Host="robot.local")[0] == 200
        for wrong in ("", "?token=", "?token=a-long-tokenn"):
            with pytest.raises(InvalidStatus, match="401"):
                connect(f"ws://127.0.0.1:{page.port}/socket{wrong}")
        with socket(page) as talk:
            assert following(talk, "hello")["mode"] == "remote"


def test_a_taken_port_is_refused_or_another_found(
    page: Page, source: StillSource, monkeypatch: pytest.MonkeyPatch
) -> None:
    refused = pytest.raises(InputError, match=f"port {page.port} of 127.0.0.1 cannot be served")
    with refused, serve_page(PageSettings(port=page.port), lambda: (source,)):
        pass
    monkeypatch.setattr("skinfield.page.server.PORT", page.port)
    with serve_page(PageSettings(), lambda: (source,)) as second:
        assert second.port not in (0, page.port)


def test_an_update_is_the_estimate(page: Page, source: StillSource) -> None:
    snapshot = source.latest()
    assert snapshot is not None
    with socket(page) as talk:
        patches = following(talk, "hello")["patches"]
        assert [(each["i"], each["name"], each["taxels"]) for each in patches] == [
            (0, "hexagon72", 72)
        ]
        geometry, places = following_update(talk, "geometry")
        head, arrays = following_update(talk)
        talk.send(json.dumps({"do": "ack", "number": head["number"]}))
        told, _ = following_update(talk, condition=with_truth)
    grid = snapshot["hexagon72"].grid
    assert (geometry["rows"], geometry["columns"]) == grid.shape
    plane = places[2].reshape(-1, 2)
    assert_allclose(plane, grid.plane, atol=1e-8)
    row = head["patches"][0]
    pressure = row["colour_lo"] + arrays[row["colour"]] / 65535 * (
        row["colour_hi"] - row["colour_lo"]
    )
    expected = snapshot["hexagon72"].pressure
    assert_allclose(pressure, expected, atol=expected.max() / 65535)
    assert row["answer"] == "contacts"
    contact, found = head["contacts"][0], snapshot.contacts[0]
    assert contact["force"] == found["normal_force"]
    apart = np.subtract(contact["position"], told["truth"][0]["position"])
    assert np.linalg.norm(apart) < 2e-3  # in one picture, whatever its frame


def test_an_update_has_the_rows_of_the_table_of_contacts(page: Page, source: StillSource) -> None:
    source.read(1.2)
    with socket(page) as talk:
        columns = following(talk, "hello")["columns"].split(",")
        assert columns == [*COLUMNS, "track", "patch"]
        head, _ = following_update(talk, condition=lambda head: len(head["contacts"]) == 1)
    (line,), (contact,) = head["rows"], head["contacts"]
    row = dict(zip(columns, line.split(","), strict=True))
    assert int(row["stamp_ns"]) == head["stamp_ns"]
    assert float(row["force_N"]) == pytest.approx(contact["force"], rel=1e-6)
    assert float(row["x_m"]) == pytest.approx(contact["x"], abs=1e-7)
    assert (int(row["track"]), row["patch"]) == (contact["track"], "hexagon72")


@pytest.mark.parametrize(("relative", "unit"), [(False, "Pa"), (True, "relative")])
def test_an_update_says_whether_forces_are_newtons(relative: bool, unit: str) -> None:
    source = StillSource(relative=relative)
    source.read(1.0)
    updates = Updates(SceneLayout((source,)))
    *_, message = updates.make(1, [EngineView(source.latest())], ())
    head, _ = unpacked(message)
    assert (head["relative"], head["unit"]) == (relative, unit)
    snapshot = source.latest()
    assert snapshot is not None
    assert snapshot["hexagon72"].relative is relative


@pytest.mark.parametrize(("std", "sure"), [(0.05, True), (0.4, False), (np.nan, False)])
def test_a_force_along_the_skin_is_told_where_it_is_beyond_its_noise(
    std: float, sure: bool
) -> None:
    source = StillSource()
    source.read(1.0)
    snapshot = source.latest()
    assert snapshot is not None
    snapshot.contacts["shear"] = (0.3, -0.4, 0.0)
    snapshot.contacts["shear_covariance"] = (std**2, 0.0, std**2)
    truth = {"id": "a", "patch": "hexagon72", "x": 0.0, "y": 0.0, "force": 1.0, "shape": "ball",
             "radius": 6e-3, "contact_radius": 2e-3, "shear": [0.0, 0.5]}  # fmt: skip
    *_, message = Updates(SceneLayout((source,))).make(1, [EngineView(snapshot)], [truth])
    head, _ = unpacked(message)
    [contact], [press] = head["contacts"], head["truth"]
    assert_allclose(press["shear"]["vector"], [0.0, 0.5, 0.0], atol=1e-9)
    if not sure:
        assert contact["shear"] is None
        return
    assert_allclose(contact["shear"]["vector"], [0.3, -0.4, 0.0], atol=1e-9)
    told = [contact["shear"][name] for name in ("size", "std", "angle")]
    assert_allclose(told, [0.5, std, np.arctan2(-0.4, 0.3)])


def test_the_shape_of_what_touches_is_told_for_the_page() -> None:
    """As a process beside the engine writes it, of readings of a ball, and as an update has it."""
    source = StillSource()

    class Known:
        skin, tares, model_config, models = source.skin, 0, source.model_config, source._models

        def __iter__(self) -> Iterator[Any]:
            for force in (None, 1.0, 1.0, 1.0, None, None):
                source.read(force)
                yield source.latest()

    written: list[Any] = []
    follow(Known(), written.append)  # type: ignore[arg-type]
    assert [len(each["shapes"]) for each in json.loads(json.dumps(written))] == [0, 1, 1, 1, 0]
    [image] = written[3]["shapes"]
    assert (image["patch"], image["readings"]) == ("hexagon72", 3)
    assert image["force"] == pytest.approx(1.0, rel=0.2)
    pressure = np.frombuffer(base64.b64decode(image["pressure"]), np.uint8)
    total = pressure.sum() / 255.0 * image["peak"] * image["cell"] ** 2
    assert total == pytest.approx(image["force"], rel=0.05)
    row, column = np.divmod(int(pressure.argmax()), image["columns"])
    middle = np.add(image["low"], np.multiply(image["cell"], (column, row)))  # in the body's frame
    assert_allclose(middle + image["pose"][:2], [0.0, 7.5e-3], atol=2e-3)
    process: Any = SimpleNamespace(newest=lambda: [image], ready=True)
    for shapes, why in (([process], ""), ([None], NOT_HERE)):
        views = [EngineView(source.latest())]
        *_, message = Updates(SceneLayout((source,))).make(1, views, (), shapes=shapes)
        told = unpacked(message)[0]["shapes"]
        assert (told["why"], len(told["images"])) == (why, 1 - bool(why))
        assert all(each["patch"] == 0 for each in told["images"])


def test_a_letter_has_its_border_in_the_truth(source: StillSource) -> None:
    truth = {"id": "a", "patch": "hexagon72", "x": 0.0, "y": 0.0, "force": 1.0, "shape": "L",
             "radius": 8e-3, "contact_radius": 5e-3}  # fmt: skip
    *_, message = Updates(SceneLayout((source,))).make(1, [EngineView(None)], [truth])
    x, y = np.array(unpacked(message)[0]["truth"][0]["border"]).T
    area = 0.5 * abs(x[:-1] @ y[1:] - x[1:] @ y[:-1])
    assert area == pytest.approx(96e-6)  # 12 mm by 16 mm, strokes of 4 mm


def test_contacts_outlast_a_pause_of_readings_and_say_how_old_they_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    source, clock = StillSource(), Clock(monkeypatch)
    updates = Updates(SceneLayout((source,)))

    def told(old: bool = False, lives: bool = True) -> dict[str, Any]:
        view = EngineView(source.latest(), old, lives)
        return unpacked(updates.make(1, [view], ())[-1])[0]

    source.read(1.0)
    (first,) = told()["contacts"]
    assert first["seen_s"] < LONG  # of this machine, however busy
    clock.now += 0.3
    (later,) = told()["contacts"]
    assert later["seen_s"] - first["seen_s"] == pytest.approx(0.3)
    assert later["seen_ms"] == first["seen_ms"] == source.latest().stamp_ns / 1e6  # type: ignore[union-attr]
    source.miss()  # the engine has dropped what is too old
    clock.now += 0.3
    head = told()
    (kept,) = head["contacts"]
    assert (kept["track"], kept["force"]) == (first["track"], first["force"])
    assert kept["seen_s"] - first["seen_s"] == pytest.approx(0.6)
    assert kept["old"]
    assert head["patches"] == []  # its field stays, and fades
    assert told(old=True)["old"]
    clock.now += 5.0
    head = told()
    assert head["contacts"] == []
    assert head["patches"][0]["answer"] == "missing"


def test_a_lift_is_shown_at_the_first_reading_without_it() -> None:
    source = StillSource()
    updates = Updates(SceneLayout((source,)))
    for force, count in ((1.0, 1), (None, 0)):
        source.read(force)
        head = unpacked(updates.make(1, [EngineView(source.latest(), False, True)], ())[-1])[0]
        assert len(head["contacts"]) == count


def test_a_recording_does_not_age(monkeypatch: pytest.MonkeyPatch) -> None:
    source, clock = StillSource(), Clock(monkeypatch)
    source.read(1.0)
    updates, ages = Updates(SceneLayout((source,))), []
    for _ in range(2):
        head = unpacked(updates.make(1, [EngineView(source.latest())], ())[-1])[0]
        ages.append((head["contacts"][0]["seen_s"], head["contacts"][0]["old"]))
        clock.now += 60.0
    assert ages[0] == ages[1]
    assert not ages[0][1]


class Clock:
    """What `time.monotonic` of the page says, on top of what it is."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        begin = self.now = time.monotonic()
        monkeypatch.setattr("skinfield.page.source.time", self)
        monkeypatch.setattr("skinfield.page.updates.time", self)
        assert begin

    def monotonic(self) -> float:
        return self.now


def test_the_seventeenth_browser_is_told_why(page: Page, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("skinfield.page.server.CLIENTS", 1)
    with socket(page) as first:
        following(first, "hello")
        with socket(page) as second, pytest.raises(ConnectionClosed) as refused:
            second.recv(LONG)
        end = refused.value.rcvd
        assert end is not None
        assert end.code == FULL
        assert "browsers look on already" in end.reason
    wait_for(lambda: not page.state.sessions, LONG)
    with socket(page) as third:
        following(third, "hello")


def test_a_browser_that_draws_nothing_loses_its_place(
    page: Page, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("skinfield.page.session.SILENT", 0.2)
    with socket(page) as talk:
        following(talk, "hello")
        with pytest.raises(ConnectionClosed) as ended:
            list(iter(lambda: talk.recv(LONG), None))  # and no word about any of it
    end = ended.value.rcvd
    assert end is not None
    assert end.code == HUNG
    assert "nothing was drawn" in end.reason
    wait_for(lambda: not page.state.sessions, LONG)


def test_notes_are_those_that_a_viewer_can_act_on() -> None:
    now = time.time_ns()
    tare = [
        "hand: in 100 readings the taxels change too rarely to tell a dead one from a quiet one",
        "hand: gain not given: -342 counts per unit of ΔC/C₀ is a guess",
    ]
    events = [
        [now - 10**12, "failed", "ended with status 1"],
        [now, "failed", "ended with signal SIGKILL"],
    ]
    status = {
        "patches": [{"name": "hand"}],
        "notes": {
            "tare": [*tare, "the baseline stays as it was: it was touched"],
            "readings": {"hand": ["calibrate"]},
            "granted": {"refused": ["no real-time priority"]},
        },
        "beside": {"supervisor": {"events": [*events, [now, "started", "process 1"]]}},
        "lately": {"late": 0, "cycles": 1000},
    }
    ended = "the engine ended with signal SIGKILL"
    stays = "the baseline stays as it was: it was touched"
    assert viewer_notes(status, simulated=True) == [ended, "hand: calibrate", stays]
    assert viewer_notes(status, simulated=False) == [ended, "hand: calibrate", tare[1], stays]
    status["lately"] = {"late": 300, "cycles": 1000}
    assert viewer_notes(status, simulated=True)[-1] == "no real-time priority"
    [searches] = viewer_notes({"notes": {"searching": {"palm": 4}}}, simulated=True)
    assert "palm" in searches
    assert viewer_notes({"notes": ["it is gone"]}, simulated=False) == ["it is gone"]
    assert viewer_notes({"state": "running"}, simulated=False) == []


def test_one_update_is_in_flight_and_the_newest_wins(page: Page, source: StillSource) -> None:
    with socket(page) as talk:
        following(talk, "controls")
        head, _ = following_update(talk)
        for _ in range(2):
            source.read(1.0)
        page_number = source.latest().number  # type: ignore[union-attr]
        for _ in range(2):  # before the first is drawn only the status comes
            assert isinstance(talk.recv(LONG), str)
        talk.send(json.dumps({"do": "ack", "number": head["number"] + 5}))  # of none that was sent
        talk.send(json.dumps({"do": "ack", "number": head["number"]}))
        assert following_update(talk)[0]["cycle"] == page_number


def test_each_browser_chooses_what_it_sees(page: Page, source: StillSource) -> None:
    snapshot = source.latest()
    snapshot.prepare()
    with socket(page) as one, socket(page) as other:
        assert ask(one, do="show", quantity="deformation")["ok"]
        head, arrays = following_update(one, condition=lambda head: head["unit"] == "m")
        row = head["patches"][0]
        heights = (arrays[row["height"]] - float(row["height_zero"])) * row["height_scale"]
        inwards = snapshot["hexagon72"].indentation
        step = float(np.ptp(inwards)) / 65535
        assert_allclose(heights, inwards, atol=step)
        assert inwards.min() < -1e-2 * inwards.max()  # it swells around the dent
        colours = arrays[row["colour"]] / 65535 * row["colour_hi"]
        assert_allclose(colours, np.maximum(inwards, 0), atol=step)
        assert following_update(other)[0]["quantity"] == "pressure"


def test_orders_reach_the_controller_or_are_refused_in_words(
    page: Page, controller: NotingController
) -> None:
    with socket(page) as talk:
        head, _ = following_update(talk, condition=with_truth)
        place = head["truth"][0]["position"]
        press = {"do": "press", "id": "a", "patch": 0, "position": place}
        said = ask(talk, **press, force=1.0, radius=6e-3, shape="ball")
        assert said["ok"]
        assert_allclose((said["x"], said["y"]), (0.0, 7.5e-3), atol=1e-8)
        done = controller.orders[0][1]
        assert done.patch == "hexagon72"
        assert done.id.endswith("-a")
        assert "2 N at most" in ask(talk, **press, force=3.0)["error"]
        assert ask(talk, do="set", what="threshold_N", value=0.2)["ok"]
        window = {"patch": 0, "low": [0.0, 0.0], "high": [0.01, 0.01]}
        assert ask(talk, do="set", what="focus", value=window)["ok"]
        assert controller.orders[-1] == ("focus", window | {"patch": "hexagon72"})
        for wrong, words in (
            (press | {"position": [0.0, 1e400, 0.0]}, "three numbers"),
            (press | {"position": [0.0, True, 0.0]}, "three numbers"),
            (press | {"patch": 1}, "expected 0 to 0"),
            (press | {"force": "1"}, "newtons"),
            ({"do": "set", "what": "focus", "value": 3}, "expected patch, low and high"),
            ({"do": "dance"}, "expected one of"),
            ({"do": "replay", "what": "seek", "value": 1}, "open one first"),
            ({"do": "tare"}, "only looks on"),
            ({"do": "show", "quantity": "smell"}, "expected one of pressure"),
        ):
            said = ask(talk, **wrong)
            assert not said["ok"]
            assert words in said["error"]
        for nonsense in ("[]", "{", "7", '{"do": 3}', "[" * 5000):
            talk.send(nonsense)
            assert "not understood" in following(talk, "notice")["text"]
        assert ask(talk, do="hello")["ok"]


def test_a_part_that_fails_is_told_and_presses_go_with_their_browser(
    page: Page, controller: NotingController
) -> None:
    with socket(page) as talk:
        assert "OSError: no room" in ask(talk, do="record", on=True)["error"]
        assert ask(talk, do="hello")["ok"]  # the page goes on
    wait_for(lambda: controller.left, LONG)
    assert controller.left[0].endswith("-")


def test_browsers_learn_of_another_skin(source: StillSource) -> None:
    second = StillSource("second")
    second.read()
    sources: list[StillSource] = [source]
    with serve_page(PageSettings(port=0), lambda: tuple(sources)) as page, socket(page) as talk:
        while len(following(talk, "hello")["patches"]) != 1:
            pass
        sources.append(second)
        told = following(talk, "hello")["patches"]
        assert [each["engine"] for each in told] == ["still", "second"]
        first, _ = following_update(talk, "geometry")
        head, _ = following_update(talk, "geometry")
        assert [first["patch"], head["patch"]] == [0, 1]
        places = page.state.layout.placed
        apart = places[1].pose[:3, 3] - places[0].pose[:3, 3]
        assert np.linalg.norm(apart) > 0.05  # side by side
        sources.pop()
        assert len(following(talk, "hello")["patches"]) == 1


PATCHES = {
    "flat": sf.layouts.hexagon72,
    "cylinder": lambda: sf.layouts.cylinder(radius=30e-3),
    "cap": lambda: sf.layouts.sphere_cap(radius=40e-3),
}


@given(
    st.lists(
        st.sampled_from(["<u1", "<u2", "<u4", "<f4"]).flatmap(
            lambda kind: arrays(kind, st.integers(0, 9))
        ),
        max_size=5,
    ),
    st.text(max_size=9),
)
def test_a_message_is_what_its_bytes_say(given_arrays, name) -> None:
    message = packed({"kind": name}, [(name, each) for each in given_arrays])
    head, found = unpacked(message)
    assert head["kind"] == name
    for before, after in zip(given_arrays, found, strict=True):
        assert_array_equal(before, after)


def test_sixteen_bits_keep_a_field() -> None:
    values = np.array([0.0, 1.0, 2.0, np.nan, 9.0, -1.0])
    assert scaled(values, 0.0, 2.0).tolist() == [0, 32768, 65535, 0, 65535, 0]
    assert scaled(values, 1.0, 1.0).tolist() == [0] * 6


@pytest.mark.parametrize("kind", PATCHES)
def test_a_place_of_the_picture_is_one_of_the_plane(kind) -> None:
    patch = PATCHES[kind]()
    pose = np.eye(4)
    pose[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    pose[:3, 3] = 0.1, -0.2, 0.3
    placed = PlacedPatch(None, 0, patch, pose)  # type: ignore[arg-type]
    grid = Grid.square(patch, 23)  # none of its nodes is one of the fine grid's, but the corners
    for node in np.flatnonzero(grid.covered)[::17]:
        shown = placed.in_scene(grid.positions[node][None])[0]
        x, y = placed.plane_of(shown)
        assert_allclose((x, y), grid.plane[node], atol=2e-5)

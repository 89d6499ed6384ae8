"""The page of recordings, and who may open it: in a real browser, and by hand."""

import asyncio
import json
import signal
import struct
import sys
import time
from collections.abc import Coroutine, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any, TypeVar
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import pytest
from browser import ENDS, PATIENCE, Look, Served, looking, pictures, running_browser, served
from live_skins import unique_name, wait_for
from page_gestures import Hand
from replay_sample import PERIOD, Known, write

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")
T = TypeVar("T")
TOKEN = "a-long-enough-secret"
CYCLES = 400
SECOND = 1_000_000_000


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("view")


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
def browser() -> Iterator[Any]:
    with running_browser() as running:
        yield running


@pytest.fixture
def look(browser: Any, view: Served) -> Iterator[Look]:
    with looking(browser) as opened:
        opened.open(view.address)
        yield opened
        assert opened.wrong == []
        assert opened.value("skinfield.state.malformed") == 0


def seek(look: Look, t_s: float) -> None:
    look.at("time-bar").evaluate(
        """(bar, t) => { bar.value = t; bar.dispatchEvent(new Event('input', { bubbles: true }));
        bar.dispatchEvent(new Event('change', { bubbles: true })); }""",
        t_s,
    )
    look.until("(t) => Math.abs(skinfield.state.lastUpdate.time_s - t) < 0.021", t_s)


def one_within(low: float, high: float, rows: list[dict[str, str]]) -> bool:
    """Whether there is one contact with a force between these."""
    return len(rows) == 1 and low < float(rows[0]["force"]) < high


# a recording


def test_a_recording_is_shown_as_it_was(look: Look, made: list[Known], tmp_path: Path) -> None:
    assert look.value("skinfield.state.hello.mode") == "replay"
    assert look.value("skinfield.state.hello.replay.end_s") == pytest.approx((CYCLES - 1) * 0.01)
    if look.value("skinfield.state.controls.replay.playing"):
        look.at("play").click()
        look.until("!skinfield.state.controls.replay.playing")
    for place in (112, 180, 262):
        seek(look, place * PERIOD / SECOND)
        # the bar has steps, and a cycle lasts 10 ms: it is one of the nearest
        near = [made[place + off].force for off in (-2, -1, 0, 1, 2)]
        look.wait_rows(partial(one_within, min(near) - 5e-3, max(near) + 5e-3))
    look.shoot(pictures(tmp_path), "view")
    assert look.at("tare").is_disabled()
    assert look.at("record").is_disabled()


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


def test_several_browsers_play_it_together(browser: Any, view: Served, look: Look) -> None:
    with looking(browser) as other:
        other.open(view.address)
        seek(look, 1.5)
        other.until("Math.abs(skinfield.state.lastUpdate.time_s - 1.5) < 0.03")
        assert other.wrong == []


# who may


def status_of(address: str, **headers: str) -> int:
    try:
        with urlopen(Request(address, headers=headers), timeout=PATIENCE) as answer:
            return int(answer.status)
    except HTTPError as error:
        error.close()
        return error.code


def test_without_the_token_nothing_is_told(view: Served) -> None:
    plain = f"http://127.0.0.1:{view.port}"
    assert f"token={TOKEN}" in view.address
    for path in ("/api/status", "/api/contacts", "/api/truth"):
        assert status_of(plain + path) == 401
        assert status_of(plain + path + "?token=" + TOKEN[:-1]) == 401
        assert status_of(f"{plain}{path}?token={TOKEN}") == 200
    found = view.ask("/api/status")
    assert found["mode"] == "replay"
    assert found["engines"][0]["name"] == "touch.mcap"


def test_another_origin_is_refused(view: Served) -> None:
    there = f"http://127.0.0.1:{view.port}/api/status?token={TOKEN}"
    assert status_of(there, Origin="http://evil.example") == 403
    assert status_of(there, Origin=f"http://127.0.0.1:{view.port}") == 200


def apart(work: Coroutine[Any, Any, T]) -> T:
    """Run it in a thread: playwright has a loop in this one."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, work).result()


async def opens(address: str, **more: Any) -> int:
    """Status of the answer to a request for a websocket; 101: it can be used."""
    from websockets.asyncio.client import connect
    from websockets.exceptions import InvalidStatus

    try:
        async with connect(address, open_timeout=PATIENCE, **more) as socket:
            message = json.loads(await socket.recv())
            return 101 if message["kind"] == "hello" else 0
    except InvalidStatus as error:
        return error.response.status_code


def test_sockets_need_the_token_and_the_origin(view: Served) -> None:
    plain = f"ws://127.0.0.1:{view.port}/socket"
    right = f"{plain}?token={TOKEN}"
    assert apart(opens(plain)) == 401
    assert apart(opens(f"{plain}?token=wrong")) == 401
    assert apart(opens(right, origin="https://evil.example")) == 403
    assert apart(opens(right)) == 101
    assert apart(opens(right, origin=f"http://127.0.0.1:{view.port}")) == 101


def test_a_page_without_the_token_says_so(browser: Any, view: Served) -> None:
    with looking(browser) as look:
        look.page.goto(f"http://127.0.0.1:{view.port}/")
        look.until("!document.querySelector('#refused').hidden")
        assert "token" in look.page.locator("#refused").inner_text()


# a slow browser, an engine that dies, a curved skin


async def stalls(address: str, seconds: float) -> tuple[list[int], int]:
    """Numbers of the updates that come while none is acknowledged, and of the one after one is."""
    from websockets.asyncio.client import connect

    numbers: list[int] = []

    async def listen(socket: Any, until: float) -> None:
        while (left := until - time.monotonic()) > 0:
            try:
                message = await asyncio.wait_for(socket.recv(), left)
            except TimeoutError:
                return
            if isinstance(message, bytes):
                (size,) = struct.unpack_from("<I", message, 4)
                head = json.loads(message[8 : 8 + size])
                if head["kind"] == "update":
                    numbers.append(head["number"])

    async with connect(address) as socket:
        while not numbers:
            await listen(socket, time.monotonic() + 1.0)
        await listen(socket, time.monotonic() + seconds)
        unanswered = list(numbers)
        await socket.send(json.dumps({"do": "ack", "number": numbers[-1]}))
        while len(numbers) == len(unanswered):
            await listen(socket, time.monotonic() + 0.5)
        return unanswered, numbers[-1]


def test_one_update_is_in_flight_and_the_engine_goes_on(folder: Path, browser: Any) -> None:
    name = unique_name()
    words = ("run", "--name", name, "--skin", "cylinder", "--headless", "--scene", "idle",
             "--rate-hz", "200", "--priority", "0", "--no-fit")  # fmt: skip
    with served(*words, folder=folder) as running:
        running.wait_running()
        before = running.ask("/api/status")["engines"][0]["since_start"]["cycles"]
        address = running.address.replace("http", "ws") + "socket"
        unanswered, after = apart(stalls(address, 2.0))
        assert len(unanswered) == 1
        assert after > unanswered[0]
        status = running.ask("/api/status")["engines"][0]
        assert status["since_start"]["cycles"] - before > 100
        with looking(browser) as look:
            look.open(running.address)
            curved(look, folder)
            reconnects(look, running, words, folder)


def curved(look: Look, folder: Path) -> None:
    """A curved patch is pressed where one clicks."""
    assert look.value("skinfield.state.hello.patches[0].flat") is False
    hand = Hand(look)
    hand.click(3.0, 4.0)
    rows = look.wait_rows(lambda rows: len(rows) == 1)
    assert float(rows[0]["truthXMm"]) == pytest.approx(3.0, abs=0.2)
    assert float(rows[0]["truthYMm"]) == pytest.approx(4.0, abs=0.2)
    look.wait_rows(lambda rows: len(rows) == 1 and float(rows[0]["errorMm"]) < 3.0)
    look.page.wait_for_timeout(1000)
    look.shoot(pictures(folder), "curved")
    hand.lift()
    assert look.wrong == []


def reconnects(look: Look, running: Served, words: tuple[str, ...], folder: Path) -> None:
    """The page goes on by itself when its server is there again."""
    port = running.port
    running.kill()
    look.until("!skinfield.socket.open")
    look.until("document.querySelector('#status-line').textContent.includes('lost')")
    look.shoot(pictures(folder), "connection-lost")
    look.value("skinfield.state.lastUpdate = null")
    wait_for(lambda: not Path(f"/proc/{running.process.pid}").exists(), ENDS)
    with served(*words, folder=folder, port=port) as again:
        again.wait_running()
        look.until("skinfield.socket.open && skinfield.state.lastUpdate !== null")
        assert look.value("skinfield.state.connections") == 2
        look.until("skinfield.state.status.state === 'running'")
        Hand(look).click(0.0, 0.0)
        look.wait_rows(lambda rows: len(rows) == 1)


# the command


def test_it_ends_when_told_to(folder: Path, made: list[Known]) -> None:
    with served("view", "touch.mcap", folder=folder) as running:
        assert running.address.startswith("http://127.0.0.1:")
        running.process.send_signal(signal.SIGTERM)
        assert running.process.wait(ENDS) == 0

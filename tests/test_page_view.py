"""The page of recordings, and who may open it: in a real browser, and by hand."""

import signal
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any
from urllib.error import HTTPError
from urllib.request import urlopen

import pytest
from browser import ENDS, PATIENCE, Look, Served, looking, pictures, running_browser, served
from live_skins import unique_name
from page_gestures import Hand
from page_sources import StillSource
from replay_sample import PERIOD, Known, write

from skinfield.page import serve_page
from skinfield.settings import PageSettings

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")
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


@pytest.fixture(scope="module")
def opened(browser: Any, view: Served) -> Iterator[Look]:
    with looking(browser) as look:
        look.open(view.address)
        yield look


@pytest.fixture
def look(opened: Look) -> Iterator[Look]:
    yield opened
    assert opened.wrong == []
    assert opened.value("skinfield.state.malformed") == 0


def one_within(low: float, high: float, rows: list[dict[str, str]]) -> bool:
    """Whether there is one contact with a force between these."""
    return len(rows) == 1 and low < float(rows[0]["force"]) < high


# a recording


def test_a_recording_is_shown_as_it_was(look: Look, made: list[Known], tmp_path: Path) -> None:
    assert look.value("skinfield.state.hello.mode") == "replay"
    assert look.value("skinfield.state.hello.replay.end_s") == pytest.approx((CYCLES - 1) * 0.01)
    look.stand_still()
    for place in (112, 180, 262):
        look.seek(place * PERIOD / SECOND)
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
             "--grid", "20", "--rate-hz", "200", "--priority", "0", "--no-fit")  # fmt: skip
    with served(*words, folder=folder) as running:
        running.wait_running()
        with looking(browser) as look:
            look.open(running.address)
            curved(look, folder)
            reconnects(look, running, folder)


def curved(look: Look, folder: Path) -> None:
    """A curved patch is pressed where one clicks."""
    assert look.value("skinfield.state.hello.patches[0].flat") is False
    hand = Hand(look)
    hand.click(3.0, 4.0)
    rows = look.wait_rows(lambda rows: len(rows) == 1 and "truthXMm" in rows[0])
    assert float(rows[0]["truthXMm"]) == pytest.approx(3.0, abs=0.2)
    assert float(rows[0]["truthYMm"]) == pytest.approx(4.0, abs=0.2)
    look.wait_rows(lambda rows: len(rows) == 1 and float(rows[0]["errorMm"]) < 3.0)
    look.page.wait_for_timeout(1000)
    look.shoot(pictures(folder), "curved")
    hand.lift()
    assert look.wrong == []


def reconnects(look: Look, running: Served, folder: Path) -> None:
    """The page goes on by itself when a server is there again."""
    source, port = StillSource(), running.port
    source.read(1.0)
    running.kill()
    look.until("!skinfield.socket.open")
    look.until("document.querySelector('#status-line').textContent.includes('lost')")
    look.shoot(pictures(folder), "connection-lost")
    look.value("skinfield.state.lastUpdate = null")
    with serve_page(PageSettings(port=port), lambda: (source,)):
        look.until("skinfield.socket.open && skinfield.state.lastUpdate !== null")
        assert look.value("skinfield.state.connections") == 2
        look.until("skinfield.state.status.state === 'running'")
        look.wait_rows(lambda rows: len(rows) == 1)


# the command


def test_it_ends_when_told_to(folder: Path, made: list[Known]) -> None:
    with served("view", "touch.mcap", folder=folder) as running:
        assert running.address.startswith("http://127.0.0.1:")
        running.process.send_signal(signal.SIGTERM)
        assert running.process.wait(ENDS) == 0

"""Fixtures of tests of a running skin's page: one engine and one page for a module."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browser import Look, Served, looking, running_browser, served
from live_skins import unique_name
from page_gestures import Hand

__all__ = ["browser", "folder", "hand", "look", "opened", "pytestmark", "skin"]

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="rings are tested on Linux")
QUIET = ("--headless", "--scene", "idle", "--rate-hz", "100", "--priority", "0")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("page")


@pytest.fixture(scope="module")
def skin(folder: Path) -> Iterator[Served]:
    with served("run", "--name", unique_name(), *QUIET, folder=folder) as made:
        made.wait_running()
        yield made


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with running_browser() as made:
        yield made


@pytest.fixture(scope="module")
def opened(browser: Any, skin: Served) -> Iterator[Look]:
    with looking(browser) as look:
        look.open(skin.address)
        yield look


@pytest.fixture
def look(opened: Look, skin: Served) -> Iterator[Look]:
    """The page, untouched, without an error before and after."""
    yield opened
    back = opened.at("back-to-live")
    if back.is_visible():  # from a recording, or from looking back
        back.click()
        opened.until("skinfield.state.hello.mode === 'live' && skinfield.state.lastUpdate")
    opened.page.keyboard.press("Escape")
    opened.until("skinfield.state.truth.length + skinfield.state.contacts.length === 0")
    assert opened.wrong == [], "\n".join(skin.said)
    assert opened.value("skinfield.state.malformed") == []


@pytest.fixture
def hand(look: Look) -> Hand:
    return Hand(look)

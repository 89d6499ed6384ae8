"""What a skin that starts says it waits for, and how a start that fails ends."""

import io
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from types import SimpleNamespace

import pytest
from rich.console import Console

import skinfield as sf
from skinfield.cli import run as command
from skinfield.cli.settings import Settings
from skinfield.loop.status_text import preparing_of, start_in_words
from skinfield.loop.supervisor import EngineFailed

COMPILING = {"compiled": 0.4, "compile_left_s": 12.0}
PATCHES = {"phase": "loading", "progress": {"patches": 6, "of": 60, "left_s": 41.2}}


@pytest.mark.parametrize(
    ("notes", "words"),
    [
        ({"phase": "loading", "progress": {}}, "loading its code"),
        (
            {"phase": "loading", "progress": COMPILING},
            "compiling once for this machine, 12 s left",
        ),
        (PATCHES, "preparing patch 7 of 60, about 41 s more"),
        ({"phase": "preparing", "progress": {"patches": 0, "of": 2}}, "preparing patch 1 of 2"),
        ({"phase": "taring"}, "leave the skin untouched"),
    ],
)
def test_a_start_in_words(notes: dict, words: str) -> None:
    assert words in start_in_words(notes)


def test_a_bar_has_what_is_prepared() -> None:
    linear = {"phase": "running", "progress": {"patches": 0, "of": 1} | COMPILING}
    for notes in ({"phase": "loading", "progress": COMPILING}, linear):
        expected = {"what": "compiling", "done": 0.4, "seconds_left": 12.0}
        assert preparing_of(notes) == expected
    expected = {"what": "preparing", "done": 0.1, "seconds_left": 41.2}
    assert preparing_of(PATCHES) == expected
    for notes in ({"phase": "taring", "progress": {}}, {"phase": "running", "progress": {}}, {}):
        assert preparing_of(notes) is None


def test_nothing_is_said_of_a_skin_that_runs() -> None:
    assert start_in_words({"phase": "running", "progress": {}}) == ""
    assert start_in_words({}) == ""


def test_each_kind_of_patch_is_counted_while_an_engine_is_prepared() -> None:
    one, other = sf.layouts.hexagon72(), sf.layouts.rectangular(3, 3)
    skin = sf.Skin((one, other))
    calls: list[tuple[int, int]] = []
    layer = sf.Layer(thickness=2e-3, young_modulus=150e3, poisson_ratio=0.3)
    options = {"rungs": (8,), "solver": sf.NonNegative()}
    sf.Engine(skin, layer, progress=lambda *each: calls.append(each), **options)
    assert calls == [(0, 2), (1, 2)]


class Starting:
    """A supervisor whose engine says one thing after the other, an hour apart."""

    hopeless, failure = False, ""

    def __init__(self, words: list[str], clock: list[float], ends: bool) -> None:
        self.words, self.clock, self.ends = words, clock, ends

    def wait(self, timeout: float) -> io.StringIO:
        if self.ends and len(self.words) == 1:
            return io.StringIO()
        self.clock[0] += 0.9 * command.STARTS
        raise EngineFailed("not yet")

    def start_in_words(self) -> str:
        return self.words.pop(0) if len(self.words) > 1 else self.words[0]


def wait(monkeypatch: pytest.MonkeyPatch, words: list[str], ends: bool) -> str:
    clock, text = [0.0], io.StringIO()
    timer = SimpleNamespace(monotonic=lambda: clock[0], sleep=lambda seconds: None)
    monkeypatch.setattr(command, "time", timer)
    observer = SimpleNamespace(look=lambda: SimpleNamespace(sources={}))
    command._wait_running(
        Starting(words, clock, ends), observer, None, Console(file=text, width=200)
    )
    return text.getvalue()


def test_a_start_that_goes_on_is_waited_for_and_told(monkeypatch: pytest.MonkeyPatch) -> None:
    patches = [f"preparing patch {number} of 60" for number in range(1, 61)]
    linear = ["linear answers until contacts are ready: loading its code"]
    text = wait(monkeypatch, [*patches, *linear, ""], ends=True)
    assert "s: preparing patch 7 of 60" in text
    assert "s: linear answers until contacts are ready" in text


def test_a_start_without_progress_ends_and_says_what_it_did(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    words = ["loading", "preparing patch 7 of 60"]
    with pytest.raises(EngineFailed, match=r"without progress: preparing patch 7 of 60"):
        wait(monkeypatch, words, ends=False)


def test_the_page_is_open_before_a_recorder_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    events: list[str] = []

    def noted(what: str, **parts: object) -> Callable[..., object]:
        @contextmanager
        def part(*_: object, **__: object) -> Iterator[SimpleNamespace]:
            events.append(what)
            yield SimpleNamespace(**parts)

        return part

    supervised = noted("engine", wait=lambda *_: io.StringIO())
    monkeypatch.setattr(command, "loading_engine", noted("loading"))
    monkeypatch.setattr(command, "virtual_skin", noted("skin", channels=["127.0.0.1:40001"]))
    monkeypatch.setattr(command, "served_page", noted("page", address="http://here"))
    monkeypatch.setattr("skinfield.loop.supervisor.Supervisor", supervised)
    monkeypatch.setattr("skinfield.loop.client.Live", noted("ring"))
    monkeypatch.setattr("skinfield.record.launch.recorder", noted("recorder"))
    monkeypatch.setattr("skinfield.bridges.launch.bridges", noted("bridges"))
    with ExitStack() as parts:
        command.start_all(Settings(), parts, Console(file=io.StringIO()), events.append)
    order = ["loading", "skin", "engine", "ring", "page", "http://here", "recorder", "bridges"]
    assert events == order

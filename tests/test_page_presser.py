"""Presses from the page: what is refused, waits, or was let go leaves nothing behind."""

import pytest

from skinfield.errors import InputError
from skinfield.page.presser import MOST, Press, Presser


class Skin:
    """A virtual skin that refuses presses beyond 2 N, and keeps what presses."""

    def __init__(self) -> None:
        self.there: dict[str, float] = {}
        self.scenes: list[str] = []
        self.notes: list[str] = []
        self.waits: list[str] = []

    def ask(self, command):
        do, id = command["do"], command.get("id")
        if do == "press":
            if command["force"] > 2.0:
                raise InputError(f"force is {command['force']:g} N, expected 2 N at most")
            self.there[id] = command["force"]
        elif do == "release" and id is None:
            self.there.clear()
        elif do == "release" and self.there.pop(id, None) is None:
            raise InputError(f"id is {id!r}, expected that of a press by hand")
        elif do == "scene":
            self.scenes.append(command["scene"])
        presses = [{"id": id, "force": force} for id, force in self.there.items()]
        return {"lines": [{"presses": presses}], "waits": self.waits, "notes": list(self.notes)}


class Case:
    def __init__(self) -> None:
        self.skin, self.why, self.said = Skin(), "", []
        self.presser = Presser(self.skin, lambda: self.why, self.said.append)


@pytest.fixture
def case() -> Case:
    return Case()


def press(id: str, force: float | None = 1.0, radius: float | None = 5e-3) -> Press:
    return Press(id, "hexagon72", 0.0, 0.0, force, radius, "ball")


def test_a_refused_press_is_none(case) -> None:
    with pytest.raises(InputError, match="2 N at most"):
        case.presser.press(press("1-a", 3.0))
    with pytest.raises(InputError, match="expected its force and radius"):
        case.presser.press(press("1-a", None))
    assert case.presser.placed == 0
    case.presser.lift("1-a")
    assert case.presser.let_off(0.0)


def test_presses_wait_for_the_baseline(case) -> None:
    case.why = "the engine starts"
    case.presser.begin("press")
    assert case.presser.press(press("1-a"))["waits"] == "the engine starts"
    case.presser.press(press("1-b", 3.0))
    case.presser.press(press("1-c"))
    case.presser.lift("1-c")
    case.presser.do_waiting()
    assert case.skin.there == {}
    case.why = ""
    case.presser.do_waiting()
    assert case.skin.there == {"1-a": 1.0}
    assert case.skin.scenes == ["press", "idle"]
    assert "2 N at most" in case.said[0]
    assert case.presser.placed == 1
    case.presser.do_waiting()
    assert len(case.said) == 1


def test_what_the_skin_let_go_is_told_and_gone(case) -> None:
    case.presser.press(press("1-a"))
    case.skin.waits = ["1-a"]
    case.presser.truth()
    assert case.presser.preparing
    del case.skin.there["1-a"]
    case.skin.waits, case.skin.notes = [], ["press 1-a was let go: too hard"]
    assert case.presser.truth() == []
    case.presser.truth()
    assert case.said == ["a press was let go: too hard"]
    assert case.presser.placed == 0
    assert not case.presser.preparing


def test_presses_go_with_their_browser(case) -> None:
    for id in ("1-a", "1-b", "11-a"):
        case.presser.press(press(id))
    del case.skin.there["1-b"]  # let go, and not noted yet
    case.presser.leave("1-")
    assert case.skin.there == {"11-a": 1.0}
    assert case.presser.placed == 1
    case.presser.lift(None)
    assert case.skin.there == {}


def test_a_browser_cannot_press_without_end(case) -> None:
    for number in range(MOST):
        case.presser.press(press(f"1-{number}"))
    with pytest.raises(InputError, match="lift some"):
        case.presser.press(press("1-more"))
    case.presser.press(press("1-0", 0.5))  # but change what stands
    assert case.skin.there["1-0"] == 0.5


def test_a_scene_waits_and_lets_off(case) -> None:
    case.why = "a baseline is being taken"
    with pytest.raises(InputError, match="a baseline is being taken"):
        case.presser.scene("slide")
    case.presser.scene("idle")
    case.why = ""
    case.presser.scene("slide")
    case.skin.there["slide-0"] = 1.0
    assert not case.presser.let_off(0.1)
    case.skin.there.clear()
    assert case.presser.let_off(0.1)
    assert case.presser.playing == "idle"

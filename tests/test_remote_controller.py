"""A page of skins elsewhere is never empty without a word."""

from page_sources import StillSource

from skinfield.page.source import DataSource


class Found:
    def __init__(self) -> None:
        self.notes: dict[str, str] = {}
        self.shown: list[DataSource] = []

    def sources(self) -> list[DataSource]:
        return self.shown


def test_why_nothing_is_shown() -> None:
    from skinfield.cli.replay import NOBODY, RemoteController

    found = Found()
    controller = RemoteController(found)
    assert controller.notices() == []
    assert controller.controls()["busy"] == NOBODY
    found.notes = {"robot/arm": "it did not answer"}
    assert controller.notices() == [("warn", "robot/arm is not shown: it did not answer")]
    assert controller.notices() == []
    assert controller.controls()["busy"] == "robot/arm is not shown: it did not answer"
    found.notes = {"robot/arm": "it cannot be read"}
    controller.say("info", "something else")
    assert controller.notices() == [
        ("info", "something else"),
        ("warn", "robot/arm is not shown: it cannot be read"),
    ]
    found.notes, found.shown = {}, [StillSource()]
    assert controller.notices() == []
    assert controller.controls()["busy"] is None
    found.notes = {"robot/arm": "it cannot be read"}  # once more
    assert len(controller.notices()) == 1

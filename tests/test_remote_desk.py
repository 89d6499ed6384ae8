"""A page of skins elsewhere is never empty without a word."""

from page_feeds import StillFeed

from skinfield.viewer.feed import Feed


class Found:
    def __init__(self) -> None:
        self.notes: dict[str, str] = {}
        self.shown: list[Feed] = []

    def feeds(self) -> list[Feed]:
        return self.shown


def test_why_nothing_is_shown() -> None:
    from skinfield.cli.remote_desk import NOBODY, RemoteDesk

    found = Found()
    desk = RemoteDesk(found)
    assert desk.notices() == []
    assert desk.controls()["busy"] == NOBODY
    found.notes = {"robot/arm": "it did not answer"}
    assert desk.notices() == [("warn", "robot/arm is not shown: it did not answer")]
    assert desk.notices() == []
    assert desk.controls()["busy"] == "robot/arm is not shown: it did not answer"
    found.notes = {"robot/arm": "it cannot be read"}
    desk.say("info", "something else")
    assert desk.notices() == [
        ("info", "something else"),
        ("warn", "robot/arm is not shown: it cannot be read"),
    ]
    found.notes, found.shown = {}, [StillFeed()]
    assert desk.notices() == []
    assert desk.controls()["busy"] is None
    found.notes = {"robot/arm": "it cannot be read"}  # once more
    assert len(desk.notices()) == 1

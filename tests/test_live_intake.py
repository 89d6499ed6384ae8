"""Sources of an engine: what goes away and comes back is counted and told, once."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pytest
from live_skins import Ticking
from numpy.testing import assert_array_equal

from skinfield.loop.intake import Intake
from skinfield.signal import Blocks, Count, Kind, Port, blocks_of, counters

SECOND = 10**9


@dataclass(eq=False)
class Played:
    """A source that does at each poll what it is told: numbers of readings, or an exception."""

    script: list[object] = field(default_factory=list)
    opened: int = 0

    def open(self) -> "Played":
        self.opened += 1
        self.up, self.counters, self.index = True, counters(), 0
        self.ports: Sequence[Port] = (Port("port", 4),)
        return self

    def poll(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        what = self.script.pop(0) if self.script else 0
        if isinstance(what, Exception):
            raise what
        for _ in range(int(what)):  # type: ignore[call-overload]
            blocks.put(now_ns, channel, [1, 2, 3, 4], Kind.BYTES)
            self.counters[Count.RECEIVED] += 1
        return int(what)  # type: ignore[call-overload]

    def filenos(self) -> Sequence[int]:
        return ()

    def close(self) -> None:
        self.up = False


def told(intake: Intake) -> list[tuple[int, int]]:
    """Sources that went (0) or came (1) in the last poll."""
    found = blocks_of(intake.blocks.data)
    return [(b.channel, int(b.payload[0])) for b in found if b.kind == Kind.SOURCE]


def test_a_driver_that_raises_costs_itself_only() -> None:
    bad, good = Played([1, ValueError("oops"), 0, 1]), Played([1, 1, 1, 1])
    intake = Intake([bad, good])
    assert intake.poll(SECOND) == 2
    assert intake.poll(SECOND + 1) == 1
    assert told(intake) == [(0, 0)]
    assert intake.sentences() == ["Played: ValueError: oops"]
    assert not intake.members[0].up
    assert intake.poll(SECOND + 2) == 1  # too early to try again
    intake.poll(2 * SECOND)
    assert told(intake) == [(0, 1)]
    assert bad.opened == 2
    counted = intake.members[0].counters
    intake.poll(2 * SECOND + 1)
    assert counted[Count.REOPENED] == 1
    assert counted[Count.DOWN_NS] == SECOND - 1
    assert intake.sentences() == []


def test_boards_that_fall_silent_are_away_until_they_speak() -> None:
    intake = Intake([Played([0, 1, 0, 0, 0, 1, 1])])
    log = []
    for now in (0.5, 1.0, 1.9, 2.1, 4.0, 4.5, 4.6):
        intake.poll(int(now * SECOND))
        log.append(told(intake))
    assert log == [[], [], [], [(0, 0)], [], [(0, 1)], []]
    counted = intake.members[0].counters
    assert counted[Count.DOWN_NS] == 3.5 * SECOND
    assert counted[Count.REOPENED] == 1


def test_one_that_never_spoke_is_not_said_to_have_gone() -> None:
    intake = Intake([Played()])
    for now in range(1, 20):
        intake.poll(now * SECOND)
        assert told(intake) == []


def test_a_broken_wire_is_told_by_its_stream_alone() -> None:
    source = Played([1])
    intake = Intake([source])
    intake.poll(SECOND)
    source.up = False
    for now in range(2, 6):
        intake.poll(now * SECOND)
        assert told(intake) == []
    assert intake.members[0].counters[Count.DOWN_NS] == 0


def test_counts_go_on_from_those_of_an_engine_before() -> None:
    intake = Intake([Played([1, 1])])
    intake.poll(1)
    table = np.zeros((1, len(Count)), np.int64)
    table[0, Count.RECEIVED], table[0, Count.LOST] = 100, 7
    intake.count_in(table)
    intake.poll(2)
    assert table[0, Count.RECEIVED] == 102
    assert table[0, Count.LOST] == 7


def test_channels_of_several_sources_lie_one_after_the_other() -> None:
    intake = Intake([Played([1]), Ticking(3, period=0.0)])
    intake.poll(SECOND)
    assert_array_equal(intake.channels.counts[:4], [1, 2, 3, 4])
    assert np.isfinite(intake.channels.counts[4:]).all()
    assert len(intake.channels) == 7


class Awkward(Played):
    """A driver that raises not only where it is polled."""

    awkward = ""

    def __getattribute__(self, name: str) -> object:
        if name == object.__getattribute__(self, "awkward"):
            raise RuntimeError(f"no {name}")
        return super().__getattribute__(name)


@pytest.mark.parametrize("where", ["up", "ports"])
def test_wherever_a_driver_raises_it_costs_itself_only(where: str) -> None:
    bad, good = Awkward([1, 0, 0, 1]), Played([1] * 9)
    intake = Intake([bad, good])
    intake.poll(SECOND)
    bad.awkward = where
    if where == "ports":
        bad.script = [ValueError("oops")]
    for now in range(2, 6):
        assert intake.poll(now * SECOND) >= 1
    assert bad.opened > 1


def test_all_are_closed_though_one_cannot() -> None:
    bad, good = Awkward(), Played()
    intake = Intake([bad, good])
    bad.awkward = "close"
    intake.close()
    assert not good.up
    assert intake.members[0].failure == "when it was closed, RuntimeError: no close"
    intake.close()


def test_notes_that_cannot_be_read_are_told() -> None:
    source = Awkward([1])
    intake = Intake([source])
    source.awkward = "notes"
    assert intake.sentences() == ["Awkward: RuntimeError: no notes"]


def test_damaged_blocks_end_no_cycle() -> None:
    source = Played([1])
    intake = Intake([source])
    source.poll = lambda blocks, channel, now: blocks.put(now, 3, [1, 2], Kind.BYTES) or 1  # type: ignore[method-assign]
    assert intake.poll(SECOND) == 1
    assert intake.damaged > 0
    assert np.isnan(intake.channels.counts).all()

"""Boards of iCub and CySkin are told what to do, and told again when they forgot it."""

import time
from collections.abc import Iterator

import numpy as np
import pytest
from bus_peers import wait_for
from live_devices import CYSKIN_BOARDS, HEXAGON, CySkinBoard, ICubBoard

from skinfield.acquisition import Blocks, Channels, Count
from skinfield.errors import InputError
from skinfield.protocols.cyskin import CySkinWire, start_messages, stop_messages
from skinfield.protocols.icub import (
    BoardSettings,
    ICubConfiguration,
    configuration_for,
    load_configuration,
)
from skinfield.sources.buses import BusSettings
from skinfield.sources.live import CySkinCan, ICubCan
from skinfield.sources.live.board_care import AT_ONCE, CySkinCare, ICubCare

SECOND = 1_000_000_000
NOW = 1_700_000_000 * SECOND


class Wire:
    """A bus that notes what is sent, and takes as much as it is allowed to."""

    def __init__(self) -> None:
        self.sent: list[tuple[int, bytes]] = []
        self.room, self.up = 10**6, True

    def send(self, identifier: int, data: bytes) -> bool:
        if self.room <= 0:
            return False
        self.room -= 1
        self.sent.append((identifier, data))
        return True


def heard(care: ICubCare, now_ns: int, message_class: int = 4) -> None:
    from skinfield.acquisition import CanMessages

    rows = CanMessages(1)
    rows.ids[0], rows.stamp_ns[0] = message_class << 8 | 1 << 4, now_ns
    care.heard(rows, 1)


def attend(
    care: ICubCare, wire: Wire, start: int, seconds: float, *, sends: int = 0
) -> list[float]:
    """Attend every 10 ms; the seconds at which a board was told its settings (a 4D)."""
    told = []
    for step in range(round(100 * seconds)):
        now = start + step * SECOND // 100
        if sends:
            heard(care, now, sends)
        before = len(wire.sent)
        care.attend(wire, now)
        told += [step / 100 for _, data in wire.sent[before:] if data[0] == 0x4D]
    return told


@pytest.fixture
def care() -> ICubCare:
    return ICubCare(configuration_for(*HEXAGON), 0)


def test_first_everything_is_told_in_small_parts(care: ICubCare) -> None:
    wire, expected = Wire(), list(configuration_for(*HEXAGON).messages())
    care.begin(NOW)
    wire.room = 3
    care.attend(wire, NOW)
    assert wire.sent == expected[:3]
    wire.room = 10**6
    care.attend(wire, NOW)
    assert wire.sent == expected[: 3 + AT_ONCE]
    assert expected[-1] == (0x201, b"\x07\x00")


def test_a_board_that_sends_is_left_alone(care: ICubCare) -> None:
    wire = Wire()
    care.begin(NOW)
    assert attend(care, wire, NOW, 60.0, sends=4) == [0.0]
    assert care.told_again == 0


def test_boards_of_an_engine_before_are_told_only_if_they_are_silent(care: ICubCare) -> None:
    wire = Wire()
    care.begin(NOW)
    care.resume(NOW)
    assert attend(care, wire, NOW, 10.0, sends=4) == []
    care.resume(NOW + 10 * SECOND)
    assert 2.0 <= attend(care, wire, NOW + 10 * SECOND, 2.5)[0] <= 2.2


def test_a_silent_board_is_told_again_ever_more_rarely(care: ICubCare) -> None:
    wire = Wire()
    care.begin(NOW)
    told = attend(care, wire, NOW, 60.0)
    steps = np.diff(told)
    assert told[0] == 0.0
    assert 2.0 <= told[1] <= 2.2
    np.testing.assert_allclose(steps[1:], [1, 2, 4, 8, 10, 10, 10, 10], atol=0.11)
    assert attend(care, wire, NOW + 60 * SECOND, 5.0, sends=4) == []
    told = attend(care, wire, NOW + 65 * SECOND, 3.0)  # silent anew: soon again
    assert 2.0 <= told[0] <= 2.2


def test_a_board_that_nobody_configured_is_told(care: ICubCare) -> None:
    wire = Wire()
    care.begin(NOW)
    assert attend(care, wire, NOW, 2.0, sends=3) == [0.0]  # old firmware sends class 3 always
    assert attend(care, wire, NOW + 2 * SECOND, 2.0, sends=4) == []
    told = attend(care, wire, NOW + 4 * SECOND, 3.0, sends=3)  # it booted
    assert told[0] <= 0.1
    assert 0.9 <= told[1] - told[0] <= 1.1


def test_a_clock_that_is_set_back_does_not_silence_the_care(care: ICubCare) -> None:
    wire = Wire()
    care.begin(NOW)
    attend(care, wire, NOW, 0.3)
    assert attend(care, wire, NOW - 3600 * SECOND, 0.1) == []
    heard(care, NOW - 3600 * SECOND)
    assert attend(care, wire, NOW - 3600 * SECOND, 3.0)


def test_each_board_of_cyskin_is_started_again() -> None:
    wire, settings = Wire(), CySkinWire()
    care = CySkinCare(CYSKIN_BOARDS, settings, 20)
    care.begin(NOW)
    start = start_messages(CYSKIN_BOARDS, settings, period_ms=20)
    for step in range(20):
        care.attend(wire, NOW + step)
    assert wire.sent == start
    care.attend(wire, NOW + 3 * SECOND)
    care.attend(wire, NOW + 3 * SECOND + 1)
    assert wire.sent == start * 2
    care.stop(wire)
    assert wire.sent[2 * len(start) :] == stop_messages(CYSKIN_BOARDS, settings)


@pytest.fixture
def board() -> Iterator[ICubBoard]:
    device = ICubBoard()
    yield device
    device.close()


def poll_until(stream: object, condition: object, blocks: Blocks | None = None) -> None:
    blocks = blocks or Blocks()

    def polled() -> object:
        blocks.clear()
        stream.poll(blocks, 0, time.time_ns())  # type: ignore[attr-defined]
        return condition()  # type: ignore[operator]

    wait_for(polled)


def test_messages_over_a_bus_start_the_boards_and_stop_them(board: ICubBoard) -> None:
    stream = ICubCan(board.configuration, (board.settings,)).open()
    expected = list(board.configuration.messages())
    poll_until(stream, lambda: len(board.listen()) >= len(expected))
    assert board.told == expected
    board.send(3)
    poll_until(stream, lambda: stream.counters[Count.RECEIVED] == 12)
    stream.close()
    wait_for(lambda: len(board.listen()) > len(expected))
    assert board.told[len(expected) :] == [(0x201, b"\x07\x01")]


def test_boards_are_configured_anew_when_the_bus_comes_back(board: ICubBoard) -> None:
    stream = ICubCan(board.configuration, (board.settings,)).open()
    count = len(board.configuration.messages())
    poll_until(stream, lambda: len(board.listen()) >= count)
    board.unplug(stream)
    poll_until(stream, lambda: not stream.up)
    assert "closed" in stream.fault or "descriptor" in stream.fault
    board.plug()
    poll_until(stream, lambda: len(board.listen()) >= 2 * count)
    assert board.told[count : 2 * count] == board.told[:count]
    stream.close()


def test_who_only_listens_tells_nothing(board: ICubBoard) -> None:
    stream = ICubCan(board.configuration, (board.settings,), configure=False).open()
    poll_until(stream, lambda: stream.up)
    board.send()
    channels, blocks = Channels(192), Blocks()

    def came() -> bool:
        channels.apply(blocks)
        return bool(np.isfinite(channels.counts[:72]).all())

    poll_until(stream, came, blocks)
    assert (channels.counts[:72] == 1).all()
    assert np.isnan(channels.counts[72:]).all()
    stream.close()
    assert board.listen() == []


def test_two_buses_bring_one_port_each_its_boards() -> None:
    devices = ICubBoard(), ICubBoard()
    configuration = ICubConfiguration((BoardSettings(0, 1), BoardSettings(1, 1)), (0, 1), "arm")
    stream = ICubCan(configuration, tuple(each.settings for each in devices)).open()
    devices[0].send()
    devices[1].send()
    devices[1].send()
    channels, blocks = Channels(384), Blocks()

    def came() -> bool:
        channels.apply(blocks)
        return bool(np.isfinite(channels.counts[[0, 192]]).all())

    poll_until(stream, came, blocks)
    poll_until(stream, lambda: stream.counters[Count.RECEIVED] == 36)
    assert channels.counts[0] == 1
    assert stream.ports[0].channels == 384
    assert len(stream.filenos()) == 2
    stream.close()
    for each in devices:
        each.close()


def test_the_robots_own_files(shared_data: object) -> None:
    folder = shared_data / "robots-configuration-skin" / "ergoCubSN001"  # type: ignore[operator]
    spec = folder / "hardware" / "skin" / "torso-eb22-skinSpec.xml"
    with pytest.raises(InputError, match="no addresses of boards"):
        load_configuration(spec)


def test_the_number_of_buses_must_fit() -> None:
    with pytest.raises(InputError, match="expected 1"):
        ICubCan(configuration_for(*HEXAGON), (BusSettings(), BusSettings(port=43114)))
    with pytest.raises(InputError, match="expected 1"):
        CySkinCan(CYSKIN_BOARDS, ())


def test_a_cyskin_board_over_a_bus() -> None:
    device = CySkinBoard()
    stream = CySkinCan(CYSKIN_BOARDS, (device.settings,), period_ms=20).open()
    start = start_messages(CYSKIN_BOARDS, CySkinWire(), period_ms=20)
    poll_until(stream, lambda: len(device.listen()) >= len(start))
    assert device.told == start
    device.send()
    channels, blocks = Channels(72), Blocks()

    def came() -> bool:
        channels.apply(blocks)
        return bool(np.isfinite(channels.counts).all())

    poll_until(stream, came, blocks)
    np.testing.assert_array_equal(channels.counts, np.arange(72) + 1)
    stream.close()
    device.close()

"""Skin in from YARP: against a robot's side in plain Python, byte for byte."""

import time
from collections.abc import Iterator
from contextlib import ExitStack, closing

import numpy as np
import pytest
from bus_peers import wait_for
from live_devices import HEXAGON, Leaving
from yarp_peers import NameServer, Sender

from skinfield.cli.sources import source_from_options
from skinfield.errors import InputError
from skinfield.signal import Block, Blocks, Count, Kind, Stream, blocks_of
from skinfield.wire.sources import YarpPort, YarpText

FOREARM = "/icub/skin/left_forearm"


class Robot:
    """A name server and one port."""

    def __init__(self) -> None:
        self.server, self.sender, self.opened = NameServer(), Sender(), ExitStack()
        self.server.known[FOREARM] = ("127.0.0.1", self.sender.port)

    def source(self, channels: int = 12) -> YarpText:
        ports = (YarpPort("left_forearm", channels, FOREARM),)
        return YarpText(ports, port=self.server.port)

    def stream(self, channels: int) -> Stream:
        """One that is up."""
        stream = self.opened.enter_context(closing(self.source(channels).open()))
        wait_for(lambda: stream.poll(Blocks(), 0, time.time_ns()) or stream.up)
        wait_for(lambda: self.sender.readers)
        return stream

    def send(self) -> int:
        wait_for(lambda: self.sender.readers)
        self.sender.send([240.0 - self.sender.number % 200] * 12)
        return 1

    def unplug(self, stream: Stream) -> None:
        self.sender.close()

    def plug(self) -> None:
        self.sender.listen()

    def close(self) -> None:
        for each in (self.opened, self.server, self.sender):
            each.close()


@pytest.fixture
def robot() -> Iterator[Robot]:
    made = Robot()
    yield made
    made.close()


class TestYarpText(Leaving):
    made = Robot


def blocks_when(stream: Stream, enough: int, kinds: tuple[Kind, ...] = ()) -> list[Block]:
    """Blocks of counts, once there are so many."""
    wanted = kinds or (Kind.BYTES, Kind.SHORTS, Kind.FLOATS)
    blocks, found = Blocks(), list[Block]()

    def there() -> bool:
        blocks.clear()
        stream.poll(blocks, 0, time.time_ns())
        found.extend(b for b in blocks_of(blocks.data.tobytes()) if b.kind in wanted)
        return len(found) >= enough

    wait_for(there)
    return found


def test_what_it_says_is_what_yarps_pages_say(robot: Robot) -> None:
    robot.stream(12)
    assert robot.server.heard == [b'CONNECT skinfield\r\nd\r\nquery "/icub/skin/left_forearm"\r\n']
    assert robot.sender.heard == [b"CONNECT skinfield\r\nr\r\n"]


def test_numbers_of_all_kinds_arrive(robot: Robot) -> None:
    stream = robot.stream(5)
    robot.sender.send([0, 255, 240, 1, 2])
    robot.sender.send([0, 256, 65535, 1, 2], word="do")
    robot.sender.send([-1.5, 0.1, 1e-12, 123456789.25, 3e38], word="d")
    robot.sender.say(b"do\nnan inf -inf +7 .5e1\n")  # as telnet ends lines, and without a stamp
    found = blocks_when(stream, 4)
    assert found[0].payload.tolist() == [0, 255, 240, 1, 2]
    assert found[1].payload.tolist() == [0, 256, 65535, 1, 2]
    expected = np.float32([-1.5, 0.1, 1e-12, 123456789.25, 3e38])
    np.testing.assert_array_equal(found[2].payload, expected)
    np.testing.assert_array_equal(found[3].payload, np.float32([np.nan, np.inf, -np.inf, 7, 5]))
    assert stream.counters[Count.LOST] == stream.counters[Count.MALFORMED] == 0


def test_what_a_port_left_out_is_counted_by_its_numbers(robot: Robot) -> None:
    stream = robot.stream(3)
    for number in (5, 6, 9, 10, 0, 1, 4):  # 7, 8; begun anew; 2, 3
        robot.sender.send([1, 2, 3], number)
    blocks_when(stream, 7)
    assert stream.counters[Count.LOST] == 4


def test_vectors_of_another_length_are_counted_and_told(robot: Robot) -> None:
    stream = robot.stream(3)
    robot.sender.send([1, 2, 3, 4])
    robot.sender.say(b"D\r\n1 2 x\r\nwhat?\r\n")
    wait_for(lambda: blocks_when(stream, 0) or stream.counters[Count.MALFORMED] == 3)
    assert "sends something else than numbers, expected 3 numbers" in stream.notes[0]
    robot.sender.send([1, 2, 3])
    assert len(blocks_when(stream, 1)) == 1
    assert not stream.notes


def test_a_line_in_pieces_and_a_goodbye(robot: Robot) -> None:
    stream = robot.stream(3)
    for piece in (b"D 1 ", b"2.5\r", b"\n1 2", b"4", b"0 3\r\n"):
        assert not blocks_when(stream, 0)
        robot.sender.say(piece)
    assert blocks_when(stream, 1)[0].payload.tolist() == [1, 240, 3]
    robot.sender.say(b"q\r\n")
    wait_for(lambda: blocks_when(stream, 0) or not stream.up)
    assert "the port was closed" in stream.fault


def test_a_port_that_is_not_known_or_no_port_is_told(robot: Robot) -> None:
    robot.server.known.clear()
    stream = robot.opened.enter_context(closing(robot.source().open()))
    wait_for(lambda: blocks_when(stream, 0) or "does not know it" in stream.fault)
    assert not stream.up
    robot.sender.welcome = "220 smtp.example.org\r\n"
    robot.server.known[FOREARM] = ("127.0.0.1", robot.sender.port)
    wait_for(lambda: blocks_when(stream, 0) or "is it a port of YARP?" in stream.fault)
    robot.sender.welcome = Sender.welcome
    wait_for(lambda: blocks_when(stream, 0) or stream.up)
    assert stream.counters[Count.REOPENED] == 1


def test_words_of_a_command_line() -> None:
    made = source_from_options("yarp", "192.0.2.7", (), HEXAGON, {"robot": "ergocub"})
    assert made == YarpText(
        (YarpPort("hexagon72", 72, "/ergocub/skin/hexagon72"),), "192.0.2.7", 10000
    )
    made = source_from_options("yarp", "", ("10.0.0.2:10012",), HEXAGON, {"own": "me"})
    assert made == YarpText((YarpPort("hexagon72", 72, "10.0.0.2:10012"),), own="me")
    with pytest.raises(InputError, match="expected 1: a port for each of hexagon72"):
        source_from_options("yarp", "", ("/a", "/b"), HEXAGON)
    with pytest.raises(InputError, match="expected its name, as /icub"):
        source_from_options("yarp", "", ("left_forearm",), HEXAGON)
    with pytest.raises(InputError, match="without"):
        source_from_options("yarp", "", ("/left forearm",), HEXAGON)

"""Whole readings for scripts; ports for patches."""

import threading
import time

import numpy as np
import pytest
from live_devices import HEXAGON

from skinfield.acquisition import Blocks, Kind, Port, Status, counters
from skinfield.errors import InputError
from skinfield.sources.live import (
    NoReadingError,
    SimulationSource,
    StreamReader,
    matched,
    read,
    read_latest,
)


class Script:
    """A stream that appends what the next step of a script says."""

    def __init__(self, *steps: list[tuple[int, list[float], Status]]) -> None:
        self.ports, self.counters, self.up = (Port("a", 4),), counters(), True
        self.steps, self.fault = list(steps), "unplugged"

    def poll(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        step = self.steps.pop(0) if self.steps else []
        for first, values, status in step:
            blocks.put(now_ns, channel + first, values, Kind.FLOATS, status)
        return len(step)

    def filenos(self) -> list[int]:
        return []


OK = Status.OK
LEFT, RIGHT = (0, [1.0, 2.0], OK), (2, [3.0, 4.0], OK)


def test_a_reading_is_complete_when_a_channel_comes_again_or_all_came() -> None:
    reader = StreamReader(Script([LEFT], [], [RIGHT], [LEFT], [], [RIGHT], [LEFT]))
    first = reader.read()
    assert first.counts.tolist() == [1, 2, 3, 4]
    assert len(reader.stream.steps) == 3  # known now: all that answer
    second = reader.read()
    assert len(reader.stream.steps) == 1
    assert second.stamp_ns > first.stamp_ns
    assert second.valid.all()


def test_what_does_not_answer_is_not_valid() -> None:
    step = [(0, [1.0, np.nan], OK), (2, [3.0], Status.NOT_CONNECTED)]
    reading = read(Script(step, step))
    assert reading.valid.tolist() == [True, False, False, False]


def test_a_reading_that_does_not_come() -> None:
    script = Script([LEFT])
    script.up = False
    with pytest.raises(NoReadingError, match=r"2 of 4 channels.*down \(unplugged\)"):
        read(script, 0.01)
    with pytest.raises(TimeoutError, match="newest reading is none"):
        read_latest(Script())


def test_the_newest_reading_is_young_enough_or_refused() -> None:
    reader = StreamReader(Script([LEFT, RIGHT], []))
    assert reader.read_latest(10.0).valid.all()
    reader.channels.stamp_ns[:2] -= 30 * 10**9
    assert reader.read_latest(10.0).valid.tolist() == [False, False, True, True]
    reader.channels.stamp_ns[:] -= 30 * 10**9
    with pytest.raises(NoReadingError, match="s old, expected at most 10 s"):
        reader.read_latest(10.0)


def test_readings_of_a_source() -> None:
    stream = SimulationSource(np.arange(12.0).reshape(3, 4), rate=200.0).open()
    reader = StreamReader(stream)
    values = [reader.read(10.0).counts[0] for _ in range(5)]
    assert set(values) <= {0.0, 4.0, 8.0}
    assert len(set(values)) > 1
    assert reader.read_latest(10.0).counts.shape == (4,)
    stream.close()


def test_reading_waits_for_a_file_descriptor() -> None:
    import socket

    from live_devices import packet

    from skinfield.sources.live import PacketUdp

    stream = PacketUdp(72, port=0).open()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as device:

        def send() -> None:
            for number in range(3):
                time.sleep(0.02)
                device.sendto(packet(number), stream.address)

        thread = threading.Thread(target=send)
        thread.start()
        assert read(stream, 30.0).counts.shape == (72,)
        thread.join()
    stream.close()


def test_ports_are_matched_by_name_or_being_the_only_one() -> None:
    assert matched(HEXAGON, [Port("skin", 192)]) == (0,)
    assert matched(HEXAGON, [Port("skin", 9), Port("hexagon72", 72)]) == (1,)
    assert matched(HEXAGON[0], [Port("hexagon72", 72)]) == (0,)
    with pytest.raises(InputError, match="has no port, expected one of its name among a, b"):
        matched(HEXAGON, [Port("a", 192), Port("b", 192)])
    with pytest.raises(InputError, match="reads channel 71, expected channels below 12"):
        matched(HEXAGON, [Port("a", 12)])

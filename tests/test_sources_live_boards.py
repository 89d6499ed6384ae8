"""Boards of an iCub as a source: supervision, ports; whole readings for scripts."""

import threading
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from bus_peers import wait_for
from icub_files import SKIN, SPEC
from live_devices import CYSKIN_BOARDS, HEXAGON, CySkinBoard, Host, ICubBoard, PacketSocket

from skinfield.cli.sources import source_from_options
from skinfield.emulator import VirtualSettings, VirtualSkin
from skinfield.emulator.process import start
from skinfield.errors import InputError
from skinfield.signal import Blocks, Count, Kind, Lasting, Port, Source, Status, counters
from skinfield.skin import Skin
from skinfield.skin.generators import by_name
from skinfield.wire.can import BusSettings
from skinfield.wire.can.messages import CanMessages
from skinfield.wire.cyskin import CySkinWire, start_messages, stop_messages
from skinfield.wire.icub import (
    ICubBoardSettings,
    ICubConfiguration,
    PortRun,
    configuration_for,
    load_configuration,
)
from skinfield.wire.sources import CySkinCan, ICubCan, NoReadingError, PacketUdp, StreamReader
from skinfield.wire.sources.boards import AT_ONCE, cyskin_supervision, icub_supervision, ports_of

SECOND = 1_000_000_000
NOW = 1_700_000_000 * SECOND


class Wire:
    """A bus that notes what is sent, and takes as much as it is allowed to."""

    def __init__(self) -> None:
        self.sent: list[tuple[int, bytes]] = []
        self.room, self.up = 10**6, True

    def send(self, identifier: int, data: bytes) -> bool:
        if len(self.sent) >= self.room:
            return False
        self.sent.append((identifier, data))
        return True


class Cared:
    """An iCub's board under supervision, and a clock."""

    def __init__(self) -> None:
        self.wire, self.now = Wire(), NOW
        self.care = icub_supervision(configuration_for(*HEXAGON), 0)
        self.care.begin(NOW)

    def heard(self, message_class: int = 4) -> None:
        rows = CanMessages(1)
        rows.ids[0], rows.stamp_ns[0] = message_class << 8 | 1 << 4, self.now
        self.care.heard(rows, 1)

    def told(self, seconds: float, *, sends: int = 0) -> list[float]:
        """Attend every 10 ms; the seconds at which a board was told its settings (a 4D)."""
        times = []
        for step in range(round(100 * seconds)):
            if sends:
                self.heard(sends)
            before = len(self.wire.sent)
            self.care.attend(self.wire, self.now)
            self.now += SECOND // 100
            times += [step / 100 for _, data in self.wire.sent[before:] if data[0] == 0x4D]
        return times


@pytest.fixture
def cared() -> Cared:
    return Cared()


def test_first_everything_is_told_in_small_parts(cared: Cared) -> None:
    wire, expected = cared.wire, list(configuration_for(*HEXAGON).messages())
    wire.room = 3
    cared.told(0.01)
    assert wire.sent == expected[:3]
    wire.room = 10**6
    cared.told(0.01)
    assert wire.sent == expected[: 3 + AT_ONCE]
    assert expected[-1] == (0x201, b"\x07\x00")


def test_a_board_that_sends_is_left_alone(cared: Cared) -> None:
    assert cared.told(60.0, sends=4) == [0.0]
    assert cared.care.reconfigured == 0


def test_boards_of_an_engine_before_are_told_only_if_they_are_silent(cared: Cared) -> None:
    for sends in (4, 0):
        cared.care.resume(cared.now)
        told = cared.told(2.5, sends=sends)
        assert told == [] if sends else 2.0 <= told[0] <= 2.2


def test_a_silent_board_is_told_again_ever_more_rarely(cared: Cared) -> None:
    told = cared.told(60.0)
    assert told[0] == 0.0
    assert 2.0 <= told[1] <= 2.2
    np.testing.assert_allclose(np.diff(told)[1:], [1, 2, 4, 8, 10, 10, 10, 10], atol=0.11)
    assert cared.told(5.0, sends=4) == []
    assert 2.0 <= cared.told(3.0)[0] <= 2.2  # silent anew: soon again


def test_a_board_that_nobody_configured_is_told(cared: Cared) -> None:
    assert cared.told(2.0, sends=3) == [0.0]  # old firmware sends class 3 always
    assert cared.told(2.0, sends=4) == []
    told = cared.told(3.0, sends=3)  # it booted
    assert told[0] <= 0.1
    assert 0.9 <= told[1] - told[0] <= 1.1


def test_a_clock_that_is_set_back_does_not_silence_the_care(cared: Cared) -> None:
    cared.told(0.3)
    cared.now = NOW - 3600 * SECOND
    assert cared.told(0.1) == []
    cared.heard()
    assert cared.told(3.0)


def test_each_board_of_cyskin_is_started_again() -> None:
    wire, settings = Wire(), CySkinWire()
    care = cyskin_supervision(CYSKIN_BOARDS, settings, 20)
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


@pytest.mark.parametrize(
    ("made", "start", "stop"),
    [
        (ICubBoard, list(configuration_for(*HEXAGON).messages()), [(0x201, b"\x07\x01")]),
        (CySkinBoard, start_messages(CYSKIN_BOARDS), stop_messages(CYSKIN_BOARDS)),
    ],
)
def test_messages_over_a_bus_start_the_boards_and_stop_them(
    made: type, start: list, stop: list
) -> None:
    with closing(made()) as device:
        host = Host(device.source().open())
        host.until(lambda: len(device.listen()) >= len(start))
        assert device.told == start
        blocks = device.send(3)
        host.until(lambda: host.count(Count.READINGS) == blocks)
        expected = np.arange(72) + 1 if made is CySkinBoard else 1
        np.testing.assert_array_equal(host.channels.counts[:72], expected)
        host.stream.close()
        wait_for(lambda: len(device.listen()) >= len(start + stop))
        assert device.told[len(start) :] == stop


def test_boards_are_configured_anew_when_the_bus_comes_back(board: ICubBoard) -> None:
    host = Host(board.source().open())
    count = len(board.configuration.messages())
    host.until(lambda: len(board.listen()) >= count)
    board.unplug(host.stream)
    host.until(lambda: not host.stream.up)
    assert "closed" in host.stream.fault or "descriptor" in host.stream.fault
    board.plug()
    host.until(lambda: len(board.listen()) >= 2 * count)
    assert board.told[count : 2 * count] == board.told[:count]
    host.stream.close()


def test_who_only_listens_tells_nothing(board: ICubBoard) -> None:
    host = Host(board.source(configure=False).open())
    host.until(lambda: host.stream.up)
    board.send()
    counts = host.came(slice(72))
    assert (counts[:72] == 1).all()
    assert np.isnan(counts[72:]).all()
    host.stream.close()
    assert board.listen() == []


def test_two_buses_bring_one_port_each_its_boards() -> None:
    devices = ICubBoard(), ICubBoard()
    configuration = ICubConfiguration(
        (ICubBoardSettings(0, 1), ICubBoardSettings(1, 1)), (0, 1), "arm"
    )
    host = Host(ICubCan(configuration, tuple(each.settings for each in devices)).open())
    for each in (devices[0], devices[1], devices[1]):
        each.send()
    assert host.came([0, 192])[0] == 1
    host.until(lambda: host.count(Count.RECEIVED) == 36)
    assert host.stream.ports[0].channels == 384
    assert len(host.stream.filenos()) == 2
    for each in (host.stream, *devices):
        each.close()


def test_the_number_of_buses_must_fit() -> None:
    with pytest.raises(InputError, match="expected 1"):
        ICubCan(configuration_for(*HEXAGON), (BusSettings(), BusSettings(port=43114)))
    with pytest.raises(InputError, match="expected 1"):
        CySkinCan(CYSKIN_BOARDS, ())


def test_ports_follow_the_robots_wrapper() -> None:
    runs = (
        PortRun("hand", 192, 192, 0),
        PortRun("arm", 384, 384, 0),
        PortRun("forearm", 0, 192, 192),  # channels 0 to 191 are another device's
        PortRun("arm", 960, 192, 384),
    )
    found, ports = ports_of(configured(7, *runs))
    assert [(port.name, port.channels) for port in ports] == [
        ("hand", 192),
        ("arm", 576),
        ("forearm", 384),
        ("left_arm without a port", 384),
    ]
    assert found == ((0, 1), (0, 2), (0, 3), (0, 5), (255, 0), (0, 0), (0, 4), (0, 6))


BOARDS_OF_ARM = SKIN.replace("1 2 3", "14 2 3").replace(
    '<param name="skinCanAddrsPatch2"> 13 0xC </param>', ""
)


def wrapper(**runs: str) -> str:
    """A wrapper with the runs of some ports."""
    elements = "".join(f"<elem name='{name}'> {run} </elem>" for name, run in runs.items())
    return f"<device><paramlist name='ports'>{elements}</paramlist></device>"


@pytest.mark.parametrize("hand_last", [191, 155, 119, 60])  # of boards that are not full, too
def test_runs_of_a_wrapper_take_whole_boards(tmp_path: Path, hand_last: int) -> None:
    files = tmp_path / "arm-skin.xml", tmp_path / "arm-skin_wrapper.xml"
    hand = f"0 {hand_last} 0 {hand_last}"
    files[0].write_text(BOARDS_OF_ARM)
    files[1].write_text(wrapper(left_hand=hand, left_forearm="192 575 0 383"))
    found, ports = ports_of(load_configuration(*files))
    assert [(port.name, port.channels) for port in ports] == [
        ("left_hand", 192),
        ("left_forearm", 384),
    ]
    assert found == ((0, 14), (0, 2), (0, 3))


def configured(boards: int, *runs: PortRun) -> ICubConfiguration:
    return ICubConfiguration(
        tuple(ICubBoardSettings(0, address) for address in range(boards)), (0,), "left_arm", runs
    )


@pytest.mark.parametrize("run", [PortRun("p", 96, 192, 0), PortRun("p", 0, 192, 156)])
def test_a_run_that_begins_within_a_board_is_refused(run: PortRun) -> None:
    with pytest.raises(InputError, match="where boards begin"):
        ICubCan(configured(2, run)).open()


def test_a_virtual_skin_obeys_the_robots_files(tmp_path: Path) -> None:
    """Two boards, of which the second has four triangles; the last of them is switched off."""
    spec = SPEC.replace("0xf0", "0xeb").replace("50  <", "20  <").replace("  0  <", "  2  <")
    spec = spec.replace(">         false", "> true").replace(">  2  </", ">  1  </")  # one set
    spec = spec.replace(" 1   3   0   3   1 ", " 1 2 3 3 0 ").replace("specialCfgBoards", "none")
    files = {
        "arm-skin.xml": BOARDS_OF_ARM.replace("14 2 3", "1 2"),
        "arm-skinSpec.xml": spec,
        "arm-skin_wrapper.xml": wrapper(rectangular="0 239 0 239"),
    }
    for name, content in files.items():
        (tmp_path / name).write_text(content)
    text = "rectangular:rows=12,columns=20"
    config = ",".join(str(tmp_path / name) for name in files)
    udp = {"bus": "udp", "channels": ("127.0.0.1:0",)}
    with closing(
        VirtualSkin(VirtualSettings(skin=text, scene="idle", noise_scale=0.0, **udp))
    ) as boards:
        thread = threading.Thread(target=boards.run, daemon=True)
        thread.start()
        skin, places = Skin((by_name(text),)), boards.hardware.addresses
        source = source_from_options("icub", "udp", places, skin, {"config": config})
        host = Host(source.open())
        assert [(port.name, port.channels) for port in host.stream.ports] == [("rectangular", 384)]
        host.until(lambda: host.count(Count.RECEIVED) > 600)
        host.stream.close()
        boards.stop()
        thread.join()
    channels = host.channels
    assert (channels.counts[:228] == 0xEB).all()
    assert np.isnan(channels.counts[240:]).all()
    assert (channels.stamp_ns[228:240] < channels.stamp_ns[:228].min()).all()
    assert [host.count(each) for each in (Count.LOST, Count.DUPLICATED)] == [0, 0]


def follow(host: Host, source: Source) -> Host:
    """Leave the boards to another stream, as engines do that follow on each other."""
    assert isinstance(host.stream, Lasting)
    host.stream.leave()
    host.stream.close()
    stream = source.open()
    assert isinstance(stream, Lasting)
    stream.resume()
    return Host(stream)


def test_icub_goes_on_under_a_press_and_is_told_again_when_it_boots() -> None:
    with start(VirtualSettings(bus="udp", scene="idle")) as skin:
        options = {"period_ms": "5", "no_load": "245"}
        source = source_from_options("icub", "udp", tuple(skin.channels), HEXAGON, options)
        first = Host(source.open())
        first.until(lambda: first.count(Count.RECEIVED) > 500)
        assert abs(np.nanmean(first.channels.counts[:72]) - 245.0) < 2.0
        skin.press(taxel=40, force=2.0)
        first.until(lambda: np.nanmin(first.channels.counts[:72]) < 225)
        host = follow(first, source)
        host.until(lambda: host.count(Count.RECEIVED) > 200)
        assert np.nanmin(host.channels.counts[:72]) < 225
        assert host.stream.reconfigured == 0  # type: ignore[attr-defined]
        skin.release()
        skin.fault("reboot 0+100ms")
        host.until(lambda: host.stream.reconfigured == 1)  # type: ignore[attr-defined]
        before = host.count(Count.RECEIVED)
        host.until(lambda: host.count(Count.RECEIVED) > before + 200)
        assert abs(np.nanmean(host.channels.counts[:72]) - 245.0) < 2.0
        host.stream.close()
        counts = skin.stop()
        assert counts["reboots"] == 1
        for what in (Count.LOST, Count.OVERFLOWED, Count.MALFORMED, Count.FOREIGN):
            assert host.count(what) == 0, what.name
        assert first.count(Count.RECEIVED) + host.count(Count.RECEIVED) <= counts["messages"]


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
    reading = StreamReader(Script(step, step)).read()
    assert reading.valid.tolist() == [True, False, False, False]


def test_a_reading_that_does_not_come() -> None:
    script = Script([LEFT])
    script.up = False
    with pytest.raises(NoReadingError, match=r"2 of 4 channels.*down \(unplugged\)"):
        StreamReader(script).read(0.01)
    with pytest.raises(TimeoutError, match="newest reading is none"):
        StreamReader(Script()).read_latest()


def test_the_newest_reading_is_young_enough_or_refused() -> None:
    reader = StreamReader(Script([LEFT, RIGHT], []))
    assert reader.read_latest(10.0).valid.all()
    reader.channels.stamp_ns[:2] -= 30 * 10**9
    assert reader.read_latest(10.0).valid.tolist() == [False, False, True, True]
    reader.channels.stamp_ns[:] -= 30 * 10**9
    with pytest.raises(NoReadingError, match="s old, expected at most 10 s"):
        reader.read_latest(10.0)


def test_reading_waits_for_a_file_descriptor() -> None:
    device, stream = PacketSocket(), PacketUdp(72, port=0).open()

    def send() -> None:
        for _ in range(3):
            time.sleep(0.02)
            device.send(stream)

    thread = threading.Thread(target=send)
    thread.start()
    assert StreamReader(stream).read(30.0).counts.shape == (72,)
    thread.join()
    stream.close()
    device.close()

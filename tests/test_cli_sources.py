"""Sources from the words of a command line."""

from pathlib import Path

import numpy as np
import pytest
from live_devices import CYSKIN_BOARDS, HEXAGON, ON_CYSKIN

from skinfield.cli.sources import GROUP, skin_for, source_from_options, third_parties
from skinfield.errors import InputError
from skinfield.files.recordings.replay import ReplaySource
from skinfield.signal import Source
from skinfield.skin import Skin
from skinfield.skin.generators import by_name
from skinfield.wire.can import BusSettings
from skinfield.wire.can.bus import bus_settings, host_and_port, udp_places
from skinfield.wire.packet import PacketDevice
from skinfield.wire.sources import (
    CySkinCan,
    CySkinSharedMemory,
    ICubCan,
    PacketSerial,
    PacketTcp,
    PacketUdp,
)


def made(hardware: str, bus: str = "", *channels: str, **options: str) -> Source:
    return source_from_options(hardware, bus, channels, HEXAGON, options)


def test_icub() -> None:
    source = made("icub")
    assert isinstance(source, ICubCan)
    assert source.buses == (BusSettings("udp", "127.0.0.1", 0, "127.0.0.1:43113"),)
    assert source.configuration.addresses == ((0, 1),)
    assert source.configuration.ports[0].port == "hexagon72"
    source = made("icub", "udp", "127.0.0.1:4000", period_ms="2", no_load="0xf5", listen="yes")
    assert isinstance(source, ICubCan)
    assert source.buses == (BusSettings("udp", "127.0.0.1", 0, "127.0.0.1:4000"),)
    assert source.configuration.period == 2e-3
    assert source.configuration.boards[0].board.no_load == 245
    assert not source.configure


def test_icub_with_more_than_one_bus() -> None:
    one = by_name("rectangular:rows=48,columns=60")
    skin = Skin((one,))
    source = source_from_options("icub", "socketcan", (), skin)
    assert isinstance(source, ICubCan)
    assert [bus.channel for bus in source.buses] == ["can0", "can1"]
    with pytest.raises(InputError, match="expected 2: one for each bus"):
        source_from_options("icub", "socketcan", ("can0",), skin)


def test_cyskin() -> None:
    source = made("cyskin", "udp", ":5000", extended="yes", checked="no", period_ms="20")
    assert isinstance(source, CySkinCan)
    assert tuple(source.boards) == CYSKIN_BOARDS
    assert tuple(source.buses) == (BusSettings("udp", "127.0.0.1", 5000),)
    assert source.wire.extended
    assert source.period_ms == 20
    source = made("shm", "", "1234", boards="1,2")
    assert isinstance(source, CySkinSharedMemory)
    assert source.key == 1234
    assert [board.number for board in source.boards] == [1, 2]


def test_the_skin_on_its_hardware() -> None:
    assert skin_for("icub", HEXAGON) is HEXAGON
    np.testing.assert_array_equal(skin_for("cyskin", HEXAGON)[0].channel, ON_CYSKIN[0].channel)


DEVICES = (PacketDevice(1, 72, "hexagon72"),)
PEER = "192.0.2.9:5000"


@pytest.mark.parametrize(
    ("words", "options", "expected"),
    [
        ("packet udp :5000", {"unit": "Pa"}, PacketUdp(DEVICES, "127.0.0.1", 5000, unit="Pa")),
        ("packet udp 0.0.0.0:5000", {}, PacketUdp(DEVICES, "0.0.0.0", 5000)),
        (f"packet udp {PEER}", {"listen": "yes"},
         PacketUdp(DEVICES, "0.0.0.0", 0, PEER, command=False)),
        ("packet tcp 192.0.2.9", {}, PacketTcp(DEVICES, "192.0.2.9")),
        ("packet serial /dev/ttyUSB3", {"baud": "115200", "listen": "true"},
         PacketSerial(DEVICES, "/dev/ttyUSB3", 115200, command=False)),
    ],
)  # fmt: skip
def test_packets(words: str, options: dict[str, str], expected: Source) -> None:
    assert made(*words.split(), **options) == expected


def test_replay(tmp_path: Path) -> None:
    source = made("replay", "", str(tmp_path), speed="inf", loop="on")
    assert isinstance(source, ReplaySource)
    assert (source.speed, source.loop) == (float("inf"), True)


class Own:
    """A third party's source."""

    def __init__(self, skin: Skin, options: dict[str, str]) -> None:
        self.skin, self.options = skin, options

    def open(self) -> None:
        raise NotImplementedError


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A package that brings sources, as pip would leave it."""
    info = tmp_path / "mine-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        f"[{GROUP}]\nmine = {__name__}:Own\nbroken = nonesuch_package:Source\n"
        f"nothing = {__name__}:bool_of\n"
    )
    monkeypatch.syspath_prepend(tmp_path)


@pytest.mark.usefixtures("installed")
def test_sources_of_other_packages() -> None:
    assert {"mine", "broken", "nothing"} <= set(third_parties())
    source = made("mine", "spi", "0", "1", speed="9")
    assert isinstance(source, Own)
    assert source.options == {"bus": "spi", "channels": "0,1", "speed": "9"}
    assert source.skin is HEXAGON
    with pytest.raises(InputError, match="cannot be loaded: ModuleNotFoundError"):
        made("broken")
    with pytest.raises(InputError, match=r"expected an object with open"):
        made("nothing")
    with pytest.raises(InputError, match=r"expected one of icub, .*: broken, .*mine, .*nothing"):
        made("else")


def bool_of(skin: Skin, options: dict[str, str]) -> bool:
    return bool(options)


@pytest.mark.parametrize(
    ("words", "options", "text"),
    [
        ("nonesuch", {}, "hardware is 'nonesuch', expected one of icub, cyskin, packet, shm"),
        ("packet pigeon", {}, "bus is 'pigeon', expected one of udp, tcp, serial"),
        ("packet udp a b", {}, "expected one"),
        ("packet udp host:70000", {}, "expected a number from 0 to 65535"),
        ("shm - key", {}, "expected the key"),
        ("replay", {}, "expected the path"),
        ("icub udp a:1 b:2", {}, "expected 1: one for each bus"),
        ("icub", {"perid_ms": "2"}, "no option 'perid_ms', expected one of bitrate, config"),
        ("icub", {"period_ms": "fast"}, "period_ms of icub is 'fast', expected a whole number"),
        ("icub", {"listen": "maybe"}, "expected yes or no"),
        ("icub", {"config": "nonesuch.xml"}, "nonesuch"),
        ("replay - file", {"speed": "x"}, "speed of replay is 'x', expected a number"),
        ("cyskin", {"boards": "a"}, "boards are 'a'"),
    ],
)
def test_what_is_not_understood(words: str, options: dict[str, str], text: str) -> None:
    with pytest.raises(InputError, match=text):
        made(*words.replace("-", "").split(" "), **options)


def test_places() -> None:
    assert host_and_port("a:5", "h", 1) == ("a", 5)
    assert host_and_port("[::1]:5", "h", 1) == ("::1", 5)
    assert host_and_port("::1", "h", 1) == ("::1", 1)
    assert host_and_port(":5", "h", 1) == ("h", 5)
    assert host_and_port("", "h", 1) == ("h", 1)
    (bus,) = bus_settings("udp_multicast", ["239.1.2.3:5"], 1, 0)
    assert bus == BusSettings("udp_multicast", "239.1.2.3", options=(("port", 5),))
    peers = [bus.peer for bus in bus_settings("udp", [], 2, 0)]
    assert peers == ["127.0.0.1:43113", "127.0.0.1:43114"]
    (bus,) = bus_settings("udp", [":5"], 1, 0)
    assert bus == BusSettings("udp", "127.0.0.1", 5)
    (bus,) = bus_settings("slcan", ["/dev/ttyACM0"], 1, 500000)
    assert bus == BusSettings("slcan", "/dev/ttyACM0", bitrate=500000)
    (bus,) = bus_settings("udp", ["[fe80::7]:9"], 1, 0)
    assert bus == BusSettings("udp", "::", 0, "[fe80::7]:9")
    for text, own in (("[::1]:5", "::1"), ("localhost:5", "127.0.0.1")):
        assert udp_places(text, 1) == (own, 0, text)

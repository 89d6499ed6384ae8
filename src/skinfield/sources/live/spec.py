"""Sources from the words of a command line, third parties' included."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from skinfield.acquisition import Source
from skinfield.errors import InputError, check_offers
from skinfield.layout import Skin
from skinfield.protocols.cyskin import CySkinBoard, CySkinWire, Unchecked, on_boards
from skinfield.protocols.icub import configuration_for, load_configuration
from skinfield.protocols.packet import PacketDevice
from skinfield.protocols.yarp import PORT as YARP_PORT
from skinfield.protocols.yarp import port_of
from skinfield.sources.live.cyskin import CySkinCan, CySkinSharedMemory
from skinfield.sources.live.icub import ICubCan
from skinfield.sources.live.options import Options
from skinfield.sources.live.packet_serial import PacketSerial
from skinfield.sources.live.packet_tcp import PORT as TCP_PORT
from skinfield.sources.live.packet_tcp import PacketTcp
from skinfield.sources.live.packet_udp import PORT as UDP_PORT
from skinfield.sources.live.packet_udp import PacketUdp
from skinfield.sources.live.places import bus_settings, host_and_port, listens, own_address
from skinfield.sources.live.replay import ReplaySource
from skinfield.sources.live.simulation import pressed
from skinfield.sources.live.yarp_text import YarpPort, YarpText

GROUP = "skinfield.sources"  # of the entry points: name -> callable(skin, options) -> Source
MOST_BOARDS = 16
STREAMS = ("udp", "tcp", "serial")


@dataclass(frozen=True)
class Asked:
    """What was asked for: the words, and the skin that is to be read."""

    skin: Skin
    bus: str
    channels: tuple[str, ...]
    options: Options

    def one_channel(self, default: str) -> str:
        """The only channel."""
        if len(self.channels) > 1:
            raise InputError(f"channels are {', '.join(self.channels)}, expected one")
        return self.channels[0] if self.channels else default


def source_from_options(
    hardware: str,
    bus: str,
    channels: Sequence[str],
    skin: Skin,
    options: Mapping[str, str] | None = None,
) -> Source:
    """The source that somebody means.

    Parameters
    ----------
    hardware : str
        One of `HARDWARE`, or of an entry point of the group ``skinfield.sources``, which is called
        with the skin and the options (and `bus` and `channels`, joined by commas, among them).
    bus : str
        By which it is connected; empty for the usual one.
    channels : sequence of str
        Where on the bus, see `places.bus_settings`; empty for the usual place.
    skin : Skin
        Whose taxels are read; see also `skin_for`.
    options : mapping of str to str
        Further settings by name; see the functions of this module.

    Raises
    ------
    InputError
        If there is no such hardware, or a word is not understood; it lists what there is.
    """
    given = dict(options or {})
    if hardware in HARDWARE:
        read = Options(given, hardware)
        source = HARDWARE[hardware](Asked(skin, bus, tuple(channels), read))
        read.done()
        return source
    others = third_parties()
    if hardware not in others:
        more = ", ".join(sorted(others)) or "none"
        raise InputError(
            f"hardware is {hardware!r}, expected one of {', '.join(HARDWARE)}, or of those that "
            f"installed packages bring: {more}"
        )
    if bus:
        given.setdefault("bus", bus)
    if channels:
        given.setdefault("channels", ",".join(channels))
    return _called(others[hardware], skin, given)


def third_parties() -> dict[str, EntryPoint]:
    """Sources of other packages, by name; they are loaded only when they are asked for."""
    return {point.name: point for point in entry_points(group=GROUP)}


def _called(point: EntryPoint, skin: Skin, given: Mapping[str, str]) -> Source:
    try:
        make: Any = point.load()
    except Exception as error:
        raise InputError(
            f"source {point.name!r} ({point.value}) cannot be loaded: "
            f"{type(error).__name__}: {error}; mend or remove the package that brings it"
        ) from error
    source: Source = make(skin, given)
    check_offers(f"source of {point.name!r}", source, ("open",), "an object with open()")
    return source


def skin_for(hardware: str, skin: Skin) -> Skin:
    """The skin on the channels that its hardware has: CySkin's go by uid, others keep theirs."""
    return _on_boards(skin)[0] if hardware in ("cyskin", "shm") else skin


def icub(asked: Asked) -> Source:
    """Boards of an iCub.

    Options: `config` (the robot's XML files, by commas; else boards 1 to 14 of each bus, in the
    order of the patches), `period_ms`, `no_load`, `shift`, `bitrate`, `listen` (yes: tell the
    boards nothing).
    """
    read = asked.options
    files = [name for name in read.text("config", "").split(",") if name]
    period, no_load, shift = (
        read.whole(name, usual)
        for name, usual in (("period_ms", 50), ("no_load", 240), ("shift", 2))
    )
    configuration = (
        load_configuration(*files)
        if files
        else configuration_for(*asked.skin, period_ms=period, no_load=no_load, shift=shift)
    )
    buses = bus_settings(
        asked.bus or "udp_multicast",
        asked.channels,
        len(configuration.buses),
        read.whole("bitrate", 1_000_000),
    )
    return ICubCan(configuration, tuple(buses), configure=not read.flag("listen", False))


def cyskin(asked: Asked) -> Source:
    """Boards of CySkin on CAN.

    Options: `boards` (their numbers, by commas; default 1, 2, ... as many as the modules need),
    `period_ms`, `extended`, `big_endian`, `checked` (no: checksums are not looked at), `bitrate`,
    `listen`.
    """
    read = asked.options
    usual = CySkinWire()
    wire = CySkinWire(
        extended=read.flag("extended", usual.extended),
        big_endian=read.flag("big_endian", usual.big_endian),
        checksum=usual.checksum if read.flag("checked", True) else Unchecked(),
    )
    bus = bus_settings(
        asked.bus or "udp_multicast", asked.channels, 1, read.whole("bitrate", 1_000_000)
    )
    return CySkinCan(
        _boards(asked),
        tuple(bus),
        wire=wire,
        period_ms=read.whole("period_ms", 50),
        configure=not read.flag("listen", False),
    )


def shared_memory(asked: Asked) -> Source:
    """The memory of CySkin's acquisition tool; the channel is its key. Options: `boards`."""
    text = asked.one_channel("450")
    if not text.isdecimal():
        raise InputError(f"channel is {text!r}, expected the key of the memory, as 450")
    return CySkinSharedMemory(_boards(asked), int(text))


def _boards(asked: Asked) -> tuple[CySkinBoard, ...]:
    text = asked.options.text("boards", "")
    if not text:
        return _on_boards(asked.skin)[1]
    if not all(part.strip().isdecimal() for part in text.split(",")):
        raise InputError(f"boards are {text!r}, expected their numbers with commas, as 1,2")
    return on_boards(asked.skin, [int(part) for part in text.split(",")])[1]


def _on_boards(skin: Skin) -> tuple[Skin, tuple[CySkinBoard, ...]]:
    """The skin on boards 1, 2, ... as many as its modules need."""
    for count in range(1, MOST_BOARDS):
        with suppress(InputError):  # more modules than so many boards carry
            return on_boards(skin, range(1, count + 1))
    return on_boards(skin, range(1, MOST_BOARDS + 1))


def packet(asked: Asked) -> Source:
    """Skinfield's own packets; patch k is device k, from 1 on.

    Channels: of `udp` ``:port`` or ``0.0.0.0:port`` to listen at, or ``host:port`` of the device;
    of `tcp` ``host:port`` of the server; of `serial` the path of the line. Options: `unit`, `baud`,
    `listen`.
    """
    read, bus = asked.options, asked.bus or "udp"
    devices = tuple(
        PacketDevice(number, patch.n_channels) for number, patch in enumerate(asked.skin, 1)
    )
    names = tuple(patch.name for patch in asked.skin)
    unit, command = read.text("unit", "count"), not read.flag("listen", False)
    if bus == "serial":
        path, baud = asked.one_channel(PacketSerial.path), read.whole("baud", PacketSerial.baud)
        return PacketSerial(devices, path, baud, names, unit, command)
    if bus == "tcp":
        host, port = host_and_port(asked.one_channel(""), "127.0.0.1", TCP_PORT)
        return PacketTcp(devices, host, port, names, unit, command)
    if bus != "udp":
        raise InputError(f"bus is {bus!r}, expected one of {', '.join(STREAMS)}: for packets")
    where = asked.one_channel("")
    host, port = host_and_port(where, "127.0.0.1", UDP_PORT)
    if listens(where, host):
        return PacketUdp(devices, host, port, "", names, unit)
    peer = f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
    return PacketUdp(devices, own_address(host), 0, peer, names, unit)


def replay(asked: Asked) -> Source:
    """A recording; the channel is its path. Options: `speed` (inf: a reading a cycle), `loop`."""
    path, read = asked.one_channel(""), asked.options
    if not path:
        raise InputError("channel is missing, expected the path of the recording to replay")
    speed, loop = read.number("speed", 1.0), read.flag("loop", False)
    return ReplaySource(path, speed, loop, asked.skin)


def simulation(asked: Asked) -> Source:
    """A ball that presses each patch in turn, within this process. Options: `rate`, `force`."""
    read = asked.options
    return pressed(asked.skin, force=read.number("force", 3.0), rate=read.number("rate", 50.0))


def yarp(asked: Asked) -> Source:
    """Ports of YARP, one for each patch.

    The bus is ``host:port`` of the name server. Channels: each port's name, or its place as
    ``host:port``, which needs no name server; default that of the patch's name, such as
    ``/icub/skin/left_forearm``. Options: `robot` (in place of icub), `own` (name that we give),
    `unit`; `no_load` and `shift`, which say what bytes mean, are for whoever reads these.
    """
    read, patches = asked.options, tuple(asked.skin)
    for known, usual in (("no_load", 240), ("shift", 2)):
        read.whole(known, usual)
    robot = read.text("robot", "icub")
    names = asked.channels or tuple(port_of(patch.name, robot) for patch in patches)
    if len(names) != len(patches):
        raise InputError(
            f"channels are {', '.join(names)}, expected {len(patches)}: a port for each of "
            f"{', '.join(patch.name for patch in patches)}"
        )
    ports = tuple(
        YarpPort(patch.name, patch.n_channels, name)
        for patch, name in zip(patches, names, strict=True)
    )
    host, port = host_and_port(asked.bus, "127.0.0.1", YARP_PORT)
    own, unit = read.text("own", YarpText.own), read.text("unit", YarpText.unit)
    return YarpText(ports, host, port, own, unit)


HARDWARE: dict[str, Callable[[Asked], Source]] = {
    "icub": icub,
    "cyskin": cyskin,
    "packet": packet,
    "shm": shared_memory,
    "replay": replay,
    "simulation": simulation,
    "yarp": yarp,
}

"""Sources from the words of a command line, third parties' included."""

from collections.abc import Callable, Mapping, Sequence
from configparser import RawConfigParser
from dataclasses import replace
from importlib.metadata import EntryPoint, entry_points
from inspect import signature
from typing import Any

from skinfield.errors import InputError, check_offers
from skinfield.files.recordings.replay import ReplaySource
from skinfield.settings import nearest
from skinfield.signal import Source
from skinfield.skin import Skin
from skinfield.wire.can.bus import bus_settings, udp_places
from skinfield.wire.cyskin.modules import CySkinBoard, on_boards
from skinfield.wire.cyskin.wire import CySkinWire, Unchecked
from skinfield.wire.icub.configuration import configuration_for, load_configuration
from skinfield.wire.links import host_and_port
from skinfield.wire.packet.codec import PacketDevice
from skinfield.wire.sources.boards import CySkinCan, CySkinSharedMemory, ICubCan
from skinfield.wire.sources.packets import PacketSerial, PacketTcp, PacketUdp
from skinfield.wire.sources.yarp import YarpPort, YarpText
from skinfield.wire.yarp import PORT as YARP_PORT
from skinfield.wire.yarp import port_of

GROUP = "skinfield.sources"  # of the entry points: name -> callable(skin, options) -> Source
CONVERTERS: dict[type, tuple[str, Callable[[str], Any]]] = {
    str: ("text", str),
    bool: ("yes or no", lambda text: RawConfigParser.BOOLEAN_STATES[text.lower()]),
    int: ("a whole number", lambda text: int(text, 0)),
    float: ("a number", float),
}


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
        Where on the bus, see `bus_settings`; empty for the usual place.
    skin : Skin
        Whose taxels are read; see also `skin_for`.
    options : mapping of str to str
        Further settings by name; see the functions of this module.

    Raises
    ------
    InputError
        If there is no such hardware, or a word is not understood; it lists what there is.
    """
    texts = dict(options or {})
    if hardware in HARDWARE:
        make = HARDWARE[hardware]
        return make(skin, bus, tuple(channels), **_read_options(hardware, make, texts))
    others = third_parties()
    if hardware not in others:
        more = ", ".join(sorted(others)) or "none"
        raise InputError(
            f"hardware is {hardware!r}, expected one of {', '.join(HARDWARE)}, or of those that "
            f"installed packages bring: {more}{nearest(hardware, HARDWARE)}"
        )
    where = {"bus": bus, "channels": ",".join(channels)}
    texts = {name: text for name, text in where.items() if text} | texts
    point = others[hardware]
    try:
        build: Any = point.load()
    except Exception as error:
        raise InputError(
            f"source {point.name!r} ({point.value}) cannot be loaded: "
            f"{type(error).__name__}: {error}; mend or remove the package that brings it"
        ) from error
    source: Source = build(skin, texts)
    check_offers(f"source of {point.name!r}", source, ("open",), "an object with open()")
    return source


def _read_options(
    hardware: str, make: Callable[..., Source], texts: Mapping[str, str]
) -> dict[str, Any]:
    """Options of a function, of the types of their defaults: text, yes or no, numbers (0x too)."""
    usual = {
        each.name: each.default
        for each in signature(make).parameters.values()
        if each.kind is each.KEYWORD_ONLY
    }
    read = {}
    for name, text in texts.items():
        if name not in usual:
            known = ", ".join(sorted(usual)) or "none"
            raise InputError(f"{hardware} has no option {name!r}, expected one of {known}")
        what, convert = CONVERTERS[type(usual[name])]
        try:
            read[name] = convert(text)
        except (ValueError, KeyError):
            raise InputError(f"option {name} of {hardware} is {text!r}, expected {what}") from None
    return read


def third_parties() -> dict[str, EntryPoint]:
    """Sources of other packages, by name; they are loaded only when they are asked for."""
    return {point.name: point for point in entry_points(group=GROUP)}


def skin_for(hardware: str, skin: Skin) -> Skin:
    """The skin on the channels that its hardware has: CySkin's go by uid, others keep theirs."""
    return on_boards(skin)[0] if hardware in ("cyskin", "shm") else skin


def icub(
    skin: Skin,
    bus: str,
    channels: tuple[str, ...],
    *,
    config: str = "",
    period_ms: int = 50,
    no_load: int = 240,
    shift: int = 2,
    bitrate: int = 1_000_000,
    listen: bool = False,
) -> Source:
    """Boards of an iCub: of the robot's XML files in `config`, by commas, or 1 to 14 of each bus.

    In the latter case they are in the order of the patches. With `listen` they are told nothing.
    """
    files = [name for name in config.split(",") if name]
    if files:
        configuration = load_configuration(*files)
    else:
        configuration = configuration_for(*skin, period_ms=period_ms, no_load=no_load, shift=shift)
    buses = bus_settings(bus or "udp", channels, len(configuration.buses), bitrate)
    return ICubCan(configuration, tuple(buses), configure=not listen)


def cyskin(
    skin: Skin,
    bus: str,
    channels: tuple[str, ...],
    *,
    boards: str = "",
    period_ms: int = 50,
    extended: bool = CySkinWire.extended,
    big_endian: bool = CySkinWire.big_endian,
    checked: bool = True,
    bitrate: int = 1_000_000,
    listen: bool = False,
) -> Source:
    """Boards of CySkin on CAN: `boards` are their numbers, by commas, see `on_boards`.

    Unless `checked`, checksums are not looked at; with `listen` the boards are told nothing.
    """
    wire = CySkinWire(extended=extended, big_endian=big_endian)
    if not checked:
        wire = replace(wire, checksum=Unchecked())
    buses = bus_settings(bus or "udp", channels, 1, bitrate)
    return CySkinCan(
        _boards(skin, boards), tuple(buses), wire=wire, period_ms=period_ms, configure=not listen
    )


def shared_memory(skin: Skin, bus: str, channels: tuple[str, ...], *, boards: str = "") -> Source:
    """The memory of CySkin's acquisition tool; the channel is its key."""
    text = _one(channels, "450")
    if not text.isdecimal():
        raise InputError(f"channel is {text!r}, expected the key of the memory, as 450")
    return CySkinSharedMemory(_boards(skin, boards), int(text))


def _boards(skin: Skin, text: str) -> tuple[CySkinBoard, ...]:
    if text and not all(part.strip().isdecimal() for part in text.split(",")):
        raise InputError(f"boards are {text!r}, expected their numbers with commas, as 1,2")
    return on_boards(skin, [int(part) for part in text.split(",")] if text else None)[1]


def _one(channels: tuple[str, ...], usual: str) -> str:
    """The only channel."""
    if len(channels) > 1:
        raise InputError(f"channels are {', '.join(channels)}, expected one")
    return channels[0] if channels else usual


def packet(
    skin: Skin,
    bus: str,
    channels: tuple[str, ...],
    *,
    unit: str = "count",
    baud: int = PacketSerial.baud,
    listen: bool = False,
) -> Source:
    """Skinfield's own packets; patch k is device k, from 1 on.

    Channels: of `udp` ``:port`` or ``0.0.0.0:port`` to listen at, or ``host:port`` of the device;
    of `tcp` ``host:port`` of the server; of `serial` the path of the line.
    """
    devices = tuple(
        PacketDevice(k, patch.n_channels, patch.name) for k, patch in enumerate(skin, 1)
    )
    if bus == "serial":
        path = _one(channels, PacketSerial.path)
        return PacketSerial(devices, path, baud, unit=unit, command=not listen)
    place = _one(channels, "")
    if bus == "tcp":
        server = host_and_port(place, PacketTcp.host, PacketTcp.port)
        return PacketTcp(devices, *server, unit=unit, command=not listen)
    if bus not in ("", "udp"):
        raise InputError(f"bus is {bus!r}, expected one of udp, tcp, serial: for packets")
    places = udp_places(place, PacketUdp.port)
    return PacketUdp(devices, *places, unit=unit, command=not listen)


def replay(
    skin: Skin, bus: str, channels: tuple[str, ...], *, speed: float = 1.0, loop: bool = False
) -> Source:
    """A recording; the channel is its path, and an infinite `speed` brings a reading a cycle."""
    path = _one(channels, "")
    if not path:
        raise InputError("channel is missing, expected the path of the recording to replay")
    return ReplaySource(path, speed, loop, skin)


def yarp(
    skin: Skin,
    bus: str,
    channels: tuple[str, ...],
    *,
    robot: str = "icub",
    own: str = YarpText.own,
    unit: str = YarpText.unit,
    no_load: int = 240,
    shift: int = 2,
) -> Source:
    """Ports of YARP, one for each patch.

    The bus is ``host:port`` of the name server. Channels: each port's name, or its place as
    ``host:port``, which needs no name server; default that of the patch's name, such as
    ``/icub/skin/left_forearm``. `own` is the name that we give; `no_load` and `shift`, which say
    what bytes mean, are for whoever reads these.
    """
    patches = tuple(skin)
    names = channels or tuple(port_of(patch.name, robot) for patch in patches)
    if len(names) != len(patches):
        raise InputError(
            f"channels are {', '.join(names)}, expected {len(patches)}: a port for each of "
            f"{', '.join(patch.name for patch in patches)}"
        )
    ports = tuple(
        YarpPort(patch.name, patch.n_channels, name)
        for patch, name in zip(patches, names, strict=True)
    )
    return YarpText(ports, *host_and_port(bus, "127.0.0.1", YARP_PORT), own, unit)


HARDWARE: dict[str, Callable[..., Source]] = {
    "icub": icub,
    "cyskin": cyskin,
    "packet": packet,
    "shm": shared_memory,
    "replay": replay,
    "yarp": yarp,
}

"""Sources from the words of a command line, third parties' included; and ports of patches."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from typing import Any, TypeVar

from skinfield.errors import InputError, check_offers
from skinfield.signal import Port, Source
from skinfield.skin import Patch, Skin
from skinfield.wire.can.bus import bus_settings, host_and_port, listens, own_address
from skinfield.wire.cyskin.modules import CySkinBoard, on_boards
from skinfield.wire.cyskin.wire import CySkinWire, Unchecked
from skinfield.wire.icub.configuration import configuration_for, load_configuration
from skinfield.wire.packet.codec import PacketDevice
from skinfield.wire.sources.boards import CySkinCan, CySkinSharedMemory, ICubCan
from skinfield.wire.sources.packets import TCP_PORT, UDP_PORT, PacketSerial, PacketTcp, PacketUdp
from skinfield.wire.sources.replay import ReplaySource, pressed
from skinfield.wire.sources.yarp import YarpPort, YarpText
from skinfield.wire.yarp import PORT as YARP_PORT
from skinfield.wire.yarp import port_of

T = TypeVar("T")
YES, NO = ("yes", "true", "on", "1"), ("no", "false", "off", "0")

GROUP = "skinfield.sources"  # of the entry points: name -> callable(skin, options) -> Source
STREAMS = ("udp", "tcp", "serial")


def _flag(text: str) -> bool:
    if text.lower() not in YES + NO:
        raise ValueError(text)
    return text.lower() in YES


CONVERTERS: dict[type, tuple[str, Callable[[str], Any]]] = {
    str: ("text", str),
    bool: ("yes or no", _flag),
    int: ("a whole number", lambda text: int(text, 0)),
    float: ("a number", float),
}


class Options:
    """Text by name, of which each is asked for once.

    Parameters
    ----------
    texts : mapping of str to str
    whose : str
        Whose options they are, for messages.
    """

    def __init__(self, texts: Mapping[str, str], whose: str) -> None:
        self._texts, self._whose = dict(texts), whose
        self._read_names: list[str] = []

    def get(self, name: str, default: T) -> T:
        """One of them, of the type of its default: text, yes or no, whole (0x too), a number."""
        self._read_names.append(name)
        if name not in self._texts:
            return default
        what, convert = CONVERTERS[type(default)]
        try:
            value: T = convert(self._texts[name])
        except ValueError:
            raise InputError(
                f"option {name} of {self._whose} is {self._texts[name]!r}, expected {what}"
            ) from None
        return value

    def finish(self) -> None:
        """Raise InputError if something was given that is unknown."""
        for name in self._texts:
            if name not in self._read_names:
                known = ", ".join(sorted(self._read_names)) or "none"
                raise InputError(f"{self._whose} has no option {name!r}, expected one of {known}")


def matched(skin: Skin | Patch, ports: Sequence[Port]) -> tuple[int, ...]:
    """Port of each patch: that of its name, or the only one.

    Parameters
    ----------
    skin : Skin or Patch
    ports : sequence of Port
        Of all sources.

    Returns
    -------
    tuple of int
        Index into `ports`, for each patch.

    Raises
    ------
    InputError
        If a patch has no port, or its channels are more than the port has.
    """
    patches = (skin,) if isinstance(skin, Patch) else tuple(skin)
    names = [port.name for port in ports]
    found = []
    for patch in patches:
        if patch.name in names:
            place = names.index(patch.name)
        elif len(ports) == 1:
            place = 0
        else:
            raise InputError(
                f"patch {patch.name!r} has no port, expected one of its name among "
                f"{', '.join(names) or 'none'}: name the port after the patch"
            )
        highest = int(patch.channel.max())
        if highest >= ports[place].channels:
            raise InputError(
                f"patch {patch.name!r} reads channel {highest}, expected channels below "
                f"{ports[place].channels}: port {names[place]!r} has no more; is this the layout "
                "of that skin, and are all its boards listed?"
            )
        found.append(place)
    return tuple(found)


@dataclass(frozen=True)
class SourceRequest:
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
        Where on the bus, see `addresses.bus_settings`; empty for the usual place.
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
        read = Options(texts, hardware)
        source = HARDWARE[hardware](SourceRequest(skin, bus, tuple(channels), read))
        read.finish()
        return source
    others = third_parties()
    if hardware not in others:
        more = ", ".join(sorted(others)) or "none"
        raise InputError(
            f"hardware is {hardware!r}, expected one of {', '.join(HARDWARE)}, or of those that "
            f"installed packages bring: {more}"
        )
    if bus:
        texts.setdefault("bus", bus)
    if channels:
        texts.setdefault("channels", ",".join(channels))
    return _called(others[hardware], skin, texts)


def third_parties() -> dict[str, EntryPoint]:
    """Sources of other packages, by name; they are loaded only when they are asked for."""
    return {point.name: point for point in entry_points(group=GROUP)}


def _called(point: EntryPoint, skin: Skin, texts: Mapping[str, str]) -> Source:
    try:
        make: Any = point.load()
    except Exception as error:
        raise InputError(
            f"source {point.name!r} ({point.value}) cannot be loaded: "
            f"{type(error).__name__}: {error}; mend or remove the package that brings it"
        ) from error
    source: Source = make(skin, texts)
    check_offers(f"source of {point.name!r}", source, ("open",), "an object with open()")
    return source


def skin_for(hardware: str, skin: Skin) -> Skin:
    """The skin on the channels that its hardware has: CySkin's go by uid, others keep theirs."""
    return on_boards(skin)[0] if hardware in ("cyskin", "shm") else skin


def icub(request: SourceRequest) -> Source:
    """Boards of an iCub.

    Options: `config` (the robot's XML files, by commas; else boards 1 to 14 of each bus, in the
    order of the patches), `period_ms`, `no_load`, `shift`, `bitrate`, `listen` (yes: tell the
    boards nothing).
    """
    read = request.options
    files = [name for name in read.get("config", "").split(",") if name]
    period, no_load, shift = (
        read.get(name, usual) for name, usual in (("period_ms", 50), ("no_load", 240), ("shift", 2))
    )
    configuration = (
        load_configuration(*files)
        if files
        else configuration_for(*request.skin, period_ms=period, no_load=no_load, shift=shift)
    )
    buses = bus_settings(
        request.bus or "udp",
        request.channels,
        len(configuration.buses),
        read.get("bitrate", 1_000_000),
    )
    return ICubCan(configuration, tuple(buses), configure=not read.get("listen", False))


def cyskin(request: SourceRequest) -> Source:
    """Boards of CySkin on CAN.

    Options: `boards` (their numbers, by commas; default 1, 2, ... as many as the modules need),
    `period_ms`, `extended`, `big_endian`, `checked` (no: checksums are not looked at), `bitrate`,
    `listen`.
    """
    read = request.options
    usual = CySkinWire()
    wire = CySkinWire(
        extended=read.get("extended", usual.extended),
        big_endian=read.get("big_endian", usual.big_endian),
        checksum=usual.checksum if read.get("checked", True) else Unchecked(),
    )
    bus = bus_settings(request.bus or "udp", request.channels, 1, read.get("bitrate", 1_000_000))
    return CySkinCan(
        _boards(request),
        tuple(bus),
        wire=wire,
        period_ms=read.get("period_ms", 50),
        configure=not read.get("listen", False),
    )


def shared_memory(request: SourceRequest) -> Source:
    """The memory of CySkin's acquisition tool; the channel is its key. Options: `boards`."""
    text = request.one_channel("450")
    if not text.isdecimal():
        raise InputError(f"channel is {text!r}, expected the key of the memory, as 450")
    return CySkinSharedMemory(_boards(request), int(text))


def _boards(request: SourceRequest) -> tuple[CySkinBoard, ...]:
    text = request.options.get("boards", "")
    if not text:
        return on_boards(request.skin)[1]
    if not all(part.strip().isdecimal() for part in text.split(",")):
        raise InputError(f"boards are {text!r}, expected their numbers with commas, as 1,2")
    return on_boards(request.skin, [int(part) for part in text.split(",")])[1]


def packet(request: SourceRequest) -> Source:
    """Skinfield's own packets; patch k is device k, from 1 on.

    Channels: of `udp` ``:port`` or ``0.0.0.0:port`` to listen at, or ``host:port`` of the device;
    of `tcp` ``host:port`` of the server; of `serial` the path of the line. Options: `unit`, `baud`,
    `listen`.
    """
    read, bus = request.options, request.bus or "udp"
    devices = tuple(
        PacketDevice(number, patch.n_channels) for number, patch in enumerate(request.skin, 1)
    )
    names = tuple(patch.name for patch in request.skin)
    unit, command = read.get("unit", "count"), not read.get("listen", False)
    if bus == "serial":
        path, baud = request.one_channel(PacketSerial.path), read.get("baud", PacketSerial.baud)
        return PacketSerial(devices, path, baud, names=names, unit=unit, command=command)
    if bus == "tcp":
        host, port = host_and_port(request.one_channel(""), "127.0.0.1", TCP_PORT)
        return PacketTcp(devices, host, port, names=names, unit=unit, command=command)
    if bus != "udp":
        raise InputError(f"bus is {bus!r}, expected one of {', '.join(STREAMS)}: for packets")
    where = request.one_channel("")
    host, port = host_and_port(where, "127.0.0.1", UDP_PORT)
    if listens(where, host):
        return PacketUdp(devices, host, port, names=names, unit=unit)
    peer = f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
    return PacketUdp(devices, own_address(host), 0, peer, names=names, unit=unit, command=command)


def replay(request: SourceRequest) -> Source:
    """A recording; the channel is its path. Options: `speed` (inf: a reading a cycle), `loop`."""
    path, read = request.one_channel(""), request.options
    if not path:
        raise InputError("channel is missing, expected the path of the recording to replay")
    speed, loop = read.get("speed", 1.0), read.get("loop", False)
    return ReplaySource(path, speed, loop, request.skin)


def simulation(request: SourceRequest) -> Source:
    """A ball that presses each patch in turn, within this process. Options: `rate`, `force`."""
    read = request.options
    return pressed(request.skin, force=read.get("force", 3.0), rate=read.get("rate", 50.0))


def yarp(request: SourceRequest) -> Source:
    """Ports of YARP, one for each patch.

    The bus is ``host:port`` of the name server. Channels: each port's name, or its place as
    ``host:port``, which needs no name server; default that of the patch's name, such as
    ``/icub/skin/left_forearm``. Options: `robot` (in place of icub), `own` (name that we give),
    `unit`; `no_load` and `shift`, which say what bytes mean, are for whoever reads these.
    """
    read, patches = request.options, tuple(request.skin)
    for known, usual in (("no_load", 240), ("shift", 2)):
        read.get(known, usual)
    robot = read.get("robot", "icub")
    names = request.channels or tuple(port_of(patch.name, robot) for patch in patches)
    if len(names) != len(patches):
        raise InputError(
            f"channels are {', '.join(names)}, expected {len(patches)}: a port for each of "
            f"{', '.join(patch.name for patch in patches)}"
        )
    ports = tuple(
        YarpPort(patch.name, patch.n_channels, name)
        for patch, name in zip(patches, names, strict=True)
    )
    host, port = host_and_port(request.bus, "127.0.0.1", YARP_PORT)
    own, unit = read.get("own", YarpText.own), read.get("unit", YarpText.unit)
    return YarpText(ports, host, port, own, unit)


HARDWARE: dict[str, Callable[[SourceRequest], Source]] = {
    "icub": icub,
    "cyskin": cyskin,
    "packet": packet,
    "shm": shared_memory,
    "replay": replay,
    "simulation": simulation,
    "yarp": yarp,
}

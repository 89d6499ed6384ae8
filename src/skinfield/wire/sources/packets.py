"""Packets of microcontrollers over UDP, TCP and serial lines, which may break and come back.

A device is told to start when the stream opens, when the connection comes back, and when nothing
came for `SILENCE`: then once a second. Devices that send by themselves need not understand it.
"""

import os
import termios
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic
from types import ModuleType
from typing import Any

from skinfield.errors import InputError, check_count, check_type
from skinfield.signal import Blocks, Count, Port
from skinfield.signal.block import Octets
from skinfield.wire.datagrams import DatagramLink
from skinfield.wire.links import ByteLink, DialledLink, peer_from_text, resolved
from skinfield.wire.packet.codec import PacketDecoder, PacketDevice, PacketScanner
from skinfield.wire.packet.packets import PacketKind, encode_command
from skinfield.wire.sources.streams import LinkedStream

SILENCE = 1_000_000_000  # ns
START, STOP = encode_command(PacketKind.START), encode_command(PacketKind.STOP)
ROUNDS = 8  # of a poll


@dataclass(frozen=True)
class PacketSource:
    """Settings of devices, whatever their packets come by.

    Parameters
    ----------
    devices : sequence of PacketDevice, or int
        A number: one device, of number 1, with so many channels.
    unit : str
        Of the numbers, one of `skinfield.skin.reading.UNITS`.
    command : bool
        Whether devices are told to start and to stop.
    """

    devices: Sequence[PacketDevice] | int
    unit: str = field(default="count", kw_only=True)
    command: bool = field(default=True, kw_only=True)

    @property
    def ports(self) -> tuple[Port, ...]:
        """One for each device."""
        devices = PacketDevice.several(self.devices)
        usual = "skin" if len(devices) == 1 else "device{}"
        return tuple(
            Port(each.name or usual.format(each.number), each.channels, self.unit)
            for each in devices
        )


class PacketStream(LinkedStream):
    """Packets over one link; see `skinfield.signal.Stream`."""

    def __init__(self, source: PacketSource, link: ByteLink | DatagramLink) -> None:
        with ExitStack() as undo:
            undo.callback(link.close)
            super().__init__(source.ports, [link])
            self.decoder = PacketDecoder(source.devices)
            undo.pop_all()
        self._send, self._command = link.put, source.command
        self._heard_ns = 0
        self._new = True  # connection, over which nothing was told yet

    def poll(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        """Append what has arrived; see `skinfield.signal.Stream`."""
        packets = super().poll(blocks, channel, now_ns)
        if packets:
            self._heard_ns = now_ns
        if self._command and (self._new or not 0 <= now_ns - self._heard_ns < SILENCE):
            self._new, self._heard_ns = not self.up, now_ns
            if not self._new:
                self._send(START)
        return packets

    def _came_back(self, place: int, now_ns: int) -> None:
        self._new = True

    def _stop(self) -> None:
        if self._command and self.up:
            self._send(STOP)


class ByteStream(PacketStream):
    """See `PacketStream`."""

    def __init__(self, source: PacketSource, link: ByteLink) -> None:
        super().__init__(source, link)
        self._receive, self._scanner = link.receive, PacketScanner(self.decoder)
        self._scanner.take(0, Blocks(1024), 0, self.counters, 0)  # compiles

    def _take(self, blocks: Blocks, channel: int, now_ns: int) -> None:
        scanner = self._scanner
        for _ in range(ROUNDS):
            free = scanner.free
            received = self._receive(free) if len(free) else 0
            if not received and not scanner.used:
                break
            done_with = scanner.take(received, blocks, channel, self.counters, now_ns)
            if received < len(free) or not done_with:
                break  # nothing more waits, or the blocks are full

    def _came_back(self, place: int, now_ns: int) -> None:
        super()._came_back(place, now_ns)
        self._scanner.forget()  # half a packet of the old connection; whole ones are taken by now


BATCH = 64  # datagrams of one system call
LONGEST = 65536  # bytes of a datagram
BATCHES = 16  # of a poll
UDP_PORT = 43210
TCP_PORT = 43211
LOOK = 0.25  # s between two looks at whether the device's node is still there


@dataclass(frozen=True)
class PacketUdp(PacketSource):
    """Devices that send packets by UDP; see `PacketSource` for what all have in common.

    Parameters
    ----------
    host : str
        Own address that is bound. The default hears this machine only; 0.0.0.0 hears all.
    port : int
        Own port that is bound; 0 takes a free one.
    peer : str
        ``host:port`` of a device that is told to start, and to stop at the end. Left empty, devices
        send by themselves.
    """

    host: str = "127.0.0.1"
    port: int = UDP_PORT
    peer: str = ""

    def __post_init__(self) -> None:
        check_count("port", self.port, 0, 65535, "of UDP")

    def open(self) -> "PacketUdpStream":
        """Bind the port.

        Raises
        ------
        InputError
            If an address is not understood.
        """
        return PacketUdpStream(self)


class PacketUdpStream(PacketStream):
    """See `PacketStream`."""

    def __init__(self, source: PacketUdp) -> None:
        own, peer = resolved(source.host, source.port, "host"), peer_from_text(source.peer)
        self._link = link = DatagramLink(f"udp {own.address}", BATCH, LONGEST, own, peer)
        link.reopen()
        super().__init__(source, link)
        self._first = self._count = 0
        self._decode(Blocks(1024), 0)  # compiles before the first packet

    @property
    def address(self) -> tuple[str, int]:
        """Host and port at which it listens."""
        return self._link.address

    def _take(self, blocks: Blocks, channel: int, now_ns: int) -> None:
        for _ in range(BATCHES):
            if self._first == self._count:
                self._first, self._count = 0, self._link.fill()
                if not self._count:
                    break
            self._decode(blocks, channel)
            if self._first < self._count or self._count < BATCH:
                break  # the blocks are full, or nothing more waits
        self.counters[Count.OVERFLOWED] = self._link.dropped

    def _decode(self, blocks: Blocks, channel: int) -> None:
        link = self._link
        self._first = self.decoder.decode_many(
            link.octets, link.lengths, link.stamp_ns, self._first, self._count, blocks, channel,
            self.counters,
        )  # fmt: skip


@dataclass(frozen=True)
class PacketTcp(PacketSource):
    """Devices behind a TCP server; see `PacketSource` for what all have in common.

    Parameters
    ----------
    host : str
    port : int
        Of the server.
    """

    host: str = "127.0.0.1"
    port: int = TCP_PORT

    def __post_init__(self) -> None:
        check_count("port", self.port, 1, 65535, "of the server")

    def open(self) -> ByteStream:
        """Begin to connect; the stream is up once that is done.

        Raises
        ------
        InputError
            If the host is not understood.
        """
        place = resolved(self.host, self.port, "host")
        link = DialledLink(f"tcp {self.host}:{self.port}", place)
        return ByteStream(self, link)


@dataclass(frozen=True)
class PacketSerial(PacketSource):
    """Devices at a serial line; see `PacketSource` for what all have in common.

    Parameters
    ----------
    path : str
        Of the device's node. One below /dev/serial/by-id stays the same when it is plugged in
        again, however many others there are.
    baud : int, bit/s
        Boards with USB of their own ignore it.
    """

    path: str = "/dev/ttyACM0"
    baud: int = 921600

    def __post_init__(self) -> None:
        check_type("path", self.path, str, "of the device's node, as /dev/ttyACM0")
        check_count("baud", self.baud, 50, 20_000_000, "bit/s of the line")

    def open(self) -> ByteStream:
        """Open the line; a device that is not plugged in now is waited for.

        Raises
        ------
        InputError
            If pyserial is not installed, or the line cannot be set up so.
        """
        return ByteStream(self, SerialLink(self.path, self.baud))


def pyserial() -> ModuleType:
    """The package."""
    try:
        import serial
    except ImportError as error:
        raise InputError(
            "a serial line is asked for, expected pyserial to be installed: "
            "pip install skinfield[serial]"
        ) from error
    module: ModuleType = serial
    return module


class SerialLink(ByteLink):
    """A serial line; pyserial sets it up, reading is the system's own call."""

    def __init__(self, path: str, baud: int) -> None:
        self._serial = pyserial()
        super().__init__(path)
        self._path, self._baud = path, baud
        self._port: Any = None
        self._node = (0, 0)
        self._look = 0.0
        self._open()

    def _open(self) -> bool:
        self.close()
        try:
            node = Path(self._path).stat()
            self._port = self._serial.Serial(
                self._path, self._baud, timeout=0, write_timeout=0, exclusive=True
            )
            self._port.reset_input_buffer()
        except ValueError as error:
            raise InputError(
                f"line {self._path} at {self._baud} bit/s: {error}, expected a rate that it has"
            ) from error
        except OSError as error:  # SerialException is one
            return bool(self.broke(error))
        self._node = node.st_dev, node.st_ino
        self._look = monotonic() + LOOK
        return self._opened(self._port.fileno())

    def receive(self, into: Octets) -> int:
        """See `ByteLink`."""
        if not self.up:
            return 0
        try:
            # a line that was unplugged reads as empty for ever, but refuses this question
            if self._port.in_waiting > 0:
                return os.readv(self._number, [into.data])
            if monotonic() > self._look:
                self._check_node()
        except (BlockingIOError, InterruptedError):
            return 0
        except OSError as error:
            return self.broke(error)
        return 0

    def _check_node(self) -> None:
        """Raise OSError if the node is gone, or another one."""
        self._look = monotonic() + LOOK
        node = Path(self._path).stat()
        if (node.st_dev, node.st_ino) != self._node:
            raise OSError(f"{self._path} is another device now")

    def close(self) -> None:
        """Let go of the line."""
        port, self._port, self.up, self._number = self._port, None, False, -1
        if port is not None:
            with suppress(OSError, termios.error):
                port.close()

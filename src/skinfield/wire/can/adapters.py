"""Adapters of CAN buses: SocketCAN, datagrams, and the interfaces of python-can.

SocketCAN and UDP carry Linux's struct can_frame (linux/can.h), one in each datagram of SocketCAN,
up to `PER_DATAGRAM` of them, one behind the other, in one of UDP, little-endian. SocketCAN was
tested on the bytes, through sockets of another family; no real bus was at hand.
"""

import errno
import os
import socket
import struct
from collections.abc import Callable
from time import time_ns
from types import ModuleType
from typing import Any

import numpy as np

from skinfield.errors import InputError, Ints
from skinfield.signal.block import Octets
from skinfield.wire.can.bus import INTERFACES, Bus, BusSettings
from skinfield.wire.can.messages import ERROR, EXTENDED, REMOTE, CanMessages
from skinfield.wire.datagrams import DatagramLink, address_from_octets
from skinfield.wire.links import LinkAddress, let_go, peer_from_text, resolved

FRAME = np.dtype([("id", "<u4"), ("length", "u1"), ("pad", "u1", 3), ("data", "u1", 8)])
STRUCT = FRAME.itemsize  # bytes of struct can_frame
BATCH = 128  # datagrams of one system call
PER_DATAGRAM = 64  # messages that are sent in a datagram of UDP
LONGEST = 92 * STRUCT  # bytes of a datagram of UDP that are read: Ethernet carries 1472
SOL_CAN_RAW, CAN_RAW_ERR_FILTER = 101, 2
ERRORS_OF_INTEREST = 0x1FFFFFFF  # CAN_ERR_MASK: all kinds
OTHER = "take interface udp, or one of python-can's (pcan, slcan, ...)"
NO_CAN = {errno.EAFNOSUPPORT, errno.EPROTONOSUPPORT, errno.EPERM, errno.EACCES}
ABSENT = {errno.ENODEV, errno.ENETDOWN, errno.ENXIO}  # no such device now, or not set up


class StructBus(DatagramLink, Bus):
    """Bus of struct can_frame in datagrams; see `Bus` and `DatagramLink`."""

    longest = STRUCT  # bytes of a datagram that is read
    together = 1  # messages that are sent in a datagram, at most

    def __init__(
        self, settings: BusSettings, own: LinkAddress | None = None, peer: LinkAddress | None = None
    ) -> None:
        from skinfield.wire.can.kernel import messages_of_structs

        super().__init__(settings.label, BATCH, self.longest, own, peer)
        self.settings, self._read = settings, messages_of_structs
        self._flat = self.octets.reshape(-1)
        self._words = self._flat.view(np.uint32)
        self._counts: Ints = np.zeros(2, np.int64)
        self._cursor: Ints = np.zeros(2, np.int64)  # datagram and byte that are read next
        self._taken = 0  # datagrams of the last batch
        self._take(CanMessages(1), 0)  # compiles before the first message

    def _use(self, sock: socket.socket) -> bool:
        self._cursor[:], self._taken = 0, 0
        return super()._use(sock)

    def receive(self, into: CanMessages) -> int:
        """See `Bus`."""
        at, more = 0, True
        while at < len(into) and self.up:
            if self._cursor[0] == self._taken:
                count = self.fill() if more else 0
                if not count:
                    break
                self._cursor[:], self._taken, more = 0, count, count == BATCH
                self.overflowed = self.dropped
                self._came(count)
            at = self._take(into, at)
        return at

    def _came(self, count: int) -> None:
        """Look at a batch of datagrams."""

    def _take(self, into: CanMessages, at: int) -> int:
        end = self._read(
            self._flat, self._words, self.octets.shape[1], self.lengths, self.stamp_ns,
            self._taken, self._cursor, at, into.ids, into.lengths, into.data, into.stamp_ns,
            self._counts,
        )  # fmt: skip
        self.malformed, self.errors = self._counts.tolist()
        return int(end)

    def send_many(self, messages: CanMessages, count: int) -> int:
        """See `Bus`; a full queue of the system takes fewer."""
        messages.check_rows(count)
        octets, size = structs_of(messages, count), STRUCT * self.together
        for sent in range(0, len(octets), size):
            if not self.put(octets[sent : sent + size]):
                return sent // STRUCT
        return count


def structs_of(messages: CanMessages, count: int) -> bytes:
    """The first `count` rows as struct can_frame, one behind the other."""
    frames = np.zeros(count, FRAME)
    frames["id"], frames["length"] = messages.ids[:count], np.minimum(messages.lengths[:count], 8)
    there = np.arange(8) < frames["length"][:, None]
    frames["data"] = np.where(there, messages.data[:count], 0)
    return frames.tobytes()


class UdpBus(StructBus):
    """Messages in datagrams to one address; see `Bus` and `BusSettings`."""

    longest, together = LONGEST, PER_DATAGRAM

    def __init__(self, settings: BusSettings) -> None:
        own = resolved(settings.channel or "127.0.0.1", settings.port, "channel")
        peer = peer_from_text(settings.peer)
        if peer is not None and peer.family != own.family:
            raise InputError(
                f"peer is {settings.peer!r} and channel {settings.channel!r}, expected both of "
                "IPv4 or both of IPv6"
            )
        super().__init__(settings, own, peer)
        self._name: Octets = np.zeros(0, np.uint8)  # of who sent last
        self.reopen()

    def _open(self) -> bool:
        if super()._open() and self.settings.peer:
            self.put(b"")  # tells a host that only answers where to answer to
        return self.up

    def _came(self, count: int) -> None:
        """Without a peer that is configured, answers go to whoever sent last."""
        name = self.names[count - 1]
        if not self.settings.peer and not np.array_equal(name, self._name):
            self._name = name.copy()
            self._peer = address_from_octets(name.tobytes())


class SocketCanBus(StructBus):
    """Linux's own CAN; see `Bus` and `BusSettings`.

    Parameters
    ----------
    settings : BusSettings
    sock : socket, optional
        An open one in place of a CAN device; for tests of the bytes.
    """

    def __init__(self, settings: BusSettings, sock: socket.socket | None = None) -> None:
        super().__init__(settings)
        if sock is not None:
            self._use(sock)
        elif hasattr(socket, "AF_CAN"):
            self._open()
        else:
            raise InputError(
                f"interface is 'socketcan', expected Linux: this Python has no AF_CAN; {OTHER}"
            )

    def _open(self) -> bool:
        self.close()
        device = self.settings.channel or "can0"
        sock = None
        try:
            sock = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
            sock.setsockopt(SOL_CAN_RAW, CAN_RAW_ERR_FILTER, struct.pack("=I", ERRORS_OF_INTEREST))
            sock.bind((device,))
            code = sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
            if code:  # a device that is there but down can be bound: the error waits behind
                raise OSError(code, os.strerror(code))
        except OSError as error:
            let_go(sock)
            if error.errno in NO_CAN:
                raise InputError(
                    "interface is 'socketcan', expected a kernel with CAN, and leave to open it: "
                    f"this one refuses ({error.strerror}); modprobe can can_raw, or {OTHER}"
                ) from None
            self.fault = f"{device}: {error.strerror or error}"
            if error.errno in ABSENT:
                self.fault += f"; ip link set {device} up type can bitrate 1000000"
            return False
        return self._use(sock)

    def _put(self, sock: socket.socket, datagram: bytes) -> bool:
        return sock.send(datagram) > 0


NEAR = 1_000_000_000  # ns: stamps further off are of a clock of the adapter's own


def python_can() -> ModuleType:
    """The package."""
    try:
        import can
    except ImportError as error:
        raise InputError(
            "interface is one of python-can's, expected python-can to be installed: "
            "pip install skinfield[can]"
        ) from error
    return can


def check_interface(name: str) -> None:
    """Raise InputError unless a bus can be opened by that name."""
    if name in ("udp", "socketcan"):
        return
    known = sorted(python_can().VALID_INTERFACES)
    if name not in known:
        raise InputError(f"interface is {name!r}, expected {INTERFACES}: {', '.join(known)}")


class PythonCanBus(Bus):
    """See `Bus` and `BusSettings`."""

    def __init__(self, settings: BusSettings) -> None:
        super().__init__(settings.label)
        self.settings = settings
        self._can = python_can()
        check_interface(settings.interface)
        self._bus: Any = None
        self._open()

    def _open(self) -> bool:
        self.close()
        name, options = self.settings.interface, dict(self.settings.options)
        if self.settings.channel:
            options["channel"] = self.settings.channel
        if self.settings.bitrate:
            options["bitrate"] = self.settings.bitrate
        try:
            self._bus = self._can.Bus(interface=name, ignore_config=True, **options)
        except self._can.CanInterfaceNotImplementedError as error:
            raise self._unusable(options, error) from error
        except (self._can.CanError, OSError) as error:
            return bool(self.broke(error))
        except Exception as error:  # drivers raise whatever they do not catch
            raise self._unusable(options, error) from error
        try:
            number = self._bus.fileno()
        except Exception:  # not all have one
            number = -1
        return self._opened(number)

    def _unusable(self, options: dict[str, Any], error: Exception) -> InputError:
        return InputError(
            f"{self.label} cannot be opened with {options}, expected settings that "
            f"python-can understands, and the driver installed: {type(error).__name__}: {error}"
        )

    def receive(self, into: CanMessages) -> int:
        """Take in what has arrived."""
        at = 0
        while self._bus is not None and at < len(into):
            try:
                message = self._bus.recv(0)
            except Exception as error:  # drivers raise whatever they do not catch
                self.broke(error)
                break
            if message is None:
                break
            at += self._take(message, into, at)
        return at

    def _take(self, message: Any, into: CanMessages, row: int) -> int:
        """Note one message; 1 if it is of interest."""
        if message.is_error_frame:
            self.errors += 1
            return 0
        if message.is_fd or not 0 <= message.dlc <= 8:
            self.malformed += 1
            return 0
        now, stamp = time_ns(), int(message.timestamp * 1e9)
        data = np.frombuffer(bytes(message.data[:8]), np.uint8)
        into.ids[row] = message.arbitration_id | (
            (EXTENDED if message.is_extended_id else 0) | (REMOTE if message.is_remote_frame else 0)
        )
        into.lengths[row] = message.dlc
        into.data[row, : len(data)] = data
        into.data[row, len(data) :] = 0
        into.stamp_ns[row] = stamp if now - NEAR < stamp <= now else now
        return 1

    def send_many(self, messages: CanMessages, count: int) -> int:
        """See `Bus`."""
        messages.check_rows(count)
        for row in range(count):
            if self._bus is None:
                return row
            try:
                self._bus.send(self._message(messages, row), timeout=0)
            except self._can.CanTimeoutError:
                return row
            except Exception as error:
                self.broke(error)
                return row
        return count

    def _message(self, messages: CanMessages, row: int) -> Any:
        identifier, length = int(messages.ids[row]), int(messages.lengths[row])
        remote = bool(identifier & REMOTE)
        return self._can.Message(
            arbitration_id=identifier & 0x1FFFFFFF,
            is_extended_id=bool(identifier & EXTENDED),
            is_remote_frame=remote,
            is_error_frame=bool(identifier & ERROR),
            dlc=length,
            data=None if remote else messages.data[row, :length].tobytes(),
        )

    def close(self) -> None:
        """Let go of the adapter."""
        bus, self._bus, self.up, self.fault = self._bus, None, False, "closed"
        if bus is not None:
            try:
                bus.shutdown()
            except Exception as error:
                self.fault = f"{self.label}: {error}"


def open_bus(settings: BusSettings) -> Bus:
    """Open a bus.

    Returns
    -------
    Bus
        Down, with its `fault` in words, if the device is only absent now.

    Raises
    ------
    InputError
        If the settings cannot be used: no such interface, address not understood, package not
        installed, no CAN in this system.
    """
    kinds: dict[str, Callable[[BusSettings], Bus]] = {"udp": UdpBus, "socketcan": SocketCanBus}
    return kinds.get(settings.interface, PythonCanBus)(settings)

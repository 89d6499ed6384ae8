"""Packets of microcontrollers over TCP: a client that connects again whenever that is possible."""

import errno
import os
import select
import socket
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from time import monotonic

from skinfield.acquisition.block import Octets
from skinfield.errors import check_count
from skinfield.protocols.packet import PacketDevice
from skinfield.sources.buses.udp_sockets import let_go, resolved
from skinfield.sources.live.packet_bytes import ByteStream
from skinfield.sources.live.packet_stream import checked_devices

PATIENCE = 3.0  # s, after which an attempt to connect, or a silent peer, is given up
PORT = 43211


@dataclass(frozen=True)
class PacketTcp:
    """Devices behind a TCP server.

    Parameters
    ----------
    devices : sequence of PacketDevice, or int
        A number: one device, of number 1, with so many channels.
    host : str
    port : int
        Of the server.
    names : sequence of str
        Of the devices' ports; default "skin", or "device<number>" of several.
    unit : str
        Of the numbers, one of `skinfield.reading.UNITS`.
    command : bool
        Whether devices are told to start and to stop.
    """

    devices: Sequence[PacketDevice] | int
    host: str = "127.0.0.1"
    port: int = PORT
    names: Sequence[str] = ()
    unit: str = "count"
    command: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "devices", checked_devices(self.devices))
        object.__setattr__(self, "names", tuple(self.names))
        check_count("port", self.port, 1, 65535, "of the server")

    def open(self) -> ByteStream:
        """Begin to connect; the stream is up once that is done.

        Raises
        ------
        InputError
            If the host is not understood.
        """
        link = TcpLink(self.host, self.port)
        try:
            return ByteStream(
                checked_devices(self.devices), self.names, self.unit, link, self.command
            )
        except BaseException:
            link.close()
            raise


class TcpLink:
    """A connection to a server."""

    def __init__(self, host: str, port: int) -> None:
        self._place = resolved(host, port, "host")
        self._label = f"tcp {host}:{port}"
        self._socket: socket.socket | None = None
        self._poll = select.poll()
        self._begun = 0.0  # when the attempt that goes on began; 0: none does
        self.up, self.fault = False, ""
        self.reopen()

    def reopen(self) -> bool:
        """Begin to connect, unless that goes on already."""
        if self._begun and monotonic() - self._begun < PATIENCE:
            return self._is_done()
        self.close()
        try:
            sock = socket.socket(self._place.family, socket.SOCK_STREAM)
        except OSError as error:
            self.fault = f"{self._label}: {error.strerror or error}"
            return False
        sock.setblocking(False)
        watch_over(sock)
        self._socket, self._begun = sock, monotonic()
        self._poll = select.poll()
        self._poll.register(sock, select.POLLOUT)
        self.fault = f"{self._label}: connecting"
        code = sock.connect_ex(self._place.address)
        if code not in (0, errno.EINPROGRESS):
            self._broke(os.strerror(code))
            return False
        return self._is_done()

    def _is_done(self) -> bool:
        """Whether the attempt succeeded by now."""
        if self._socket is None or not self._poll.poll(0):
            return False
        code = self._socket.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        if code:
            self._broke(os.strerror(code))
            return False
        self._begun, self.up, self.fault = 0.0, True, ""
        return True

    def receive(self, into: Octets) -> int:
        """Write what has arrived."""
        if self._socket is None or not self.up:
            self._is_done()  # what it brings is read once all know that it is up
            return 0
        try:
            count = self._socket.recv_into(into.data)
        except (BlockingIOError, InterruptedError):
            return 0
        except OSError as error:
            return self._broke(error.strerror or str(error))
        return count or self._broke("the server closed the connection")

    def send(self, data: bytes) -> None:
        """Send a few bytes."""
        if self._socket is not None and self.up:
            try:
                self._socket.send(data)
            except (BlockingIOError, InterruptedError):
                return  # the other side does not read: what it is told comes too late anyway
            except OSError as error:
                self._broke(error.strerror or str(error))

    def _broke(self, why: str) -> int:
        self.close()
        self.fault = f"{self._label}: {why}"
        return 0

    def filenos(self) -> Sequence[int]:
        """Of the socket, once it is connected."""
        return (self._socket.fileno(),) if self._socket is not None and self.up else ()

    def close(self) -> None:
        """Let go of the connection."""
        let_go(self._socket)
        self._socket, self._begun, self.up = None, 0.0, False


def watch_over(sock: socket.socket) -> None:
    """Have the system notice a peer that vanished without a word."""
    sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, value in (
        ("TCP_KEEPIDLE", 1),
        ("TCP_KEEPINTVL", 1),
        ("TCP_KEEPCNT", 2),
        ("TCP_USER_TIMEOUT", round(1e3 * PATIENCE)),
    ):
        if hasattr(socket, name):
            with suppress(OSError):
                sock.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)

"""Datagrams of UDP and of CAN in batches: one system call takes in all there are."""

import ctypes
import errno
import os
import socket
import struct
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from time import time_ns
from typing import NamedTuple, cast

import numpy as np

from skinfield.errors import InputError, Ints
from skinfield.signal.block import Octets

Address = tuple[str | int, ...]
Call = Callable[..., int]

SO_TIMESTAMPNS = 35  # asm-generic/socket.h; Python does not name these
SO_RXQ_OVFL = 40
SO_RCVBUFFORCE = 33
SO_SNDBUFFORCE = 32
RECEIVE_BUFFER = 8 << 20  # bytes: about 20 000 datagrams of one CAN message each
SEND_BUFFER = 2 << 20
TRANSIENT = {  # of a send or a receive: nothing is broken, less or nothing went through
    errno.EAGAIN,
    errno.EWOULDBLOCK,
    errno.EINTR,
    errno.ENOBUFS,
    errno.ENOMEM,
    errno.ECONNREFUSED,  # nobody listens there now: datagrams ask for no answer
}


class Datagrams:
    """Room for a batch of received datagrams; nothing is allocated after the beginning.

    Parameters
    ----------
    batch : int
        Datagrams of one call.
    size : int, bytes
        Of the longest datagram that is understood; longer ones are marked.

    Attributes
    ----------
    octets : (batch, size) uint8 array
    lengths : (batch,) int64 array
        -1 of a datagram that was longer than `size`.
    stamp_ns : (batch,) int64 array, ns
        When the kernel took it in, else when it was read.
    names : (batch, 32) uint8 array
        Senders, as struct sockaddr_in or sockaddr_in6.
    bytes : int
        Of the last batch.
    """

    def __init__(self, batch: int, size: int) -> None:
        from skinfield.wire.can.kernel import CONTROL, NAME, take_headers

        self.octets: Octets = np.zeros((batch, size), np.uint8)
        self.lengths: Ints = np.zeros(batch, np.int64)
        self.stamp_ns: Ints = np.zeros(batch, np.int64)
        self.names: Octets = np.zeros((batch, NAME), np.uint8)
        self.bytes = 0
        self._control = np.zeros(batch * CONTROL // 4, np.uint32)
        self._drops: Ints = np.zeros(2, np.int64)
        self._headers: Ints = np.zeros((batch, 8), np.int64)
        self._vectors: Ints = np.zeros((batch, 2), np.int64)
        steps = np.arange(batch)
        self._vectors[:, 0] = self.octets.ctypes.data + steps * size
        self._vectors[:, 1] = size
        self._headers[:, 0] = self.names.ctypes.data + steps * NAME
        self._headers[:, 1] = NAME
        self._headers[:, 2] = self._vectors.ctypes.data + steps * 16
        self._headers[:, 3] = 1
        self._headers[:, 4] = self._control.ctypes.data + steps * CONTROL
        self._headers[:, 5] = CONTROL
        self._pointer = self._headers.ctypes.data
        self._take_headers = take_headers
        self._receive = recvmmsg()
        self._take(0, 0)  # compiles before the first datagram comes

    def _take(self, count: int, now_ns: int) -> None:
        self.bytes = self._take_headers(
            self._headers, self._control, count, now_ns, self.lengths, self.stamp_ns, self._drops
        )

    @property
    def dropped(self) -> int:
        """Datagrams that the kernel dropped for want of room, in all."""
        return int(self._drops[1])

    def of_new_socket(self) -> None:
        """Forget the count of an earlier socket; what was dropped stays counted."""
        self._drops[0] = 0

    def receive(self, sock: socket.socket) -> int:
        """Take in what has arrived, as far as there is room; how many datagrams. Never waits."""
        limit = len(self.lengths)
        count = self._receive(sock.fileno(), self._pointer, limit, socket.MSG_DONTWAIT, None)
        if count > 0:
            self._take(count, time_ns())
            return count
        code = ctypes.get_errno() if count < 0 else 0
        if code and code not in TRANSIENT:
            raise OSError(code, os.strerror(code))
        return 0


@cache
def recvmmsg() -> Call:
    """The system's call, which takes in many datagrams at once."""
    known = sys.platform == "linux" and sys.byteorder == "little"
    if not known or ctypes.sizeof(ctypes.c_void_p) != 8:
        raise InputError("UDP and SocketCAN are asked for, expected Linux of 64 bits")
    call = ctypes.CDLL(None, use_errno=True).recvmmsg
    call.restype = ctypes.c_int
    call.argtypes = [
        ctypes.c_int, ctypes.c_void_p, ctypes.c_uint, ctypes.c_int, ctypes.c_void_p,
    ]  # fmt: skip
    return cast(Call, call)


def address_from_octets(octets: bytes) -> Address:
    """Address of the bytes of struct sockaddr_in or sockaddr_in6."""
    (family,) = struct.unpack_from("=H", octets)
    if family == socket.AF_INET6:
        port, flow = struct.unpack_from(">HI", octets, 2)
        (scope,) = struct.unpack_from("=I", octets, 24)
        return socket.inet_ntop(socket.AF_INET6, octets[8:24]), port, flow, scope
    return socket.inet_ntop(socket.AF_INET, octets[4:8]), struct.unpack_from(">H", octets, 2)[0]


def set_options(sock: socket.socket) -> int:
    """Ask for large buffers, stamps and drop counts; bytes of the receive buffer that it got.

    What the system does not know is left out: stamps are then the caller's, and drops unseen.
    """
    sock.setblocking(False)
    for forced, option, size in (
        (SO_RCVBUFFORCE, socket.SO_RCVBUF, RECEIVE_BUFFER),
        (SO_SNDBUFFORCE, socket.SO_SNDBUF, SEND_BUFFER),
    ):
        # without the system's limit where that is permitted, else up to it
        if not _is_set(sock, forced, size):
            _is_set(sock, option, size)
    for option in (SO_TIMESTAMPNS, SO_RXQ_OVFL):
        _is_set(sock, option, 1)
    return sock.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)


def buffer_note(label: str, size: int) -> str:
    """What to say of a receive buffer of `size` bytes; empty if it is as large as was asked for."""
    if size == 0 or size >= RECEIVE_BUFFER:
        return ""
    return (
        f"{label}: its receive buffer has {size // 1024} kB, expected {RECEIVE_BUFFER // 1024}: "
        "what comes while the engine is late may be dropped, which is counted; "
        f"sysctl net.core.rmem_max={RECEIVE_BUFFER} allows more"
    )


def _is_set(sock: socket.socket, option: int, value: int) -> bool:
    try:
        sock.setsockopt(socket.SOL_SOCKET, option, value)
    except OSError:
        return False
    return True


class Place(NamedTuple):
    """An address that the system can use."""

    family: int
    address: Address


def resolved(host: str, port: int, name: str) -> Place:
    """Address of a host."""
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
    except (OSError, UnicodeError) as error:
        raise InputError(
            f"{name} is {host!r}, expected an address or a host's name: {error}"
        ) from None
    family, _, _, _, address = found[0]
    return Place(int(family), cast(Address, address))


def peer_from_text(text: str) -> Place:
    """Address of a peer."""
    host, _, port = text.rpartition(":")
    if not host or not port.isdigit() or not 0 < int(port) < 65536:
        raise InputError(f"peer is {text!r}, expected host:port, as in 127.0.0.1:43113")
    return resolved(host.strip("[]"), int(port), "peer")


def unicast_socket(own: Place) -> tuple[socket.socket, int]:
    """Bound socket for both directions; the bytes of its receive buffer."""
    sock = socket.socket(own.family, socket.SOCK_DGRAM)
    try:
        size = set_options(sock)
        sock.bind(own.address)
    except BaseException:
        sock.close()
        raise
    return sock, size


def address_of(sock: socket.socket | None) -> tuple[str, int]:
    """Host and port at which a socket listens; ("", 0) of none."""
    if sock is None:
        return "", 0
    host, port = sock.getsockname()[:2]
    return str(host), int(port)


def let_go(sock: socket.socket | None) -> None:
    """Close, whatever state it is in."""
    if sock is not None:
        with suppress(OSError):
            sock.close()

"""Datagrams of UDP and of CAN in batches: one system call takes in all there are."""

import ctypes
import errno
import os
import socket
import struct
import sys
from collections.abc import Callable
from functools import cache
from time import time_ns
from typing import cast

import numpy as np

from skinfield.errors import InputError, Ints
from skinfield.signal.block import Octets
from skinfield.wire.links import Address, BreakingLink, LinkAddress, let_go

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


class DatagramLink(BreakingLink):
    """Bound socket of UDP, or of what a subclass opens, that takes in datagrams in batches.

    Nothing is allocated after the beginning.

    Parameters
    ----------
    label : str
    batch : int
        Datagrams of one call.
    longest : int, bytes
        Of a datagram that is understood; longer ones are marked.
    own : LinkAddress, optional
        Where the socket is bound.
    peer : LinkAddress, optional
        To send to.

    Attributes
    ----------
    octets : (batch, longest) uint8 array
        Datagrams of the last batch.
    lengths : (batch,) int64 array
        -1 of a datagram that was longer than `longest`.
    stamp_ns : (batch,) int64 array, ns
        When the kernel took it in, else when it was read.
    names : (batch, 32) uint8 array
        Senders, as struct sockaddr_in or sockaddr_in6; see `address_from_octets`.
    note : str
        What should be known of it, in words.
    """

    def __init__(
        self,
        label: str,
        batch: int,
        longest: int,
        own: LinkAddress | None = None,
        peer: LinkAddress | None = None,
    ) -> None:
        from skinfield.wire.can.kernel import CONTROL, NAME, take_headers

        super().__init__(label)
        self._own, self.note = own, ""
        self._peer: Address | None = None if peer is None else peer.address
        self._socket: socket.socket | None = None
        self.octets: Octets = np.zeros((batch, longest), np.uint8)
        self.lengths: Ints = np.zeros(batch, np.int64)
        self.stamp_ns: Ints = np.zeros(batch, np.int64)
        self.names: Octets = np.zeros((batch, NAME), np.uint8)
        self._control = np.zeros(batch * CONTROL // 4, np.uint32)
        self._drops: Ints = np.zeros(2, np.int64)
        self._headers: Ints = np.zeros((batch, 8), np.int64)
        self._vectors: Ints = np.zeros((batch, 2), np.int64)
        steps = np.arange(batch)
        self._vectors[:, 0] = self.octets.ctypes.data + steps * longest
        self._vectors[:, 1] = longest
        self._headers[:, 0] = self.names.ctypes.data + steps * NAME
        self._headers[:, 1] = NAME
        self._headers[:, 2] = self._vectors.ctypes.data + steps * 16
        self._headers[:, 3] = 1
        self._headers[:, 4] = self._control.ctypes.data + steps * CONTROL
        self._headers[:, 5] = CONTROL
        self._pointer = self._headers.ctypes.data
        self._take_headers, self._receive = take_headers, recvmmsg()
        self._note_headers(0, 0)  # compiles before the first datagram comes

    def _note_headers(self, count: int, now_ns: int) -> None:
        self._take_headers(
            self._headers, self._control, count, now_ns, self.lengths, self.stamp_ns, self._drops
        )

    @property
    def address(self) -> tuple[str, int]:
        """Host and port at which it listens; ("", 0) while it is down."""
        if self._socket is None:
            return "", 0
        host, port = self._socket.getsockname()[:2]
        return str(host), int(port)

    @property
    def dropped(self) -> int:
        """Datagrams that the kernel dropped for want of room, in all."""
        return int(self._drops[1])

    def _open(self) -> bool:
        self.close()
        assert self._own is not None
        try:
            return self._use(bound_socket(self._own))
        except OSError as error:
            return bool(self.broke(error))

    def _use(self, sock: socket.socket) -> bool:
        """Take over an open socket, which counts what it dropped from 0 on."""
        self._socket, self._drops[0] = sock, 0
        self.note = set_options(sock, self.label)
        return self._opened(sock.fileno())

    def fill(self) -> int:
        """Take in the next batch of what has arrived; how many datagrams. Never waits."""
        if self._socket is None:
            return 0
        limit = len(self.lengths)
        number = self._socket.fileno()
        count = self._receive(number, self._pointer, limit, socket.MSG_DONTWAIT, None)
        if count > 0:
            self._note_headers(count, time_ns())
            return count
        code = ctypes.get_errno() if count < 0 else 0
        return self.broke(os.strerror(code)) if code and code not in TRANSIENT else 0

    def put(self, datagram: bytes) -> bool:
        """Send a datagram; False if the system did not take it, or nobody is known whom to."""
        try:
            return self._socket is not None and self._put(self._socket, datagram)
        except OSError as error:
            if error.errno not in TRANSIENT:
                self.broke(error)
            return False

    def _put(self, sock: socket.socket, datagram: bytes) -> bool:
        if self._peer is None:
            return False
        sock.sendto(datagram, self._peer)
        return True

    def close(self) -> None:
        """Let go of the socket."""
        let_go(self._socket)
        self._socket, self.up, self.fault = None, False, "closed"


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


def bound_socket(own: LinkAddress) -> socket.socket:
    """Socket of UDP that is bound, for both directions, and never waits."""
    sock = socket.socket(own.family, socket.SOCK_DGRAM)
    try:
        sock.bind(own.address)
    except OSError:
        sock.close()
        raise
    sock.setblocking(False)
    return sock


def set_options(sock: socket.socket, label: str) -> str:
    """Ask for large buffers, stamps and drop counts; a sentence if it got a smaller buffer.

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
    size = sock.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)
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

"""Datagrams of UDP and of CAN in batches: one system call takes in or sends all there are."""

import ctypes
import errno
import socket
import struct
import sys
from collections.abc import Callable
from contextlib import suppress
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
NAME = 32  # bytes for any address of IPv4 and IPv6
HEADER = 64  # bytes of struct mmsghdr
CONTROL = 64  # bytes for the control messages of a datagram: a stamp takes 32, drops 24
TRANSIENT = {  # of a send or a receive: nothing is broken, less or nothing went through
    errno.EAGAIN,
    errno.EWOULDBLOCK,
    errno.EINTR,
    errno.ENOBUFS,
    errno.ENOMEM,
    errno.ECONNREFUSED,  # nobody listens there now: datagrams ask for no answer
}


class Datagrams:
    """Room for a batch of datagrams; nothing is allocated after the beginning.

    Where the system has no `recvmmsg` and `sendmmsg`, one call per datagram does the same.

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
        Addresses as struct sockaddr_in or sockaddr_in6: senders, after `receive`.
    bytes : int
        Of the last batch.
    """

    def __init__(self, batch: int, size: int) -> None:
        self.octets: Octets = np.zeros((batch, size), np.uint8)
        self.flat: Octets = self.octets.reshape(-1)
        self.lengths: Ints = np.zeros(batch, np.int64)
        self.stamp_ns: Ints = np.zeros(batch, np.int64)
        self.names: Octets = np.zeros((batch, NAME), np.uint8)
        self.bytes = 0
        self._control = np.zeros(batch * CONTROL // 4, np.uint32)
        self._drops: Ints = np.zeros(2, np.int64)
        self._headers: Ints = np.zeros((batch, 8), np.int64)
        self._vectors: Ints = np.zeros((batch, 2), np.int64)
        self._receive = many_at_once("recvmmsg")
        self._send = many_at_once("sendmmsg")
        self._rows = [memoryview(row) for row in self.octets]
        self._point()
        self._warm()

    def _point(self) -> None:
        """Fill in what the headers point at."""
        batch, size = self.octets.shape
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

    def _warm(self) -> None:
        """Compile before the first datagram comes."""
        from skinfield.wire.can.kernel import take_headers

        self._take_headers = take_headers
        self._take(0, 0)

    def _take(self, count: int, now_ns: int) -> None:
        self.bytes = self._take_headers(
            self._headers,
            self._control,
            count,
            now_ns,
            self.lengths,
            self.stamp_ns,
            self._drops,
            NAME,
            CONTROL,
        )

    def __len__(self) -> int:
        return len(self.lengths)

    @property
    def dropped(self) -> int:
        """Datagrams that the kernel dropped for want of room, in all; 0 where it does not tell."""
        return int(self._drops[1])

    def of_new_socket(self) -> None:
        """Forget the count of an earlier socket; what was dropped stays counted."""
        self._drops[0] = 0

    def receive(self, sock: socket.socket, limit: int) -> int:
        """Take in up to `limit` datagrams that have arrived; never waits.

        Returns
        -------
        int
            Datagrams, or minus the errno of an error that is not transient.
        """
        limit = min(limit, len(self.lengths))
        if self._receive is None:
            return self._receive_singly(sock, limit)
        count = self._receive(sock.fileno(), self._pointer, limit, socket.MSG_DONTWAIT, None)
        if count > 0:
            self._take(count, time_ns())
            return count
        code = ctypes.get_errno() if count < 0 else 0
        if code == errno.ENOSYS:  # the library has it, the system does not
            self._receive = None
        return _verdict(code) if code != errno.ENOSYS else 0

    def _receive_singly(self, sock: socket.socket, limit: int) -> int:
        self.bytes = 0
        for i in range(limit):
            try:
                length, _, flags, sender = sock.recvmsg_into([self._rows[i]])
            except OSError as error:
                return i or _verdict(error.errno or errno.EIO)
            self.bytes += length
            self.lengths[i] = -1 if flags & socket.MSG_TRUNC else length
            self.stamp_ns[i] = time_ns()
            if sock.family in (socket.AF_INET, socket.AF_INET6) and sender:
                name = np.frombuffer(address_octets(sock.family, sender), np.uint8)
                self.names[i, : len(name)] = name
        return limit

    def address(self, name: Octets) -> None:
        """Address all datagrams to `name`, the octets of a struct sockaddr_in or sockaddr_in6."""
        self.names[:, : len(name)] = name
        family = int(self.names[0, 0])
        self._headers[:, 1] = 28 if family == socket.AF_INET6 else 16

    def send(self, sock: socket.socket, count: int, connected: bool) -> int:
        """Send the first `count` datagrams of `lengths`; never waits.

        Parameters
        ----------
        connected : bool
            Whether the socket knows where to, else what `address` was given last.

        Returns
        -------
        int
            Datagrams that the system took, or minus the errno of an error that is not transient.
        """
        if self._send is None:
            return self._send_singly(sock, count, connected)
        self._vectors[:count, 1] = self.lengths[:count]
        self._headers[:count, 5] = 0
        if connected:
            self._headers[:count, 1] = 0
        done = 0
        while done < count:
            sent = self._send(
                sock.fileno(), self._pointer + done * HEADER, count - done, socket.MSG_DONTWAIT
            )
            if sent <= 0:
                code = ctypes.get_errno()
                if code == errno.ENOSYS:
                    self._send = None
                    return self._send_singly(sock, count, connected)
                return done or _verdict(code)
            done += sent
        return done

    def _send_singly(self, sock: socket.socket, count: int, connected: bool) -> int:
        for i in range(count):
            octets = self._rows[i][: self.lengths[i]]
            try:
                if connected:
                    sock.send(octets)
                else:
                    sock.sendto(octets, address_from_octets(self.names[i].tobytes()))
            except OSError as error:
                return i or _verdict(error.errno or errno.EIO)
        return count


def _verdict(code: int) -> int:
    return 0 if code == 0 or code in TRANSIENT else -code


def many_at_once(name: str) -> Call | None:
    """`recvmmsg` or `sendmmsg`; None where the system, or the layout of its structures, differs."""
    if sys.platform != "linux" or sys.byteorder != "little" or ctypes.sizeof(ctypes.c_void_p) != 8:
        return None
    try:
        call = getattr(ctypes.CDLL(None, use_errno=True), name)
    except (OSError, AttributeError):
        return None
    receives = name == "recvmmsg"
    call.restype = ctypes.c_int
    call.argtypes = [ctypes.c_int, ctypes.c_void_p, ctypes.c_uint, ctypes.c_int] + (
        [ctypes.c_void_p] if receives else []
    )
    return cast(Call, call)


def address_octets(family: int, address: tuple[str | int, ...]) -> bytes:
    """Bytes of struct sockaddr_in or sockaddr_in6."""
    host, port = str(address[0]), int(address[1])
    if family == socket.AF_INET6:
        flow, scope = (int(each) for each in (*address[2:4], 0, 0)[:2])
        host_octets = socket.inet_pton(socket.AF_INET6, host.partition("%")[0])
        return (
            struct.pack("=H", family)
            + struct.pack(">HI", port, flow)
            + host_octets
            + struct.pack("=I", scope)
        )
    return (
        struct.pack("=H", family)
        + struct.pack(">H", port)
        + socket.inet_pton(socket.AF_INET, host)
        + bytes(8)
    )


def address_from_octets(octets: bytes) -> tuple[str | int, ...]:
    """The same the other way round."""
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
    _enlarge(sock, SO_RCVBUFFORCE, socket.SO_RCVBUF, RECEIVE_BUFFER)
    _enlarge(sock, SO_SNDBUFFORCE, socket.SO_SNDBUF, SEND_BUFFER)
    if sys.platform == "linux":
        for option in (SO_TIMESTAMPNS, SO_RXQ_OVFL):
            _try(sock, option, 1)
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


def _enlarge(sock: socket.socket, force: int, ordinary: int, size: int) -> None:
    """Without the system's limit where that is permitted, else up to it."""
    if not (sys.platform == "linux" and _try(sock, force, size)):
        _try(sock, ordinary, size)


def _try(sock: socket.socket, option: int, value: int) -> bool:
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
    """Address of a host.

    Raises
    ------
    InputError
        If it is not understood.
    """
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
    except (OSError, UnicodeError) as error:
        raise InputError(
            f"{name} is {host!r}, expected an address or a host's name: {error}"
        ) from None
    family, _, _, _, address = found[0]
    return Place(int(family), cast(Address, address))


def peer_from_text(text: str) -> Place:
    """Address of a peer.

    Raises
    ------
    InputError
        If it is no host and port, or the host is not understood.
    """
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


def let_go(sock: socket.socket | None) -> None:
    """Close, whatever state it is in."""
    if sock is not None:
        with suppress(OSError):
            sock.close()

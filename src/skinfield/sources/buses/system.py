"""What Linux offers for many datagrams in one call, reached without a compiler."""

import ctypes
import socket
import struct
import sys
from collections.abc import Callable
from typing import cast

Call = Callable[..., int]

SO_TIMESTAMPNS = 35  # asm-generic/socket.h; Python does not name these
SO_RXQ_OVFL = 40
SO_RCVBUFFORCE = 33
SO_SNDBUFFORCE = 32
RECEIVE_BUFFER = 8 << 20  # bytes: about 20 000 datagrams of one CAN message each
SEND_BUFFER = 2 << 20
NAME = 32  # bytes for any address of IPv4 and IPv6


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

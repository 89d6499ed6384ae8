"""Links of live sources: connections that break and come back, without ever waiting."""

import errno
import os
import select
import socket
from collections.abc import Iterator, Sequence
from contextlib import suppress
from time import monotonic
from typing import NamedTuple, cast

from skinfield.errors import InputError
from skinfield.signal.block import Octets

Address = tuple[str | int, ...]

PATIENCE = 3.0  # s, after which an attempt to connect, or a silent peer, is given up


class LinkAddress(NamedTuple):
    """An address that the system can use."""

    family: int
    address: Address


def resolved(host: str, port: int, name: str) -> LinkAddress:
    """Address of a host."""
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
    except (OSError, UnicodeError) as error:
        raise InputError(
            f"{name} is {host!r}, expected an address or a host's name: {error}"
        ) from None
    family, _, _, _, address = found[0]
    return LinkAddress(int(family), cast(Address, address))


def host_and_port(text: str, host: str, port: int) -> tuple[str, int]:
    """Host and port from ``"192.0.2.7:5000"``, ``"[::1]:5000"``, ``"192.0.2.7"`` or ``":5000"``.

    Parameters
    ----------
    text : str
    host, port
        Where the text does not say.

    Raises
    ------
    InputError
        If the port is none.
    """
    before, colon, after = text.rpartition(":")
    if not colon or "]" in after or (":" in before and not before.startswith("[")):
        before, after = text, ""
    if after and not (after.isdecimal() and int(after) <= 65535):
        raise InputError(f"port of {text!r} is {after!r}, expected a number from 0 to 65535")
    return before.strip("[]") or host, int(after) if after else port


def place_text(host: str, port: int) -> str:
    """As `host_and_port` reads it."""
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"


def peer_from_text(text: str) -> LinkAddress | None:
    """Address of a peer; None where the text is empty."""
    host, port = host_and_port(text, "", 0)
    if text and not (host and port):
        raise InputError(f"peer is {text!r}, expected host:port, as in 127.0.0.1:43113")
    return resolved(host, port, "peer") if text else None


def let_go(sock: socket.socket | None) -> None:
    """Close, whatever state it is in."""
    if sock is not None:
        with suppress(OSError):
            sock.close()


class BreakingLink:
    """Connection that breaks and is opened again: a bus, a socket, a device. Nothing waits.

    Parameters
    ----------
    label : str
        By which it is named in words.

    Attributes
    ----------
    up : bool
        Whether something can come.
    fault : str
        Why it is down, in words.
    """

    def __init__(self, label: str) -> None:
        self.label, self._number = label, -1
        self.up, self.fault = False, ""

    def reopen(self) -> bool:
        """Try to get it back, without waiting; whether it is up now."""
        try:
            return self._open()
        except InputError as error:
            self.fault = str(error)
            return False

    def _open(self) -> bool:
        """As `reopen`; InputError where it can never be opened."""
        raise NotImplementedError

    def close(self) -> None:
        """Let go of it."""
        raise NotImplementedError

    def _opened(self, number: int) -> bool:
        """Note that it is up, by which file descriptor; -1 where it has none."""
        self._number, self.up, self.fault = number, True, ""
        return True

    def broke(self, error: Exception | str) -> int:
        """Let go of a connection that is of no use any more; 0."""
        self.close()
        self.fault = f"{self.label}: {getattr(error, 'strerror', None) or error}"
        return 0

    def filenos(self) -> Sequence[int]:
        """File descriptors that become readable when something arrives, while it is up."""
        return (self._number,) if self.up and self._number >= 0 else ()


class ByteLink(BreakingLink):
    """Connection that carries bytes both ways."""

    def receive(self, into: Octets) -> int:
        """Write what has arrived, as far as there is room; how many bytes. Never waits."""
        raise NotImplementedError

    def put(self, data: bytes) -> bool:
        """Send a few bytes, as far as they go; a peer that does not read gets them too late."""
        try:
            return self.up and os.write(self._number, data) > 0
        except (BlockingIOError, InterruptedError):
            return False
        except OSError as error:
            return bool(self.broke(error))


class DialledLink(ByteLink):
    """Connection to a TCP server.

    Parameters
    ----------
    label : str
    place : LinkAddress
        Of the server.
    """

    def __init__(self, label: str, place: LinkAddress) -> None:
        super().__init__(label)
        self._place = place
        self._socket: socket.socket | None = None
        self._talk: Iterator[None] | None = None  # what is said before it is up; None: nothing is
        self._begun = 0.0
        self.reopen()

    def _open(self) -> bool:
        """Begin to connect, unless that goes on already."""
        late = self._talk is not None and monotonic() - self._begun >= PATIENCE
        if late:
            self.broke(f"no answer within {PATIENCE:g} s")
        if self._talk is None:
            self.fault = self.fault or f"{self.label}: connecting"
            self._begun, self._talk = monotonic(), self._opening()
        return self.advance()

    @property
    def connecting(self) -> bool:
        """Whether it is on its way to be up."""
        return self._talk is not None

    def advance(self) -> bool:
        """Go on connecting as far as it goes without waiting; whether it is up."""
        if self._talk is not None:
            try:
                next(self._talk)
            except StopIteration:
                self._talk = None
                assert self._socket is not None
                self._opened(self._socket.fileno())
            except (OSError, InputError) as error:
                self.broke(error)
        return self.up

    def _opening(self) -> Iterator[None]:
        """Connect, and say what comes first; a step wherever something is to be waited for."""
        yield from self._connected(self._place, b"")

    def _connected(self, place: LinkAddress, hello: bytes) -> Iterator[None]:
        """Connect, and say `hello`, a few bytes."""
        let_go(self._socket)
        self._socket = sock = socket.socket(place.family, socket.SOCK_STREAM)
        sock.setblocking(False)
        watch_over(sock)
        code = sock.connect_ex(place.address)
        if code not in (0, errno.EINPROGRESS):
            raise OSError(code, os.strerror(code))
        poll = select.poll()
        poll.register(sock, select.POLLOUT)
        while not poll.poll(0):
            yield
        code = sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        if code:
            raise OSError(code, os.strerror(code))
        sock.sendall(hello)  # some bytes into an empty buffer

    def receive(self, into: Octets) -> int:
        """See `ByteLink`."""
        if self._socket is None or not self.up:
            self.advance()  # what it brings is read once all know that it is up
            return 0
        try:
            count = self._socket.recv_into(into.data)
        except (BlockingIOError, InterruptedError):
            return 0
        except OSError as error:
            return self.broke(error)
        return count or self.broke("the other side closed the connection")

    def close(self) -> None:
        """Let go of the connection."""
        let_go(self._socket)
        self._socket, self._talk, self.up = None, None, False


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

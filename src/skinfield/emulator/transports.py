"""Transports of a virtual skin: the links of its packets, and its control socket."""

import json
import os
import socket
import tty
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from skinfield.emulator.hardware import Fates, Wire
from skinfield.emulator.settings import VirtualSettings
from skinfield.errors import FileError, InputError, SkinfieldError
from skinfield.wire.can.bus import host_and_port
from skinfield.wire.sources.packets import TCP_PORT, UDP_PORT

LISTEN = "listen"
READ_BYTES = 4096  # bytes in one reading
SEND_BUFFER = 1 << 20  # bytes
DATAGRAMS = 64


class Link(Wire[bytes]):
    """The bus of devices that send packets; never waits.

    Attributes
    ----------
    made : list of bytes
        Packets to send.
    address : str
        Where a host finds it.
    heard : bool
        Whether somebody is there to send to, as far as is known.
    """

    address: str
    heard: bool

    def __init__(self, fates: Fates[bytes]) -> None:
        super().__init__(fates)
        self.made: list[bytes] = []

    def _message(self, row: int) -> bytes:
        return self.made[row]

    def _put_all(self, count: int) -> None:
        self._put(self.made[:count])

    def _put(self, messages: Sequence[bytes]) -> None:
        for message in messages:
            if self._take(message):
                self.sent += 1
            else:
                self.refused += 1

    def say(self, packet: bytes) -> None:
        """Send a packet whatever else may happen on the way."""
        self._put([packet])

    def _take(self, packet: bytes) -> bool:
        """Send a packet; False if it was not taken, and then none of it was."""
        raise NotImplementedError

    def receive(self) -> bytes:
        """What hosts have said."""
        raise NotImplementedError


def open_link(settings: VirtualSettings, fates: Fates[bytes]) -> Link:
    """The link of the settings; their first channel says where.

    Raises
    ------
    InputError
        If it cannot be opened.
    """
    if len(settings.channels) > 1:
        raise InputError(f"channels are {list(settings.channels)}, expected one: all devices share")
    channel = settings.channels[0] if settings.channels else ""
    kind = {"udp": UdpLink, "tcp": TcpLink, "serial": TerminalLink}[settings.bus]
    try:
        return kind(fates, channel)
    except (OSError, UnicodeError) as error:
        raise InputError(
            f"{settings.bus} cannot be opened at {channel!r}: {error}, expected an address that "
            "is free: choose another with --channel"
        ) from error


def place_of(sock: socket.socket) -> str:
    """Where a socket is bound, as host:port."""
    host, port = sock.getsockname()[:2]
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"


class UdpLink(Link):
    """Datagrams to a host, or to whoever asked last.

    Parameters
    ----------
    channel : str
        ``host:port`` of a host that listens; or ``listen:host:port`` to be asked there.
    """

    def __init__(self, fates: Fates[bytes], channel: str) -> None:
        super().__init__(fates)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._peer: tuple[str, int] | None = None
        word, _, rest = channel.partition(":")
        try:
            if word == LISTEN:
                self._socket.bind(host_and_port(rest, "127.0.0.1", 0))
            else:
                self._peer = host_and_port(channel, "127.0.0.1", UDP_PORT)
                local = "127.0.0.1" if self._peer[0] in ("127.0.0.1", "localhost") else ""
                self._socket.bind((local, 0))
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
            self._socket.setblocking(False)
        except BaseException:
            self._socket.close()
            raise
        self.address, self.heard = place_of(self._socket), self._peer is not None

    def _take(self, packet: bytes) -> bool:
        if self._peer is None:
            return False
        try:
            self._socket.sendto(packet, self._peer)
        except OSError:
            return False
        return True

    def receive(self) -> bytes:
        """See `Link`."""
        received = b""
        for _ in range(DATAGRAMS):
            try:
                data, self._peer = self._socket.recvfrom(READ_BYTES)
                self.heard = True
            except OSError:
                break
            received += data
        return received

    def filenos(self) -> Sequence[int]:
        """See `Wire`."""
        return (self._socket.fileno(),)

    def _let_go(self) -> None:
        self._socket.close()


class _Bytes(Link):
    """A stream of bytes that takes whole packets; what does not fit goes before the next."""

    _rest = b""

    def _write(self, data: bytes) -> int:
        """Bytes taken, 0 if none; raises BrokenPipeError when the other side is gone."""
        raise NotImplementedError

    def _take(self, packet: bytes) -> bool:
        if self._rest:
            self._rest = self._rest[self._write(self._rest) :]
        if self._rest:
            return False
        taken = self._write(packet)
        if taken == 0:
            return False
        self._rest = packet[taken:]
        return True


class TcpLink(_Bytes):
    """A server with one host at a time; who comes later takes over."""

    def __init__(self, fates: Fates[bytes], channel: str) -> None:
        super().__init__(fates)
        self._server = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        self._client: socket.socket | None = None
        try:
            self._server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self._server.bind(host_and_port(channel, "127.0.0.1", TCP_PORT))
            self._server.listen(1)
            self._server.setblocking(False)
        except BaseException:
            self._server.close()
            raise
        self.address, self.heard = place_of(self._server), False

    def _write(self, data: bytes) -> int:
        if self._client is None:
            return 0
        try:
            return self._client.send(data)
        except (BlockingIOError, InterruptedError):
            return 0
        except OSError:
            self._drop()
            return 0

    def _drop(self) -> None:
        if self._client is not None:
            self._client.close()
        self._client, self._rest, self.heard = None, b"", False

    def receive(self) -> bytes:
        """See `Link`."""
        with suppress(OSError):
            client, _ = self._server.accept()
            self._drop()
            client.setblocking(False)
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._client, self.heard = client, True
        if self._client is None:
            return b""
        try:
            received = self._client.recv(READ_BYTES)
        except (BlockingIOError, InterruptedError):
            return b""
        except OSError:
            received = b""
        if not received:
            self._drop()
        return received

    def filenos(self) -> Sequence[int]:
        """See `Wire`."""
        client = () if self._client is None else (self._client.fileno(),)
        return (self._server.fileno(), *client)

    def _let_go(self) -> None:
        self._drop()
        self._server.close()


class TerminalLink(_Bytes):
    """A pseudo-terminal, as a microcontroller at USB looks.

    Parameters
    ----------
    channel : str
        Path of a link to it, which must not be there; empty for none.
    """

    def __init__(self, fates: Fates[bytes], channel: str) -> None:
        super().__init__(fates)
        self._near, self._far = os.openpty()
        self._link = Path(channel) if channel else None
        tty.setraw(self._far)
        os.set_blocking(self._near, False)
        self.address = os.ttyname(self._far)
        self.heard = True
        if self._link is not None:
            try:
                self._link.symlink_to(self.address)
                self.address = channel
            except OSError as error:
                self._link = None
                self._let_go()
                raise FileError(f"{channel} cannot be made: {error.strerror}") from error

    def _write(self, data: bytes) -> int:
        try:
            return os.write(self._near, data)
        except OSError:
            return 0

    def receive(self) -> bytes:
        """See `Link`."""
        try:
            return os.read(self._near, READ_BYTES)
        except OSError:
            return b""

    def filenos(self) -> Sequence[int]:
        """See `Wire`."""
        return (self._near,)

    def _let_go(self) -> None:
        for number in (self._near, self._far):
            with suppress(OSError):
                os.close(number)
        if self._link is not None:
            self._link.unlink(missing_ok=True)
            self._link = None


LONGEST = 4096  # bytes of a command
ANSWER = 60_000  # bytes of an answer: one datagram
PER_POLL = 64  # commands, so that a flood of them delays no reading for long

Command = Callable[[Mapping[str, Any]], dict[str, Any]]


def answer_to(data: bytes, commands: Mapping[str, Command]) -> dict[str, Any]:
    """Do what a datagram says; ``{"ok": true, ...}``, or false with the error in words.

    A `tag` in the command comes back in the answer.

    Parameters
    ----------
    data : bytes
        Anything.
    commands : mapping
        By the value of `do`.
    """
    tag: Any = None
    try:
        if len(data) > LONGEST:
            raise InputError(f"command has {len(data)} bytes, expected at most {LONGEST}")
        try:
            fields = json.loads(data.decode())
        except (ValueError, RecursionError) as error:
            raise InputError(f"command is no JSON: {error}, expected an object") from error
        if not isinstance(fields, dict):
            raise InputError("command is no plain object, expected one such as {'do': 'counts'}")
        tag, name = fields.pop("tag", None), fields.pop("do", None)
        if not isinstance(name, str) or name not in commands:
            raise InputError(f"do is {name!r:.60}, expected one of {', '.join(sorted(commands))}")
        answer = {"ok": True, **commands[name](fields)}
    except SkinfieldError as error:
        answer = {"ok": False, "error": str(error)[:2000]}
    return answer if tag is None else {"tag": tag, **answer}


class Control:
    """A bound socket that answers.

    Parameters
    ----------
    address : str
        ``"127.0.0.1:0"``.
    commands : mapping of str to function
        What `do` can be.

    Raises
    ------
    InputError
        If the address cannot be bound.
    """

    def __init__(self, address: str, commands: Mapping[str, Command]) -> None:
        place = host_and_port(address, "127.0.0.1", 0)
        self._commands = commands
        family = socket.AF_INET6 if ":" in place[0] else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        try:
            self._socket.bind(place)
        except (OSError, UnicodeError) as error:
            self._socket.close()
            raise InputError(
                f"control is {address!r}, expected an address of this machine that is free: {error}"
            ) from error
        self._socket.setblocking(False)

    @property
    def address(self) -> str:
        """Where it is reached."""
        return place_of(self._socket)

    def fileno(self) -> int:
        """Of the socket."""
        return self._socket.fileno()

    def poll(self) -> None:
        """Do and answer what has arrived; never waits."""
        for _ in range(PER_POLL):
            try:
                data, sender = self._socket.recvfrom(LONGEST + 1)
            except OSError:
                return  # nothing more, or an answer that met nobody
            answer = encoded(answer_to(data, self._commands))
            try:
                self._socket.sendto(answer, sender)
            except OSError:
                continue  # who asked is gone

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


def encoded(answer: Mapping[str, Any]) -> bytes:
    """Bytes of an answer, or of the error that it is too long."""
    data = json.dumps(answer).encode()
    if len(data) > ANSWER:
        short = {"ok": False, "error": f"the answer has {len(data)} bytes: ask for less at once"}
        return json.dumps({**short, "tag": answer["tag"]} if "tag" in answer else short).encode()
    return data

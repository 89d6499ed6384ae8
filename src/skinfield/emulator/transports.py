"""Transports of a virtual skin: the links of its packets, and its control socket."""

import json
import os
import socket
import tty
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from skinfield.emulator.hardware import Wire
from skinfield.emulator.scenes import FINGER, Place
from skinfield.emulator.settings import PROBABILITY, VirtualSettings
from skinfield.errors import FileError, InputError, SkinfieldError
from skinfield.settings import Range, from_plain
from skinfield.wire.datagrams import bound_socket
from skinfield.wire.links import host_and_port, place_text, resolved
from skinfield.wire.sources.packets import TCP_PORT, UDP_PORT

LISTEN = "listen"
READ_BYTES = 4096  # bytes in one reading
DATAGRAMS = 64


class Link(Wire[bytes]):
    """The bus of devices that send packets; never waits.

    It takes whole packets: what does not fit into a stream of bytes goes before the next.

    Parameters
    ----------
    settings : VirtualSettings
    channel : str
        Where.

    Attributes
    ----------
    made : list of bytes
        Packets to send.
    heard : bool
        Whether somebody is there to send to, as far as is known.
    """

    heard: bool
    _rest = b""  # of a packet of which a part was taken

    def __init__(self, settings: VirtualSettings, channel: str) -> None:
        super().__init__(settings, 0)
        self.made: list[bytes] = []
        self._open(channel)

    def _open(self, channel: str) -> None:
        """Open it, and set `address` and `heard`."""
        raise NotImplementedError

    def _message(self, row: int) -> bytes:
        return self.made[row]

    def _put(self, messages: Sequence[bytes]) -> None:
        for message in messages:
            self.counts["messages" if self._take(message) else "refused"] += 1

    def say(self, packet: bytes) -> None:
        """Send a packet whatever else may happen on the way."""
        self._put([packet])

    def _take(self, packet: bytes) -> bool:
        """Send a packet; False if it was not taken, and then none of it was."""
        if self._rest:
            self._rest = self._rest[self._write(self._rest) :]
        if self._rest:
            return False
        taken = self._write(packet)
        self._rest = packet[taken:] if taken else b""
        return taken > 0

    def _write(self, data: bytes) -> int:
        """Bytes taken, 0 if none."""
        raise NotImplementedError

    def receive(self) -> bytes:
        """What hosts have said."""
        raise NotImplementedError


def open_link(settings: VirtualSettings) -> Link:
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
        return kind(settings, channel)
    except (OSError, UnicodeError) as error:
        raise InputError(
            f"{settings.bus} cannot be opened at {channel!r}: {error}, expected an address that "
            "is free: choose another with --channel"
        ) from error


class UdpLink(Link):
    """Datagrams to the host of the channel, ``host:port``; or to whoever asked last.

    Of the latter the channel is ``listen:host:port``, where to ask.
    """

    _peer: tuple[str, int] | None = None

    def _open(self, channel: str) -> None:
        word, _, rest = channel.partition(":")
        own = ("0.0.0.0", 0)
        if word == LISTEN:
            own = host_and_port(rest, "127.0.0.1", 0)
        else:
            self._peer = host_and_port(channel, "127.0.0.1", UDP_PORT)
            if self._peer[0] in ("127.0.0.1", "localhost"):
                own = ("127.0.0.1", 0)
        self._socket = bound_socket(resolved(*own, "channel"))
        self.address, self.heard = (
            place_text(*self._socket.getsockname()[:2]),
            self._peer is not None,
        )

    def _write(self, data: bytes) -> int:
        try:
            return 0 if self._peer is None else self._socket.sendto(data, self._peer)
        except OSError:
            return 0

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


class TcpLink(Link):
    """A server with one host at a time; who comes later takes over."""

    _client: socket.socket | None = None

    def _open(self, channel: str) -> None:
        place = host_and_port(channel, "127.0.0.1", TCP_PORT)
        self._server = socket.create_server(place, backlog=1)
        self._server.setblocking(False)
        self.address, self.heard = place_text(*self._server.getsockname()[:2]), False

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


class TerminalLink(Link):
    """A pseudo-terminal, as a microcontroller at USB looks.

    The channel is the path of a link to it, which must not be there; empty for none.
    """

    _link: Path | None = None

    def _open(self, channel: str) -> None:
        self._near, self._far = os.openpty()
        tty.setraw(self._far)
        os.set_blocking(self._near, False)
        self.address, self.heard = os.ttyname(self._far), True
        if channel:
            try:
                Path(channel).symlink_to(self.address)
            except OSError as error:
                self._let_go()
                raise FileError(f"{channel} cannot be made: {error.strerror}") from error
            self.address, self._link = channel, Path(channel)

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


@dataclass(frozen=True, kw_only=True)
class Request(Place):
    """Fields that a command has beside `do` and `tag`, whichever are its own.

    See docs/how-to/virtual-skin.md. What is None is as it was, or as usual.
    """

    id: str | None = None
    patch: str | int | None = None
    force: Annotated[float | None, Range(1e-6, 1e4, "newtons")] = None
    shear: tuple[float, float] | None = None
    radius: float = FINGER
    shape: str = "ball"
    fault: str = ""
    kind: str | None = None
    scene: str = ""
    lose: Annotated[float | None, PROBABILITY] = None
    duplicate: Annotated[float | None, PROBABILITY] = None
    swap: Annotated[float | None, PROBABILITY] = None
    after: Annotated[int | None, Range(0, 1 << 50, "number of a line")] = None


Command = Callable[[Request], dict[str, Any]]


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
        answer = {"ok": True, **commands[name](from_plain(Request, fields))}
    except SkinfieldError as error:
        answer = {"ok": False, "error": str(error)[:2000]}
    return answer if tag is None else {"tag": tag, **answer}


class ControlServer:
    """A bound socket that answers.

    Parameters
    ----------
    address : str
        ``"127.0.0.1:0"``.
    commands : mapping of str to function
        What `do` can be.

    Attributes
    ----------
    address : str
        Where it is reached.

    Raises
    ------
    InputError
        If the address cannot be bound.
    """

    def __init__(self, address: str, commands: Mapping[str, Command]) -> None:
        self._commands = commands
        try:
            place = resolved(*host_and_port(address, "127.0.0.1", 0), "control")
            self._socket = bound_socket(place)
        except OSError as error:
            raise InputError(
                f"control is {address!r}, expected an address of this machine that is free: {error}"
            ) from error
        self.address = place_text(*self._socket.getsockname()[:2])

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

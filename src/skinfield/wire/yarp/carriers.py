"""Carriers of YARP: how a connection between two ports begins, and its messages.

As in YARP 4.0.0: `doc/020_nameserver_and_protocols/yarp_protocol.dox` and, below
`src/libYARP_os/src/yarp/os/impl`, `TextCarrier.cpp`, `TcpCarrier.cpp`, `PortCommand.cpp` and
`../AbstractCarrier.cpp`. Whoever connects sends eight bytes that name the carrier, and its own
name; the port answers with a line of welcome (text) or with eight bytes (tcp). Then messages
follow: a port command, and for ``d``, ``D`` and ``a`` a bottle. Text is written and read; tcp is
only written, as it carries what we send to readers that somebody told us to connect to.

======== ============================================================================
carrier  first eight bytes; messages are
======== ============================================================================
text     ``CONNECT``, blank; lines that end in CR LF, and are read with or without CR
text_ack ``CONNACK``, blank; the same, each message acknowledged by ``<ACK>``
tcp      ``YA E4 1E 00 00 RP``; blocks of bytes with their lengths, acknowledged
======== ============================================================================
"""

import struct
from collections.abc import Sequence
from enum import Enum

from skinfield.errors import InputError
from skinfield.wire.yarp.bottle import (
    Value,
    bytes_from_bottle,
    from_octets,
    text_from_bottle,
    to_octets,
)

HEADER = 8  # bytes
LINE_END = b"\r\n"
INDEX = 10  # bytes of an index, of which the first is the number of blocks, the second of replies
LONGEST_NAME = 1000  # bytes, as YARP reads it
LONGEST = 1 << 20  # bytes of a line


def number(value: int) -> bytes:
    """A number in YARP's eight bytes."""
    return b"YA" + struct.pack("<i", value) + b"RP"


class Carrier(Enum):
    """By YARP's own name."""

    TEXT = "text"
    TEXT_ACK = "text_ack"
    TCP = "tcp"

    @property
    def header(self) -> bytes:
        """First eight bytes of a connection."""
        return HEADERS[self]

    @property
    def is_text(self) -> bool:
        """Whether messages are lines."""
        return self is not Carrier.TCP

    @property
    def acknowledges(self) -> bool:
        """Whether each message is acknowledged by whoever reads it."""
        return self is not Carrier.TEXT


HEADERS = {
    Carrier.TEXT: b"CONNECT ",
    Carrier.TEXT_ACK: b"CONNACK ",
    Carrier.TCP: number(7777 + 3 + 128),
}


def greeting(carrier: Carrier, own: str) -> bytes:
    """What a connection begins with.

    Parameters
    ----------
    carrier : Carrier
    own : str
        Our port's name; one that does not begin with a slash belongs to no port.
    """
    name = checked_name(own)
    if carrier.is_text:
        return carrier.header + name + LINE_END
    return carrier.header + struct.pack("<i", len(name) + 1) + name + b"\0"


def message(carrier: Carrier, command: str, values: Sequence[Value] | None = None) -> bytes:
    """A whole message.

    Parameters
    ----------
    carrier : Carrier
    command : str
        Port command, such as ``d``, ``D 12 1.5``, ``a`` or ``r``.
    values : sequence of values, optional
        The bottle behind ``d``, ``D`` or ``a``.
    """
    if carrier.is_text:
        return line(command) + (b"" if values is None else line(text_from_bottle(values)))
    if len(command) == 1:
        block = bytes(4) + b"~" + to_octets(command) + b"\0\x01"
    else:
        data = to_octets(command) + b"\0"
        block = struct.pack("<i", len(data)) + b"~\0\0\x01" + data
    blocks = [block] if values is None else [block, bytes_from_bottle(values)]
    sizes = b"".join(struct.pack("<i", len(each)) for each in blocks)
    index = number(INDEX) + bytes([len(blocks), 1]) + b"\xff" * 8 + sizes + bytes(4)
    return index + b"".join(blocks)


def line(text: str) -> bytes:
    """A line of text."""
    return to_octets(text) + LINE_END


def checked_name(name: str) -> bytes:
    """A port's name as bytes.

    Raises
    ------
    InputError
        If it is empty, too long, or would end the line that it is sent on.
    """
    data = to_octets(name)
    if not 0 < len(data) <= LONGEST_NAME or any(octet <= 32 or octet == 92 for octet in data):
        raise InputError(
            f"name of a port is {name!r:.60}, expected up to {LONGEST_NAME} characters without "
            "blanks, backslashes and control characters, as /skinfield/left_arm"
        )
    return data


def envelope(sequence: int, seconds: float) -> str:
    """Stamp of a message as text: its number, and s since the epoch.

    As `src/libYARP_os/src/yarp/os/Stamp.cpp` writes it, with 16 digits in place of 15, so that
    microseconds are kept.
    """
    return f"{sequence} {seconds:.16g}"


class Lines:
    """Lines of text, without their ends.

    As in YARP's `InputStream.cpp`: CR and zero bytes are left out, and a backslash before the end
    of a line joins it with the next.

    Parameters
    ----------
    most : int, bytes
        Of one line; may be set at any time.
    """

    def __init__(self, most: int = LONGEST) -> None:
        self.most = most
        self._rest = bytearray()
        self._searched = 0  # bytes of the rest in which no line ends

    def feed(self, data: bytes) -> None:
        """Take in what came."""
        self._rest += data

    def take(self) -> str | None:
        """The next line; None if none is complete.

        Raises
        ------
        InputError
            If it is longer than allowed.
        """
        while True:
            end = self._rest.find(b"\n", self._searched)
            if (len(self._rest) if end < 0 else end) > self.most:
                raise InputError(f"a line has more than {self.most} bytes, expected no more")
            if end < 0:
                self._searched = len(self._rest)
                return None
            line = bytes(self._rest[:end].replace(b"\r", b"").replace(b"\0", b""))
            if not (len(line) - len(line.rstrip(b"\\"))) % 2:
                del self._rest[: end + 1]
                self._searched = 0
                return from_octets(line)
            self._rest[: end + 1] = line[:-1]  # joined with the next
            self._searched = len(line) - 1


def yarp_number(data: bytes | bytearray) -> int | None:
    """The number in eight bytes ``YA....RP``; None if they are others."""
    if len(data) != HEADER or data[:2] != b"YA" or data[6:] != b"RP":
        return None
    return int.from_bytes(data[2:6], "little", signed=True)

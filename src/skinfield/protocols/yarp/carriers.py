"""Carriers: how a connection between two ports begins, and what its messages look like.

As in YARP 4.0.0: `doc/020_nameserver_and_protocols/yarp_protocol.dox` and, below
`src/libYARP_os/src/yarp/os/impl`, `TextCarrier.cpp`, `TcpCarrier.cpp`, `PortCommand.cpp` and
`../AbstractCarrier.cpp`. Whoever connects sends eight bytes that name the carrier, and its own
name; the port answers with a line of welcome (text) or with eight bytes (tcp). Then messages
follow: a port command, and for ``d``, ``D`` and ``a`` a bottle.

======== ============================================================================
carrier  first eight bytes; messages are
======== ============================================================================
text     ``CONNECT``, blank; lines that end in CR LF, and are read with or without CR
text_ack ``CONNACK``, blank; the same, each message acknowledged by ``<ACK>``
tcp      ``YA E4 1E 00 00 RP``; blocks of bytes with their lengths, acknowledged
fast_tcp ``YA 64 1E 00 00 RP``; the same, not acknowledged
======== ============================================================================
"""

import struct
from collections.abc import Sequence
from enum import Enum

from skinfield.errors import InputError
from skinfield.protocols.yarp.binary import bytes_from_bottle, to_octets
from skinfield.protocols.yarp.bottle import Value, text_from_bottle

HEADER = 8  # bytes
LINE_END = b"\r\n"
ACK_LINE = b"<ACK>\r\n"
INDEX = 10  # bytes of an index, of which the first is the number of blocks, the second of replies
LONGEST_NAME = 1000  # bytes, as YARP reads it


class Carrier(Enum):
    """By YARP's own name."""

    TEXT = "text"
    TEXT_ACK = "text_ack"
    TCP = "tcp"
    FAST_TCP = "fast_tcp"

    @property
    def header(self) -> bytes:
        """First eight bytes of a connection."""
        return HEADERS[self]

    @property
    def is_text(self) -> bool:
        """Whether messages are lines."""
        return self in (Carrier.TEXT, Carrier.TEXT_ACK)

    @property
    def acknowledges(self) -> bool:
        """Whether each message is acknowledged by whoever reads it."""
        return self in (Carrier.TEXT_ACK, Carrier.TCP)


def number(value: int) -> bytes:
    """A number in YARP's eight bytes."""
    return b"YA" + struct.pack("<i", value) + b"RP"


HEADERS = {
    Carrier.TEXT: b"CONNECT ",
    Carrier.TEXT_ACK: b"CONNACK ",
    Carrier.TCP: number(7777 + 3 + 128),
    Carrier.FAST_TCP: number(7777 + 3),
}
ACK_NUMBER = number(0)


def carrier_named(name: str) -> Carrier:
    """Of that name.

    Raises
    ------
    InputError
        If it is another, or has modifiers such as ``tcp+recv.portmonitor``.
    """
    for each in Carrier:
        if each.value == name:
            return each
    known = ", ".join(each.value for each in Carrier)
    raise InputError(f"carrier is {name!r:.60}, expected one of {known}")


def carrier_from_header(header: bytes) -> Carrier | None:
    """Of a connection that begins with these eight bytes; None if it is none that is known."""
    return next((each for each in Carrier if each.header == header), None)


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


def welcome(carrier: Carrier, peer: str, port: int) -> bytes:
    """What a port answers to a greeting.

    Parameters
    ----------
    carrier : Carrier
    peer : str
        Name in the greeting.
    port : int
        Of our socket; nobody uses it.
    """
    return b"Welcome " + to_octets(peer) + LINE_END if carrier.is_text else number(port)


def message(carrier: Carrier, command: str, values: Sequence[Value] | None = None) -> bytes:
    """A whole message.

    Parameters
    ----------
    carrier : Carrier
    command : str
        Port command, such as ``d``, ``D 12 1.5``, ``a``, ``r`` or ``/reader``.
    values : sequence of values, optional
        The bottle behind ``d``, ``D`` or ``a``.
    """
    if carrier.is_text:
        line = to_octets(command) + LINE_END
        return line if values is None else line + to_octets(text_from_bottle(values)) + LINE_END
    blocks = [command_block(command)]
    if values is not None:
        blocks.append(bytes_from_bottle(values))
    return index_of(blocks) + b"".join(blocks)


def reply(carrier: Carrier, values: Sequence[Value]) -> bytes:
    """Answer to a message, which has no port command before it."""
    if carrier.is_text:
        return to_octets(text_from_bottle(values)) + LINE_END
    block = bytes_from_bottle(values)
    return index_of([block]) + block


def acknowledgement(carrier: Carrier) -> bytes:
    """What whoever read a message says; nothing where the carrier wants none."""
    if not carrier.acknowledges:
        return b""
    return ACK_LINE if carrier.is_text else ACK_NUMBER


def command_block(command: str) -> bytes:
    """A port command in bytes: one character, or text behind its length."""
    if len(command) == 1:
        return bytes(4) + b"~" + to_octets(command) + b"\0\x01"
    data = to_octets(command) + b"\0"
    return struct.pack("<i", len(data)) + b"~\0\0\x01" + data


def index_of(blocks: Sequence[bytes]) -> bytes:
    """Lengths of the blocks of a message, and that none is expected back."""
    head = number(INDEX) + bytes([len(blocks), 1]) + b"\xff" * 8
    return head + b"".join(struct.pack("<i", len(each)) for each in blocks) + bytes(4)


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

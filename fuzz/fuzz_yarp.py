"""YARP: any bytes said to a port, by a name server, or as a stream of vectors are taken."""

from contextlib import suppress
from typing import ClassVar

import numpy as np

from skinfield.errors import InputError
from skinfield.signal import Blocks, Channels, Count, blocks_of, counters
from skinfield.wire.links import LinkAddress
from skinfield.wire.sources.yarp import YarpLink
from skinfield.wire.yarp import Carrier, NameReply, bytes_from_bottle, text_from_bottle
from skinfield.wire.yarp.carriers import Lines, from_octets, greeting, message
from skinfield.wire.yarp.contacts import known_name, part_of, port_of
from skinfield.wire.yarp.port import Connection

VALUES = [[1, 2], [1.0, -0.5], "a b\n", True]
CHANNELS = 5
SEEDS = [
    greeting(carrier, "/me") + message(carrier, "a", ["list", "out"]) + message(carrier, "r")
    for carrier in Carrier
]
SEEDS += [
    message(Carrier.TEXT, "D 12 1.5", [1.0, 2.5, 1e-12, 240, 7]) * 2 + b"q\r\n",
    message(Carrier.TCP, "D 12 1.5", VALUES) + message(Carrier.TCP, "d", []),
    bytes_from_bottle(VALUES),
    text_from_bottle([["a", 1, [2.5]], *VALUES]).encode(),
    b"Welcome x\r\nregistration name /x ip 127.0.0.1 port 10002 type tcp\r\n*** end of message\r\n",
    b"do 1 2.0\r\nnan -inf 1e400 .5 7\r\nd\r\n0 255 1 2 3\r\n",
]


class Owner:
    """A port that does nothing."""

    name, socket_port = "/out", 10002

    def add(self, wanted: str) -> str:
        """See `Port`."""
        return f"Added {wanted}"

    remove = add

    outputs: ClassVar = {"/there": "tcp"}


class Socket:
    """One that brings pieces, and keeps what it is given."""

    def __init__(self) -> None:
        self.piece, self.answer = b"", bytearray()
        self.setblocking = self.setsockopt = lambda *_: None

    def recv(self, size: int) -> bytes:
        """The piece."""
        return self.piece

    def send(self, data: bytes) -> int:
        """All of it."""
        self.answer += data
        return len(data)


class Link(YarpLink):
    """A connection that brought bytes, whose lines may have 60 of them."""

    def __init__(self, data: bytes) -> None:
        super().__init__("/out", LinkAddress(0, ()), "me", CHANNELS)
        self._lines = Lines(60)
        self._lines.feed(data)

    def _open(self) -> bool:
        return self._opened(-1)

    def receive(self, into: np.ndarray) -> int:
        """Nothing more."""
        return 0


def one_input(data: bytes) -> None:
    """Take the bytes as each of the things that they may be."""
    connection(data)
    connection(b"CONNACK x\n" + data)
    answers(data)
    vectors(data)
    name = from_octets(data[:60])
    assert part_of(name) is part_of(known_name(name) or name)
    assert port_of(name).startswith("/icub/skin/")


def heard(data: bytes, size: int, *reader: object) -> Connection:
    """A connection that heard the data in pieces of that size."""
    made = Connection(Socket(), Owner(), *reader)
    for at in range(0, len(data), size):
        if not made.gone:
            made.socket.piece = data[at : at + size]
            made.receive()
    return made


def connection(data: bytes) -> None:
    """In one piece and in pieces: the same answers."""
    whole, pieces = heard(data, len(data) + 1), heard(data, 7)
    assert whole.gone == pieces.gone
    if not whole.reads:
        assert whole.socket.answer == pieces.socket.answer


def answers(data: bytes) -> None:
    """What a name server, or a reader, says."""
    answer = NameReply()
    with suppress(InputError):
        answer.feed(data)
    _ = answer.place
    for carrier in Carrier:
        assert heard(data, len(data) + 1, carrier, "/reader").unread == 0


def vectors(data: bytes) -> None:
    """A stream of vectors becomes blocks of their channels."""
    counted, blocks = counters(), Blocks(64 * len(data) + 64)
    link = Link(data)
    link.take(blocks, 3, counted, 10**9)
    channels = Channels(3 + CHANNELS)
    assert channels.apply(blocks) == counted[Count.READINGS] == len(list(blocks_of(blocks.data)))
    assert np.isnan(channels.counts[:3]).all()
    assert (counted >= 0).all()
    assert link.note == "" or "expected 5 numbers" in link.note

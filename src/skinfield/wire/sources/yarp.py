"""Skin that a robot publishes on ports of YARP, such as /icub/skin/left_forearm, as text.

The steps are those of YARP's own page "YARP without YARP": ask the name server where the port is,
connect there, say ``CONNECT`` and a name, be welcomed, say ``r``; from then on the port sends us
what it sends to all its readers.
"""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from time import monotonic, sleep

import numpy as np

from skinfield.errors import InputError, Ints, check_count, check_type
from skinfield.signal import Blocks, Count, Kind, Port
from skinfield.signal.block import LONGEST, Octets
from skinfield.signal.blocks import Full
from skinfield.wire.links import DialledLink, LinkAddress, host_and_port, resolved
from skinfield.wire.sources.streams import LinkedStream
from skinfield.wire.yarp.carriers import Carrier, Lines, checked_name, greeting, message
from skinfield.wire.yarp.port import PORT, NameReply, request_bytes

PIECE = 1 << 16  # bytes that are read at once
BYTES_PER_NUMBER = 32  # of text, at most: what YARP writes has 25
SHORTEST_LINE = 1 << 16  # bytes of a line that are always read
ROUNDS = 8  # of a poll
SETTLE, STEP = 1.0, 1e-3  # s: to wait for connections at first, between two looks at them
DATA = ("d", "D")  # first letters of lines that numbers follow
DIGITS = 18  # of a message's number


@dataclass(frozen=True)
class YarpPort:
    """A port whose vectors are the readings of one patch.

    Parameters
    ----------
    name : str
        By which patches are matched to it.
    channels : int
        Numbers in each vector.
    port : str
        Its name, such as ``/icub/skin/left_forearm``, by which the name server knows it; or where
        it is, ``192.0.2.7:10012``, without one.
    """

    name: str
    channels: int
    port: str

    def __post_init__(self) -> None:
        check_count("channels", self.channels, 1, LONGEST, "numbers in each vector of a port")
        check_type("port", self.port, str, "text")
        if self.port.startswith("/"):
            checked_name(self.port)
        elif ":" not in self.port:
            raise InputError(
                f"port is {self.port!r}, expected its name, as /icub/skin/left_forearm, or its "
                "place, as 192.0.2.7:10012"
            )


@dataclass(frozen=True)
class YarpText:
    """Ports of YARP, read by the text carrier; nothing of YARP is needed on this side.

    Parameters
    ----------
    ports : sequence of YarpPort
    host : str
        Of the name server, which is asked only for ports that are given by their name.
    port : int
    own : str
        Name that we give; it is no port's, and so it does not begin with a slash.
    unit : str
        Of the numbers, one of `skinfield.skin.reading.UNITS`.

    Notes
    -----
    The protocol is that of YARP 4.0.0, `doc/020_nameserver_and_protocols/yarp_without_yarp.dox`,
    "Listening to a Port's owner". Stamps are of the moment when a vector was read from the socket,
    as YARP's are of the robot's clock; their numbers tell what a port left out because we, or the
    network, were slow: `Count.LOST`.
    """

    ports: Sequence[YarpPort]
    host: str = "127.0.0.1"
    port: int = PORT
    own: str = "skinfield"
    unit: str = "count"

    def __post_init__(self) -> None:
        object.__setattr__(self, "ports", tuple(self.ports))
        names = [each.name for each in self.ports]
        if not names or len(set(names)) < len(names):
            raise InputError(f"ports are named {names}, expected one or more, each name once")
        check_count("port", self.port, 1, 65535, "of the name server")
        checked_name(self.own)

    def open(self) -> "YarpStream":
        """Connect; the stream is up once all ports have welcomed us.

        Those that have not within `SETTLE` are waited for while it is polled.

        Raises
        ------
        InputError
            If a host is not understood.
        """
        places = []
        for each in self.ports:
            named = each.port.startswith("/")
            host, port = (self.host, self.port) if named else host_and_port(each.port, "", 0)
            places.append(resolved(host, port, "host"))
        with ExitStack() as undo:
            links = [
                undo.enter_context(closing(YarpLink(each.port, place, self.own, each.channels)))
                for each, place in zip(self.ports, places, strict=True)
            ]
            end = monotonic() + SETTLE
            while monotonic() < end and any(link.connecting for link in links):
                sleep(STEP)
                for link in links:
                    link.advance()
            ports = tuple(Port(each.name, each.channels, self.unit) for each in self.ports)
            stream = YarpStream(ports, links)
            undo.pop_all()
        return stream


class YarpLink(DialledLink):
    """One port that we read from: vectors, each a line with a stamp and a line of numbers.

    Parameters
    ----------
    port : str
        Of its name, to be asked for; or of its socket, as ``192.0.2.7:10012``.
    place : LinkAddress
        Of the name server, or of the socket.
    own : str
        Name that we give.
    channels : int
        Numbers in a vector.

    Attributes
    ----------
    note : str
        That vectors are of another length.
    """

    def __init__(self, port: str, place: LinkAddress, own: str, channels: int) -> None:
        self._own, self._longest = own, max(SHORTEST_LINE, BYTES_PER_NUMBER * channels)
        self._buffer: Octets = np.zeros(PIECE, np.uint8)
        self._values = np.zeros(channels, np.float32)
        self._begin()
        super().__init__(port, place)

    def _begin(self) -> None:
        """Forget half a vector of an old connection, and its numbers."""
        self._lines = Lines(self._longest)  # that came and were not taken
        self._head = ""  # line with a stamp, whose numbers are still to come
        self._ready = False  # whether a vector waits for room
        self._last: int | None = None
        self.note = ""

    def close(self) -> None:
        """Let go of the connection."""
        super().close()
        self._begin()

    def _opening(self) -> Iterator[None]:
        """Ask where the port is, where only its name is known, and be welcomed there."""
        place = self._place
        if self.label.startswith("/"):
            request = request_bytes(self._own, "query", self.label)
            yield from self._connected(place, request)
            answer = NameReply()
            while not answer.feed(self._heard("the name server closed the connection")):
                yield
            if answer.place is None:
                raise OSError("the name server does not know it: is it open, see `yarp name list`")
            place = resolved(*answer.place, "host of the port")
        hello = greeting(Carrier.TEXT, self._own) + message(Carrier.TEXT, "r")
        yield from self._connected(place, hello)
        while (line := self._lines.take()) is None:  # readings may follow it
            data = self._heard("it was closed")
            self._lines.feed(data)
            if not data:
                yield
        if not line.startswith("Welcome"):
            raise OSError(f"it answered {line!r:.60}, expected a welcome: is it a port of YARP?")

    def _heard(self, closed: str) -> bytes:
        """What has come by now; raises OSError where the other side is gone."""
        assert self._socket is not None
        try:
            data = self._socket.recv(PIECE)
        except (BlockingIOError, InterruptedError):
            return b""
        if not data:
            raise OSError(closed)
        return data

    def take(self, blocks: Blocks, channel: int, counts: Ints, now_ns: int) -> None:
        """Append the vectors that are complete, as far as there is room."""
        for _ in range(ROUNDS):
            count = self.receive(self._buffer)
            counts[Count.BYTES] += count
            if count:
                self._lines.feed(self._buffer[:count].tobytes())
            try:
                while self.up and self._has_vector(counts) and self._put(blocks, channel, now_ns):
                    self._ready = False
                    counts[[Count.RECEIVED, Count.READINGS]] += 1
            except InputError as error:  # a line that does not end
                counts[Count.MALFORMED] += 1
                self.broke(str(error))
            if count < PIECE:
                break

    def _has_vector(self, counts: Ints) -> bool:
        """Understand lines until a vector is complete, or none is left."""
        while not self._ready and self.up and (line := self._lines.take()) is not None:
            if self._head:
                self._follow(self._head, counts)
                self._head, self._ready = "", self._parse(line)
                counts[Count.MALFORMED] += not self._ready
            elif line[:1] in DATA:
                self._head = line
            elif line[:1] == "q":
                self.broke("the port was closed")
            elif line and not line.startswith("<"):  # an acknowledgement
                counts[Count.MALFORMED] += 1
        return self._ready

    def _follow(self, head: str, counts: Ints) -> None:
        """Count the readings that are missing between two numbers; a smaller one begins anew."""
        words = head.split()
        if len(words) > 1 and words[1].isdecimal():
            number = int(words[1][:DIGITS])
            if self._last is not None:
                counts[Count.LOST] += max(number - self._last - 1, 0)
            self._last = number

    def _parse(self, line: str) -> bool:
        """Read the numbers of a line; whether they are as many as there must be."""
        words = line.replace(",", " ").split()
        what: int | str = len(words)
        try:
            numbers = [float(word) for word in words]
        except ValueError:
            numbers, what = [], "something else than"
        if len(numbers) == len(self._values):
            with np.errstate(over="ignore"):
                self._values[:], self.note = numbers, ""
            return True
        self.note = (
            f"a port of YARP sends {what} numbers, expected {len(self._values)} numbers in each "
            "vector: is this the layout of that skin?"
        )
        return False

    def _put(self, blocks: Blocks, channel: int, now_ns: int) -> bool:
        """Append the vector; False if there is no room."""
        try:
            blocks.put(now_ns, channel, self._values, Kind.FLOATS)
        except Full:
            return False
        return True


class YarpStream(LinkedStream):
    """See `skinfield.signal.Stream`."""

    def __init__(self, ports: Sequence[Port], links: Sequence[YarpLink]) -> None:
        super().__init__(ports, links)
        firsts = np.cumsum([0, *(port.channels for port in ports)]).tolist()
        self._yarp = tuple(zip(links, firsts, strict=False))

    def _take(self, blocks: Blocks, channel: int, now_ns: int) -> None:
        for link, first in self._yarp:
            link.take(blocks, channel + first, self.counters, now_ns)

"""Skin that a robot publishes on ports of YARP, such as /icub/skin/left_forearm, as text.

The steps are those of YARP's own page "YARP without YARP": ask the name server where the port is,
connect there, say ``CONNECT`` and a name, be welcomed, say ``r``; from then on the port sends us
what it sends to all its readers.
"""

import select
import socket
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from time import monotonic

import numpy as np

from skinfield.errors import Floats, InputError, Ints, check_count, check_type
from skinfield.signal import Blocks, Count, Kind, Port
from skinfield.signal.block import LONGEST, Octets
from skinfield.signal.blocks import Full
from skinfield.wire.can.bus import host_and_port
from skinfield.wire.can.datagrams import Place, let_go, resolved
from skinfield.wire.sources.streams import PATIENCE, LinkedStream, connecting, is_connected
from skinfield.wire.yarp.carriers import Carrier, Lines, checked_name, greeting, message
from skinfield.wire.yarp.name_server import PORT, Answer, bytes_of_request, query

PIECE = 1 << 16  # bytes that are read at once
BYTES_PER_NUMBER = 32  # of text, at most: what YARP writes has 25
SHORTEST_LINE = 1 << 16  # bytes of a line that are always read
ROUNDS = 8  # of a poll
SETTLE = 1.0  # s
DATA = ("d", "D")  # first letters of lines that numbers follow
DIGITS = 18  # of a message's number
NO_NUMBERS = -1


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
        links: list[YarpLink] = []
        try:
            for each, place in zip(self.ports, places, strict=True):
                longest = max(SHORTEST_LINE, BYTES_PER_NUMBER * each.channels)
                links.append(YarpLink(each.port, place, self.own, longest))
            end = monotonic() + SETTLE
            for link in links:
                link.settle(end)
            ports = tuple(Port(each.name, each.channels, self.unit) for each in self.ports)
            return YarpStream(ports, links)
        except BaseException:
            for link in links:
                link.close()
            raise


class Step(IntEnum):
    """How far a connection is."""

    NOTHING = 0
    ASKING = 1  # connecting to the name server, or waiting for its answer
    CONNECTING = 2
    GREETING = 3  # waiting to be welcomed
    READING = 4


class YarpLink:
    """One port that we read from.

    Parameters
    ----------
    port : str
        Of its name, to be asked for; or of its socket, as ``192.0.2.7:10012``.
    place : Place
        Of the name server, or of the socket.
    own : str
        Name that we give.
    longest : int, bytes
        Of a line that is read.

    Attributes
    ----------
    lines : Lines
        What came and was not taken.
    """

    def __init__(self, port: str, place: Place, own: str, longest: int) -> None:
        self._port, self._place, self._own, self._longest = port, place, own, longest
        self._socket: socket.socket | None = None
        self._poll = select.poll()
        self._step, self._begun = Step.NOTHING, 0.0
        self._answer, self.lines = Answer(), Lines(longest)
        self._to_send = b""
        self.fault = ""
        self.reopen()

    @property
    def up(self) -> bool:
        """Whether the port welcomed us."""
        return self._step == Step.READING

    def reopen(self) -> bool:
        """Begin to connect, unless that goes on already."""
        if self._step != Step.NOTHING and monotonic() - self._begun < PATIENCE:
            return self.advance()
        late = self._step != Step.NOTHING
        self.close()
        if late:
            self.fault = f"{self._port}: no answer within {PATIENCE:g} s"
        self._begun = monotonic()
        if self._port.startswith("/"):
            self._connect(self._place, Step.ASKING, bytes_of_request(query(self._port), self._own))
        else:
            self._greet(self._place)
        return self.advance()

    def _greet(self, place: Place) -> None:
        hello = greeting(Carrier.TEXT, self._own) + message(Carrier.TEXT, "r")
        self._connect(place, Step.CONNECTING, hello)

    def _connect(self, place: Place, step: Step, to_send: bytes) -> None:
        let_go(self._socket)
        self._socket = None
        self.fault = self.fault or f"{self._port}: connecting"
        try:
            self._socket, self._poll = connecting(place)
        except OSError as error:
            self.broke(error.strerror or str(error))
            return
        self._step, self._to_send = step, to_send

    def advance(self) -> bool:
        """Go on as far as it goes without waiting; whether it is up."""
        before = Step.NOTHING
        while self._step not in (before, Step.NOTHING, Step.READING):
            before = self._step
            if self._to_send and not self._is_connected():
                break
            data = self._received()
            if data and self._step == Step.ASKING:
                self._take_answer(data)
            elif self._step in (Step.CONNECTING, Step.GREETING):
                self._step = Step.GREETING
                self._take_welcome(data)
        return self.up

    def settle(self, end: float) -> None:
        """Wait until it is up or has failed, but not beyond `end` of the monotonic clock."""
        while self._step not in (Step.NOTHING, Step.READING) and (left := end - monotonic()) > 0:
            assert self._socket is not None
            poll = select.poll()
            poll.register(self._socket, select.POLLOUT if self._to_send else select.POLLIN)
            poll.poll(1e3 * left)
            self.advance()

    def _is_connected(self) -> bool:
        """Whether the connection is there; then what is to be said first was sent."""
        try:
            if self._socket is None or not is_connected(self._socket, self._poll):
                return False
        except OSError as error:
            self.broke(error.strerror or str(error))
            return False
        self.send(self._to_send)  # some bytes into an empty buffer: all of them
        self._to_send = b""
        return self._socket is not None

    def _received(self) -> bytes:
        if self._socket is None:
            return b""
        try:
            data = self._socket.recv(PIECE)
        except (BlockingIOError, InterruptedError):
            return b""
        except OSError as error:
            self.broke(error.strerror or str(error))
            return b""
        if not data:
            asking = self._step == Step.ASKING
            self.broke("the name server closed the connection" if asking else "it was closed")
        return data

    def _take_answer(self, data: bytes) -> None:
        """Go on with where the port is, as the name server says it."""
        try:
            if not self._answer.feed(data):
                return
            there = self._answer.registration
            if there is None:
                self.broke("the name server does not know it: is it open, see `yarp name list`")
                return
            place = resolved(there.host, there.port, "host of the port")
        except InputError as error:
            self.broke(str(error))
            return
        self._greet(place)

    def _take_welcome(self, data: bytes) -> None:
        """Wait for a line that begins with Welcome; what follows it are readings."""
        try:
            self.lines.feed(data)
            line = self.lines.take()
        except InputError as error:
            self.broke(str(error))
            return
        if line is None:
            return
        if not line.startswith("Welcome"):
            self.broke(f"it answered {line!r:.60}, expected a welcome: is it a port of YARP?")
            return
        self._step, self.fault = Step.READING, ""

    def receive(self, into: Octets) -> int:
        """Put what has arrived into `lines`, by way of `into`; how many bytes. Never waits."""
        if not self.up:
            self.advance()  # what it brings is read once all know that it is up
            return 0
        assert self._socket is not None
        try:
            count = self._socket.recv_into(into.data)
        except (BlockingIOError, InterruptedError):
            return 0
        except OSError as error:
            return self.broke(error.strerror or str(error))
        if not count:
            return self.broke("it was closed")
        self.lines.feed(into[:count].tobytes())
        return count

    def send(self, data: bytes) -> None:
        """Send a few bytes."""
        if self._socket is not None:
            try:
                self._socket.send(data)
            except (BlockingIOError, InterruptedError):
                return
            except OSError as error:
                self.broke(error.strerror or str(error))

    def broke(self, why: str) -> int:
        """Let go of a connection that is of no use any more."""
        self.close()
        self.fault = f"{self._port}: {why}"
        return 0

    def filenos(self) -> Sequence[int]:
        """Of the socket, once readings can come."""
        return (self._socket.fileno(),) if self._socket is not None and self.up else ()

    def close(self) -> None:
        """Let go of the connection."""
        let_go(self._socket)
        self._socket, self._step, self._to_send = None, Step.NOTHING, b""
        self._answer, self.lines = Answer(), Lines(self._longest)


class VectorReader:
    """Vectors of one port out of its lines: a line with a stamp, a line of numbers.

    Parameters
    ----------
    port : Port
    link : YarpLink
    """

    def __init__(self, port: Port, link: YarpLink) -> None:
        self._link = link
        self._values: Floats = np.zeros(port.channels)
        self._floor: Floats = np.zeros(port.channels)
        self._length = port.channels  # of the last vector; NO_NUMBERS
        self.forget()

    def forget(self) -> None:
        """Begin anew: half a vector of an old connection, and its numbers."""
        self._head = ""  # line with a stamp, whose numbers are still to come
        self._ready = False  # whether a vector waits for room
        self._last: int | None = None
        self._length = len(self._values)

    def take(self, blocks: Blocks, channel: int, counts: Ints, now_ns: int) -> None:
        """Append the vectors that are complete, as far as there is room."""
        try:
            while True:
                if not self._ready:
                    line = self._link.lines.take()
                    if line is None:
                        return
                    if not self._take_line(line, counts):
                        continue
                if not self._put(blocks, channel, now_ns):
                    return
                self._ready = False
                counts[[Count.RECEIVED, Count.READINGS]] += 1
        except InputError as error:  # a line that does not end
            counts[Count.MALFORMED] += 1
            self._link.broke(str(error))

    def _take_line(self, line: str, counts: Ints) -> bool:
        """Understand one line; whether a vector is complete with it."""
        if self._head:
            self._follow(self._head, counts)
            self._head, self._ready = "", self._parse(line)
            counts[Count.MALFORMED] += not self._ready
        elif line[:1] in DATA:
            self._head = line
        elif line[:1] == "q":
            self._link.broke("the port was closed")
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
        try:
            numbers = [float(word) for word in words]
        except ValueError:
            self._length = NO_NUMBERS
            return False
        self._length = len(numbers)
        if len(numbers) != len(self._values):
            return False
        self._values[:] = numbers
        return True

    def _put(self, blocks: Blocks, channel: int, now_ns: int) -> bool:
        """Append the vector in the smallest kind of block for it; False if there is no room."""
        values = self._values
        np.floor(values, out=self._floor)
        lowest, highest = values.min(), values.max()
        kind = Kind.FLOATS
        if lowest >= 0.0 and highest <= 65535.0 and (self._floor == values).all():
            kind = Kind.BYTES if highest <= 255.0 else Kind.SHORTS
        try:
            with np.errstate(over="ignore"):
                blocks.put(now_ns, channel, values, kind)
        except Full:
            return False
        return True

    @property
    def note(self) -> str:
        """That vectors are of another length; empty where they are not."""
        if self._length == len(self._values):
            return ""
        what = "something else than" if self._length == NO_NUMBERS else self._length
        return (
            f"a port of YARP sends {what} numbers, expected {len(self._values)} numbers in each "
            "vector: is this the layout of that skin?"
        )


class YarpStream(LinkedStream):
    """See `skinfield.signal.Stream`."""

    def __init__(self, ports: Sequence[Port], links: Sequence[YarpLink]) -> None:
        super().__init__(ports, links)
        self._yarp = tuple(links)
        self._buffer: Octets = np.zeros(PIECE, np.uint8)
        self._readers = tuple(map(VectorReader, self.ports, self._yarp))
        self._firsts = np.cumsum([0, *(port.channels for port in self.ports)]).tolist()

    def _take(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        before = int(self.counters[Count.RECEIVED])
        for link, reader, first in zip(self._yarp, self._readers, self._firsts, strict=False):
            for _ in range(ROUNDS):
                count = link.receive(self._buffer)
                self.counters[Count.BYTES] += count
                if link.up:
                    reader.take(blocks, channel + first, self.counters, now_ns)
                if count < PIECE:
                    break
        return int(self.counters[Count.RECEIVED]) - before

    def _went_down(self, place: int) -> None:
        self._readers[place].forget()

    @property
    def notes(self) -> tuple[str, ...]:
        """Ports whose vectors are of another length."""
        return tuple(reader.note for reader in self._readers if reader.note)

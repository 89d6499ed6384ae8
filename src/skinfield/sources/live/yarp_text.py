"""Skin that a robot publishes on ports of YARP, such as /icub/skin/left_forearm, as text."""

from collections.abc import Sequence
from dataclasses import dataclass
from time import monotonic

import numpy as np

from skinfield.acquisition import Blocks, Count, Port
from skinfield.acquisition.block import LONGEST, Octets
from skinfield.errors import Floats, InputError, Ints, check_count, check_type
from skinfield.protocols.yarp import PORT, checked_name
from skinfield.sources.buses.udp_sockets import resolved
from skinfield.sources.live.link import LinkedStream
from skinfield.sources.live.places import host_and_port
from skinfield.sources.live.yarp_link import YarpLink

BYTES_PER_NUMBER = 32  # of text, at most: what YARP writes has 25
SMALLEST = 1 << 18  # bytes of a port's buffer
ROUNDS = 8  # of a poll
SETTLE = 1.0  # s
ENDED, LENGTH, STATES = 2, 3, 4  # as `vector_kernel.take_vectors` says


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
        Of the numbers, one of `skinfield.reading.UNITS`.

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
                links.append(YarpLink(each.port, place, self.own))
            end = monotonic() + SETTLE
            for link in links:
                link.settle(end)
            ports = tuple(Port(each.name, each.channels, self.unit) for each in self.ports)
            return YarpStream(ports, links)
        except BaseException:
            for link in links:
                link.close()
            raise


class VectorReader:
    """Bytes of one port that wait to be understood, and what is known of its numbers."""

    def __init__(self, port: Port) -> None:
        from skinfield.protocols.yarp.vector_kernel import take_vectors

        self._take = take_vectors
        room = max(SMALLEST, 2 * BYTES_PER_NUMBER * port.channels)
        self._data: Octets = np.zeros(room, np.uint8)
        self._values: Floats = np.zeros(port.channels)
        self._state: Ints = np.zeros(STATES, np.int64)
        self.used = 0

    @property
    def free(self) -> Octets:
        """Where further bytes go."""
        return self._data[self.used :]

    def take(self, received: int, blocks: Blocks, channel: int, counts: Ints, now_ns: int) -> int:
        """Append the vectors that are complete; bytes that are done with.

        Parameters
        ----------
        received : int
            Bytes that were written to `free`.
        """
        self.used += received
        done = int(
            self._take(
                self._data, self.used, blocks.words, blocks.octets, blocks.shorts, blocks.singles,
                blocks.end, now_ns, channel, self._values, self._state, counts,
            )
        )  # fmt: skip
        if done:
            self._data[: self.used - done] = self._data[done : self.used]
            self.used -= done
        return done

    @property
    def ended(self) -> bool:
        """Whether the port said goodbye."""
        return bool(self._state[ENDED])

    @property
    def note(self) -> str:
        """That vectors are of another length; empty where they are not."""
        length = int(self._state[LENGTH])
        if not length:
            return ""
        found = f"{length} numbers" if length > 0 else "something else than numbers"
        return (
            f"a port of YARP sends {found}, expected {len(self._values)} numbers in each vector: "
            "is this the layout of that skin?"
        )

    @property
    def overfull(self) -> bool:
        """Whether a message is longer than all there is room for; not so if blocks have no room."""
        full = self.used == len(self._data)
        return full and bool(np.count_nonzero(self._data == ord("\n")) < 2)

    def forget(self) -> None:
        """Begin anew: half a vector of an old connection, and its numbers."""
        self.used = 0
        self._state[:] = 0


class YarpStream(LinkedStream):
    """See `skinfield.acquisition.Stream`."""

    def __init__(self, ports: Sequence[Port], links: Sequence[YarpLink]) -> None:
        super().__init__(ports, links)
        self._yarp = tuple(links)
        self._readers = tuple(VectorReader(port) for port in self.ports)
        self._firsts = np.cumsum([0, *(port.channels for port in self.ports)]).tolist()
        self._readers[0].take(0, Blocks(1024), 0, self.counters, 0)  # compiles

    def _take(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        before = int(self.counters[Count.RECEIVED])
        for place, link in enumerate(self._yarp):
            self._take_port(
                link, self._readers[place], blocks, channel + self._firsts[place], now_ns
            )
        return int(self.counters[Count.RECEIVED]) - before

    def _take_port(
        self, link: YarpLink, reader: VectorReader, blocks: Blocks, channel: int, now_ns: int
    ) -> None:
        for _ in range(ROUNDS):
            room = reader.free
            received = link.receive(room) if len(room) else 0
            if not received and not reader.used:
                return
            self.counters[Count.BYTES] += received
            done = reader.take(received, blocks, channel, self.counters, now_ns)
            if reader.ended:
                link.ended()
                return
            if reader.overfull:
                self.counters[Count.MALFORMED] += 1
                reader.forget()
            if received < len(room) or not done:
                return

    def _went_down(self, place: int) -> None:
        self._readers[place].forget()

    def _came_back(self, place: int, now_ns: int) -> None:
        self._readers[place].forget()

    @property
    def notes(self) -> tuple[str, ...]:
        """Ports whose vectors are of another length."""
        return tuple(reader.note for reader in self._readers if reader.note)

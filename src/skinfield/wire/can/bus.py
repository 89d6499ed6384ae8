"""CAN buses: their members, settings, and addresses from the words of a command line."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from skinfield.errors import InputError, check_type
from skinfield.settings import Range, Section
from skinfield.wire.can.messages import CanMessages
from skinfield.wire.links import BreakingLink, place_text
from skinfield.wire.links import host_and_port as host_and_port

PORT = 43113  # of UDP, as python-can's bus over multicast has it
INTERFACES = "udp, socketcan or one of python-can's"


@dataclass(frozen=True)
class BusSettings(Section):
    """One CAN bus, or what stands for one.

    Parameters
    ----------
    interface : str
        `udp`: messages as Linux's struct can_frame, some in each datagram. `socketcan`: Linux's own
        CAN. Any other name is an interface of python-can (`udp_multicast`, `virtual`, `pcan`,
        `slcan`, `kvaser`, ...).
    channel : str
        Of `udp`, the own address that is bound (default 127.0.0.1). Of `socketcan`, the device
        (default can0). Of python-can, what its interface calls channel.
    port : int
        Of `udp`, the own port that is bound; 0 takes a free one.
    peer : str
        Of `udp`: `host:port` to send to. Left empty, what is sent goes to whoever sent last.
    bitrate : int, bit/s
        Of adapters that python-can sets up; 0 leaves it as it is. SocketCAN's is set by `ip link`.
    options : tuple of (str, value)
        Further settings for python-can's own interfaces.
    """

    interface: str = "udp"
    channel: str = ""
    port: Annotated[int, Range(0, 65535, "of UDP")] = PORT
    peer: str = ""
    bitrate: Annotated[int, Range(0, 20_000_000, "bit/s, 0 to leave it as it is")] = 0
    options: tuple[tuple[str, str | int | float | bool], ...] = ()

    def check(self) -> None:
        """See `Section`."""
        for name in ("interface", "channel", "peer"):
            check_type(name, getattr(self, name), str, "text")
        if not self.interface:
            raise InputError(f"interface is '', expected {INTERFACES}")

    @property
    def label(self) -> str:
        """One word for tables: interface and channel."""
        return f"{self.interface}:{self.channel or self.port}"


class Bus(BreakingLink):
    """An open bus; no call waits. A bus that breaks is down until `reopen` says it is back.

    Attributes
    ----------
    settings : BusSettings
    overflowed : int
        Messages that the system dropped for want of room, since it was opened; of UDP, datagrams.
    malformed : int
        Datagrams that were no message of classic CAN.
    errors : int
        Messages by which the bus reports an error.
    note : str
        What should be known of it, in words.
    """

    settings: BusSettings
    overflowed = malformed = errors = 0
    note = ""

    def receive(self, into: CanMessages) -> int:
        """Take in what has arrived, as far as there is room; how many messages."""
        raise NotImplementedError

    def send(self, identifier: int, data: bytes) -> bool:
        """Send one message; False if the system did not take it.

        Parameters
        ----------
        identifier : int
            With the bits of `can.messages` where it has 29 bits or is a remote request.
        data : bytes
            Up to 8.
        """
        one = CanMessages(1)
        one.put(0, identifier, data)
        return self.send_many(one, 1) == 1

    def send_many(self, messages: CanMessages, count: int) -> int:
        """Send the first `count` rows; how many the system took, the first ones."""
        raise NotImplementedError


HERE = "127.0.0.1"
MULTICAST_GROUP = "239.74.163.2"  # of python-can's bus over multicast


def bus_settings(
    bus: str, channels: Sequence[str], count: int, bitrate: int = 0, *, own_port: int | None = None
) -> list[BusSettings]:
    """Settings of `count` CAN buses of one interface.

    Parameters
    ----------
    bus : str
        See `BusSettings.interface`.
    channels : sequence of str
        One for each, or none for the usual ones. Of `udp`: ``host:port`` of the boards, or
        ``:port`` to wait for them at a port of one's own, ``0.0.0.0:port`` for those of other
        machines, too. Of `udp_multicast`: ``group:port``. Of others: the name of the channel.
    count : int
        Buses that the boards are on.
    bitrate : int, bit/s
        See `BusSettings`.
    own_port : int, optional
        Of boards in software, whose channels of `udp` are where they are reached: the port of the
        first bus that has no channel, the next ones follow; 0 takes those that are free.

    Raises
    ------
    InputError
        If there are more channels or fewer, or one cannot be understood.
    """
    if channels and len(channels) != count:
        raise InputError(
            f"channels are {', '.join(channels)}, expected {count}: one for each bus that the "
            "boards are on"
        )
    found = []
    for number, name in enumerate(channels or ("",) * count):
        if bus == "udp" and own_port is not None:
            port = own_port and own_port + number
            found.append(BusSettings(bus, *host_and_port(name, HERE, port)))
        elif bus == "udp":
            found.append(BusSettings(bus, *udp_places(name or HERE, PORT + number)))
        elif bus == "socketcan":
            found.append(BusSettings(bus, name or f"can{number}"))
        elif bus == "udp_multicast":
            group, port = host_and_port(name, MULTICAST_GROUP, PORT + number)
            found.append(BusSettings(bus, group, options=(("port", port),)))
        else:
            found.append(BusSettings(bus, name, bitrate=bitrate))
    return found


def udp_places(text: str, port: int) -> tuple[str, int, str]:
    """Own address and port to bind, and the peer.

    No text, a port alone, or all of one's addresses listen there; any other place is the peer's,
    which is talked with from a free port.

    Parameters
    ----------
    text : str
        See `host_and_port`.
    port : int
        Where the text does not say.
    """
    host, port = host_and_port(text, HERE, port)
    if not text or text.startswith(":") or host in ("0.0.0.0", "::"):
        return host, port, ""
    if host in (HERE, "localhost", "::1"):
        own = "::1" if host == "::1" else HERE
    else:
        own = "::" if ":" in host else "0.0.0.0"
    return own, 0, place_text(host, port)

"""Boards of an iCub and of CySkin on CAN buses, and the shared memory of CySkin's tool."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from skinfield.errors import InputError, check_count, check_type
from skinfield.signal import Blocks, Port
from skinfield.wire.can.bus import BusSettings
from skinfield.wire.cyskin.codec import CySkinDecoder
from skinfield.wire.cyskin.modules import CySkinBoard, checked_boards, port_of
from skinfield.wire.cyskin.shared_memory import HEADER_KEY, SharedMemoryReader
from skinfield.wire.cyskin.wire import CySkinWire
from skinfield.wire.icub.codec import ICubDecoder
from skinfield.wire.icub.commands import BOARD_CHANNELS, BOARDS
from skinfield.wire.icub.configuration import ICubConfiguration
from skinfield.wire.sources.managed_stream import CySkinSupervision, ICubSupervision, ManagedStream
from skinfield.wire.sources.streams import LinkedStream

NOWHERE = 255  # bus of boards that a port has room for and this device lacks


@dataclass(frozen=True)
class ICubCan:
    """Boards of an iCub on their buses, which are configured, started, and stopped at the end.

    Parameters
    ----------
    configuration : ICubConfiguration
        Of `wire.icub.load_configuration` (the robot's own files) or `configuration_for`.
    buses : tuple of BusSettings
        One for each bus of the configuration.
    configure : bool
        False only listens: another host tells the boards what to do.
    """

    configuration: ICubConfiguration
    buses: tuple[BusSettings, ...] = (BusSettings(),)
    configure: bool = True

    def __post_init__(self) -> None:
        check_type("configuration", self.configuration, ICubConfiguration, "of load_configuration")
        needed = len(self.configuration.buses)
        if len(self.buses) != needed:
            raise InputError(
                f"buses are {[bus.label for bus in self.buses]}, expected {needed}: the boards of "
                f"{self.configuration.name!r} are on so many"
            )

    def open(self) -> ManagedStream:
        """Open the buses and tell the boards to send.

        Raises
        ------
        InputError
            If a bus cannot be used; see `open_bus`.
        """
        boards, ports = ports_of(self.configuration)  # refuses before anything is open
        places = range(len(self.buses))
        period = self.configuration.period
        return ManagedStream(
            ports,
            self.buses,
            [ICubDecoder(boards, p, period=period) for p in places],
            [ICubSupervision(self.configuration, place) for place in places]
            if self.configure
            else (),
        )


Boards = tuple[tuple[int, int], ...]


def ports_of(configuration: ICubConfiguration) -> tuple[Boards, tuple[Port, ...]]:
    """Boards in the order of the ports' channels, and the ports.

    Without ports in the configuration there is one, of all its boards and of its name. Boards that
    no port takes are a port of their own, "... without a port". A run that ends within a board
    takes the whole of it: wrappers of boards that are not full count only the triangles there are.

    Raises
    ------
    InputError
        If a port's run begins within a board.
    """
    addresses = configuration.addresses
    if not configuration.ports:
        return addresses, (Port(configuration.name, configuration.channels),)
    places: dict[str, dict[int, int]] = {}
    for run in configuration.ports:
        if any(first % BOARD_CHANNELS for first in (run.first, run.port_first)):
            raise InputError(
                f"port {run.port!r} takes channels from {run.first} on as its channels from "
                f"{run.port_first} on, expected multiples of {BOARD_CHANNELS}: where boards begin"
            )
        for step in range(-(-run.count // BOARD_CHANNELS)):
            place = run.port_first // BOARD_CHANNELS + step
            places.setdefault(run.port, {})[place] = run.first // BOARD_CHANNELS + step
    boards: list[tuple[int, int]] = []
    ports, missing = [], 0
    for name, taken in places.items():
        for place in range(max(taken) + 1):
            if place in taken:
                boards.append(addresses[taken[place]])
            else:
                boards.append((NOWHERE, missing))
                missing += 1
        ports.append(Port(name, BOARD_CHANNELS * (max(taken) + 1)))
    rest = [pair for pair in addresses if pair not in boards]
    if rest:
        ports.append(Port(f"{configuration.name} without a port", BOARD_CHANNELS * len(rest)))
    if missing > BOARDS:
        raise InputError(
            f"ports of {configuration.name!r} have room for {missing} boards more than there are, "
            f"expected at most {BOARDS}: is this the wrapper of that skin?"
        )
    return (*boards, *rest), tuple(ports)


@dataclass(frozen=True)
class CySkinCan:
    """Boards of CySkin, in their application phase, which are started, and stopped at the end.

    All modules are one port of 12 channels each: `wire.cyskin.skin_on_boards` gives the skin
    on these channels.

    Parameters
    ----------
    boards : sequence of CySkinBoard
    buses : sequence of BusSettings
        One for each bus that the boards name.
    name : str
        Of the port.
    wire : CySkinWire
        What is not public of the protocol.
    period_ms : int, ms
        Between two readings.
    configure : bool
        False only listens: another host starts the boards.
    """

    boards: Sequence[CySkinBoard]
    buses: Sequence[BusSettings] = (BusSettings(),)
    name: str = "skin"
    wire: CySkinWire = field(default_factory=CySkinWire)
    period_ms: int = 50
    configure: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "boards", checked_boards(self.boards))
        object.__setattr__(self, "buses", tuple(self.buses))
        check_count("period_ms", self.period_ms, 1, 0xFFFF, "ms between two readings")
        needed = 1 + max(board.bus for board in self.boards)
        if len(self.buses) != needed:
            raise InputError(
                f"buses are {[bus.label for bus in self.buses]}, expected {needed}: the boards "
                "are on so many"
            )

    def open(self) -> ManagedStream:
        """Open the buses and start the boards.

        Raises
        ------
        InputError
            If a bus cannot be used; see `open_bus`.
        """
        places = range(len(self.buses))
        mine = [[board for board in self.boards if board.bus == place] for place in places]
        return ManagedStream(
            (port_of(self.name, self.boards),),
            self.buses,
            [CySkinDecoder(self.boards, place, wire=self.wire) for place in places],
            [CySkinSupervision(each, self.wire, self.period_ms) for each in mine]
            if self.configure
            else (),
        )


@dataclass(frozen=True)
class CySkinSharedMemory:
    """What CySkin's own acquisition tool writes for other programs on the same machine.

    Parameters
    ----------
    boards : sequence of CySkinBoard
        Whose modules give each uid its channel.
    key : int
        Of the header; 450 is the tool's.
    name : str
        Of the port.
    """

    boards: Sequence[CySkinBoard]
    key: int = HEADER_KEY
    name: str = "skin"

    def __post_init__(self) -> None:
        object.__setattr__(self, "boards", checked_boards(self.boards))

    def open(self) -> "SharedMemoryStream":
        """Look for the memory; the stream is up once the tool has made it."""
        return SharedMemoryStream(self)


class SharedMemoryStream(LinkedStream):
    """See `skinfield.signal.Stream`."""

    def __init__(self, source: CySkinSharedMemory) -> None:
        self._reader = SharedMemoryReader(source.boards, source.key)
        super().__init__((port_of(source.name, source.boards),), (self._reader,))
        nothing = np.zeros(0, np.uint32)
        self._reader.order.put(nothing, Blocks(64), 0, self.counters, 0)  # compiles
        self._reader.reopen()

    def _take(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        return self._reader.read(blocks, channel, self.counters, now_ns)

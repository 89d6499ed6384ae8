"""The skin of iCub and ergoCub on its CAN buses."""

from dataclasses import dataclass

from skinfield.acquisition import Port
from skinfield.errors import InputError, check_type
from skinfield.protocols.icub import (
    BOARD_CHANNELS,
    BOARDS,
    ICubConfiguration,
    ICubDecoder,
    MessageClass,
)
from skinfield.sources.buses import BusSettings
from skinfield.sources.live.board_care import ICubCare
from skinfield.sources.live.cared_stream import CaredStream

NOWHERE = 255  # bus of boards that a port has room for and this device lacks


@dataclass(frozen=True)
class ICubCan:
    """Boards of an iCub on their buses, which are configured, started, and stopped at the end.

    Parameters
    ----------
    configuration : ICubConfiguration
        Of `protocols.icub.load_configuration` (the robot's own files) or `configuration_for`.
    buses : tuple of BusSettings
        One for each bus of the configuration.
    classes : tuple of MessageClass
        That carry readings.
    configure : bool
        False only listens: another host tells the boards what to do.
    """

    configuration: ICubConfiguration
    buses: tuple[BusSettings, ...] = (BusSettings(),)
    classes: tuple[MessageClass, ...] = (MessageClass.ANALOG, MessageClass.SKIN)
    configure: bool = True

    def __post_init__(self) -> None:
        check_type("configuration", self.configuration, ICubConfiguration, "of load_configuration")
        needed = len(self.configuration.buses)
        if len(self.buses) != needed:
            raise InputError(
                f"buses are {[bus.label for bus in self.buses]}, expected {needed}: the boards of "
                f"{self.configuration.name!r} are on so many"
            )

    def open(self) -> CaredStream:
        """Open the buses and tell the boards to send.

        Raises
        ------
        InputError
            If a bus cannot be used; see `open_bus`.
        """
        boards, ports = ports_of(self.configuration)  # refuses before anything is open
        places = range(len(self.buses))
        period = self.configuration.period
        return CaredStream(
            ports,
            self.buses,
            [ICubDecoder(boards, p, classes=self.classes, period=period) for p in places],
            [ICubCare(self.configuration, place) for place in places] if self.configure else (),
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

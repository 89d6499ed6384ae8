"""What a CAN bus offers here, and opening one."""

from collections.abc import Sequence
from typing import Protocol

from skinfield.acquisition.can import CanMessages
from skinfield.sources.buses.settings import BusSettings


class Bus(Protocol):
    """An open bus; no call waits. A bus that breaks is down until `reopen` says it is back.

    Attributes
    ----------
    up : bool
        Whether messages can come.
    fault : str
        Why it is down, in words; empty while it is up.
    overflowed : int
        Messages that the system dropped for want of room, since it was opened.
    malformed : int
        Datagrams that were no message of classic CAN.
    errors : int
        Messages by which the bus reports an error.
    octets : int
        Bytes received.
    """

    @property
    def up(self) -> bool:
        """See above."""
        ...

    @property
    def fault(self) -> str:
        """See above."""
        ...

    @property
    def overflowed(self) -> int:
        """See above."""
        ...

    @property
    def malformed(self) -> int:
        """See above."""
        ...

    @property
    def errors(self) -> int:
        """See above."""
        ...

    @property
    def octets(self) -> int:
        """See above."""
        ...

    def receive(self, into: CanMessages, first: int = 0) -> int:
        """Take in what has arrived, as far as there is room from row `first` on.

        Returns
        -------
        int
            Messages; they lie in rows `first` to `first` plus so many.
        """
        ...

    def send(self, identifier: int, data: bytes) -> bool:
        """Send one message; False if the system did not take it.

        Parameters
        ----------
        identifier : int
            With the bits of `acquisition.can` where it has 29 bits or is a remote request.
        data : bytes
            Up to 8.
        """
        ...

    def send_many(self, messages: CanMessages, count: int, first: int = 0) -> int:
        """Send rows `first` to `first + count`; how many the system took, the first ones."""
        ...

    def filenos(self) -> Sequence[int]:
        """File descriptors that become readable when something arrives; may be none."""
        ...

    def reopen(self) -> bool:
        """Try to get a bus back that is down; whether it is up now."""
        ...

    def close(self) -> None:
        """Let go of it; a second time does nothing."""
        ...


def open_bus(settings: BusSettings) -> Bus:
    """Open a bus.

    Returns
    -------
    Bus
        Down, with its `fault` in words, if the device is only absent now.

    Raises
    ------
    InputError
        If the settings cannot be used: no such interface, address not understood, package not
        installed, no CAN in this system.
    """
    if settings.interface in ("udp", "udp_multicast"):
        from skinfield.sources.buses.udp import UdpBus

        return UdpBus(settings)
    if settings.interface == "socketcan":
        from skinfield.sources.buses.socketcan import SocketCanBus

        return SocketCanBus(settings)
    from skinfield.sources.buses.python_can import PythonCanBus

    return PythonCanBus(settings)

"""What boards on CAN buses have in common."""

from collections.abc import Mapping, Sequence
from typing import Any

from skinfield.acquisition import CanMessages
from skinfield.errors import InputError
from skinfield.sources.buses import Bus, open_bus
from skinfield.virtual.buses import address_of, bus_settings
from skinfield.virtual.delivery import FAULTS, CanWire, chances_of
from skinfield.virtual.electronics import Converters
from skinfield.virtual.schedule import Schedule
from skinfield.virtual.settings import VirtualSettings

HEARD = 256  # messages of hosts in one poll of a bus


def open_buses(settings: VirtualSettings, count: int) -> list[Bus]:
    """The buses of the settings.

    Raises
    ------
    InputError
        If one cannot be opened; none is open then.
    """
    buses: list[Bus] = []
    try:
        for where in bus_settings(settings, count):
            bus = open_bus(where)
            buses.append(bus)
            if not bus.up:
                raise InputError(
                    f"bus cannot be opened: {bus.fault}, expected one that is free: choose "
                    "another with --channel"
                )
    except BaseException:
        for bus in buses:
            bus.close()
        raise
    return buses


class CanBoards:
    """Boards on CAN; see `hardware.Hardware`.

    Parameters
    ----------
    converters : Converters
    schedule : Schedule
    wires : sequence of CanWire
        One for each bus.
    rate : float, 1/s, or None
        Of readings, whatever the host says.
    """

    def __init__(
        self,
        converters: Converters,
        schedule: Schedule,
        wires: Sequence[CanWire],
        rate: float | None,
    ) -> None:
        self.converters, self.schedule, self.wires = converters, schedule, tuple(wires)
        self._rate = rate
        self._heard = CanMessages(HEARD)
        self.readings = self.commands = self.reboots = 0

    @property
    def addresses(self) -> list[str]:
        """See `Hardware`."""
        return [address_of(wire.bus) for wire in self.wires]

    @property
    def chances(self) -> Mapping[str, float]:
        """See `Hardware`."""
        return chances_of(self.wires[0].fates)

    def filenos(self) -> list[int]:
        """See `Hardware`."""
        return [number for wire in self.wires for number in wire.bus.filenos()]

    def listen(self, now_ns: int, warmth: float) -> None:
        """See `Hardware`."""
        changed = False
        for number, wire in enumerate(self.wires):
            heard = self._heard
            for row in range(wire.bus.receive(heard)):
                if not wire.off:
                    data = heard.data[row, : int(heard.lengths[row])].tobytes()
                    changed |= self._told(number, int(heard.ids[row]), data, warmth)
        if changed:
            self._reschedule(now_ns)

    def _told(self, bus: int, identifier: int, data: bytes, warmth: float) -> bool:
        """Obey one message; whether a board of ours was meant."""
        raise NotImplementedError

    def _periods(self) -> dict[int, float]:
        """Period, s, of each board that sends."""
        raise NotImplementedError

    def _count(self) -> int:
        """Boards that there are."""
        raise NotImplementedError

    def _reschedule(self, now_ns: int) -> None:
        rate = self._rate
        periods = {
            board: round(1e9 / rate if rate else 1e9 * period)
            for board, period in self._periods().items()
        }
        self.schedule.set(periods, self._count(), now_ns)

    def start(self, now_ns: int) -> None:
        """See `Hardware`."""
        self._reschedule(now_ns)

    def set_chances(self, lose: float, duplicate: float, swap: float) -> None:
        """See `Hardware`."""
        for wire in self.wires:
            wire.fates.chances[:] = lose, duplicate, swap

    def counts(self) -> dict[str, Any]:
        """See `Hardware`."""
        return {
            "messages": sum(wire.sent for wire in self.wires),
            **{
                name: int(sum(wire.fates.counts[i] for wire in self.wires))
                for i, name in enumerate(FAULTS)
            },
            "refused": sum(wire.refused for wire in self.wires),
            "withheld": sum(wire.withheld for wire in self.wires),
            "commands": self.commands,
            "reboots": self.reboots,
        }

    def close(self) -> None:
        """See `Hardware`."""
        for wire in self.wires:
            wire.close()

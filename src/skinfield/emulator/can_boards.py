"""Boards on CAN buses in software: their buses, and listening to hosts."""

from collections.abc import Sequence
from contextlib import ExitStack, closing
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from skinfield.emulator.electronics import Converters
from skinfield.emulator.hardware import Hardware, Wire
from skinfield.emulator.settings import VirtualSettings
from skinfield.errors import InputError
from skinfield.skin import Skin
from skinfield.wire.can import Bus, open_bus
from skinfield.wire.can.adapters import UdpBus
from skinfield.wire.can.bus import bus_settings
from skinfield.wire.can.messages import CanMessages
from skinfield.wire.links import place_text

if TYPE_CHECKING:
    from skinfield.wire.cyskin import CySkinBoardState
    from skinfield.wire.icub.commands import BoardState

HEARD = 256  # messages of hosts that are taken at once
ROUNDS = 16  # of them in one poll of a bus


Message = tuple[int, int, NDArray[np.uint8]]  # identifier, length and octets


class CanWire(Wire[Message]):
    """One CAN bus; `made` has the messages to send."""

    def __init__(self, bus: Bus, room: int, settings: VirtualSettings, number: int = 0) -> None:
        super().__init__(settings, number)
        self.bus, known = bus, bus.settings
        own_port = dict(known.options).get("port")
        host, port = bus.address if isinstance(bus, UdpBus) else (known.channel, own_port)
        self.address = host if port is None else place_text(host, int(port))
        self.made = CanMessages(room)
        self._out = CanMessages(2 * room + 2)

    def filenos(self) -> Sequence[int]:
        """See `Wire`."""
        return self.bus.filenos()

    def _message(self, row: int) -> Message:
        made = self.made
        return int(made.ids[row]), int(made.lengths[row]), made.data[row].copy()

    def _put_all(self, count: int) -> None:
        self._send(self.made, count)

    def _put(self, messages: Sequence[Message]) -> None:
        out = self._out
        for row, message in enumerate(messages):
            out.ids[row], out.lengths[row], out.data[row] = message
        self._send(out, len(messages))

    def _send(self, messages: CanMessages, count: int) -> None:
        up = self.bus.up or self.bus.reopen()
        taken = self.bus.send_many(messages, count) if up else 0
        self.counts["messages"] += taken
        self.counts["refused"] += count - taken

    def _let_go(self) -> None:
        self.bus.close()


def open_buses(settings: VirtualSettings, count: int) -> list[Bus]:
    """CAN buses of the settings, one per channel that is named, or usual ones.

    Raises
    ------
    InputError
        If other channels are named than the boards need, or one cannot be opened; none is open
        then.
    """
    buses: list[Bus] = []
    with ExitStack() as undo:
        for each in bus_settings(settings.bus, settings.channels, count, own_port=settings.port):
            bus = undo.enter_context(closing(open_bus(each)))
            buses.append(bus)
            if not bus.up:
                raise InputError(
                    f"bus cannot be opened: {bus.fault}, expected one that is free: choose "
                    "another with --channel"
                )
        undo.pop_all()
    return buses


StateT = TypeVar("StateT", "BoardState", "CySkinBoardState")  # what a host set a board to


class CanBoards(Hardware, Generic[StateT]):
    """Boards on CAN; see `Hardware`.

    Parameters
    ----------
    fresh : sequence of states
        Of the boards, as after switching on.
    wires : sequence of CanWire
        One for each bus.
    """

    def __init__(
        self,
        skin: Skin,
        settings: VirtualSettings,
        parts: Sequence[int],
        converters: Converters,
        wires: Sequence[CanWire],
        fresh: Sequence[StateT],
    ) -> None:
        super().__init__(skin, settings, parts, converters, wires)
        self._buses = tuple(wires)
        self._fresh: tuple[StateT, ...] = tuple(fresh)
        self.states: list[StateT] = list(fresh)
        self._heard = CanMessages(HEARD)

    def listen(self, now_ns: int, warmth: float) -> None:
        """See `Hardware`."""
        changed = False
        for number, wire in enumerate(self._buses):
            heard = self._heard
            for _ in range(ROUNDS):
                count = wire.bus.receive(heard)
                for row in range(0 if wire.off else count):
                    data = heard.data[row, : int(heard.lengths[row])].tobytes()
                    changed |= self._obey(number, int(heard.ids[row]), data, warmth)
                if count < HEARD:
                    break
        if changed:
            self.reschedule(now_ns)

    def listen_late(self, now_ns: int, warmth: float) -> None:
        """See `Hardware`; a host took boards that send for silent, and would have them tared."""
        if not any(state.sending for state in self.states):
            self.listen(now_ns, warmth)
            return
        for wire in self._buses:
            for _ in range(ROUNDS):
                if wire.bus.receive(self._heard) < HEARD:
                    break

    def _obey(self, bus: int, identifier: int, data: bytes, warmth: float) -> bool:
        """Obey one message; whether a board of ours was meant."""
        raise NotImplementedError

    def _period(self, board: int) -> float | None:
        state = self.states[board]
        return 1e-3 * state.period_ms if state.sending else None

    def _reset(self, board: int) -> None:
        self.states[board] = self._fresh[board]

"""A board's settings, and what a host's packets make of them: for a skin in software."""

from dataclasses import dataclass, replace

from skinfield.protocols.cyskin.commands import (
    PERIOD_MS,
    Declaration,
    ModuleDetails,
    order_of,
)
from skinfield.protocols.cyskin.modules import CySkinBoard
from skinfield.protocols.cyskin.numbers import (
    EVERY_MODULE,
    CdcSpeed,
    Command,
    Grouping,
    Refusal,
)
from skinfield.protocols.cyskin.wire import CySkinWire

Packet = tuple[int, bytes]  # command, data


@dataclass(frozen=True, kw_only=True)
class CySkinBoardState:
    """A board as it is after what it was told; `after` gives the next one, and its answers.

    Parameters
    ----------
    board : CySkinBoard
    wire : CySkinWire
    sending : bool
        Whether it sends readings by itself: automatic synchronisation.
    period_ms : int, ms
    grouping : Grouping
        Of all modules alike.
    cdc_speed : int
    syncs : int
        How often it was asked for one reading.
    ignored : int
        Packets that it did not understand.
    """

    board: CySkinBoard
    wire: CySkinWire
    sending: bool = False
    period_ms: int = PERIOD_MS
    grouping: int = Grouping.NONE
    cdc_speed: int = CdcSpeed.SLOW
    syncs: int = 0
    ignored: int = 0

    def after(self, command: int, data: bytes) -> tuple["CySkinBoardState", list[Packet]]:
        """State after a packet of the host, and the packets that it answers with."""
        order = order_of(self.wire)
        match command, len(data):
            case Command.SET_AUTO_SYNC, n if n >= 1:
                return replace(self, sending=bool(data[0])), []
            case Command.SET_AUTO_SYNC_PERIOD, n if n >= 2:
                period = int.from_bytes(data[:2], order)
                if period == 0:
                    return self._refused(command, Refusal.INVALID)
                return replace(self, period_ms=period), []
            case Command.SET_MODULE_GROUPING, n if n >= 2:
                return replace(self, grouping=data[1]), [(command, data[:1])]
            case Command.CDC_SPEED, n if n >= 2:
                return replace(self, cdc_speed=data[1]), [(command, data[:2])]
            case Command.SYNC, _:
                return replace(self, syncs=self.syncs + 1), []
            case Command.PING, _:
                return self, [(command, data)]
            case Command.UID, _:
                return self, [(command, self.board.number.to_bytes(4, order))]
            case Command.DECLARE, _:
                sensors = tuple(len(module.sensors) for module in self.board.modules)
                count = len(sensors)
                return self, [(command, Declaration(count, 0, sensors).data)]
            case Command.MODULE_DETAILS, n if n >= 1:
                return self._details(data[0])
        return self._refused(command, Refusal.UNSUPPORTED)

    def _details(self, index: int) -> tuple["CySkinBoardState", list[Packet]]:
        modules = list(enumerate(self.board.modules))
        chosen = modules if index == EVERY_MODULE else modules[index : index + 1]
        if not chosen:
            return self._refused(Command.MODULE_DETAILS, Refusal.INVALID)
        answers: list[Packet] = []
        for place, module in chosen:
            details = ModuleDetails(
                index=place, sui=module.sui, sensors=len(module.sensors), grouping=self.grouping,
                uncut=module.uncut, cdc_speed=self.cdc_speed,
            )  # fmt: skip
            answers.append((Command.MODULE_DETAILS, details.data(order_of(self.wire))))
        return self, answers

    def _refused(self, command: int, error: Refusal) -> tuple["CySkinBoardState", list[Packet]]:
        state = replace(self, ignored=self.ignored + 1)
        return state, [(Command.ERROR, bytes([command, error]))]

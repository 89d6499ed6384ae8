"""Boards of CySkin: a host's commands, and the state of a board that obeys them.

Commands and their arguments are those of the public functions (`cynet_comm_utils.h`); the order of
the answers' fields is that of their arguments. Numbers of several octets have the order of
`CySkinWire.big_endian`.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from skinfield.errors import check_count
from skinfield.wire.cyskin.modules import EVERY_MODULE, Command, CySkinBoard, CySkinModule, Refusal
from skinfield.wire.cyskin.wire import CySkinWire, Message

PERIOD_MS = 50  # as the makers' own start
SINGLY = 0  # grouping of a module's sensors: none are read together
Packet = tuple[int, bytes]  # command, data


def start_messages(
    boards: Iterable[CySkinBoard], wire: CySkinWire | None = None, *, period_ms: int = PERIOD_MS
) -> list[Message]:
    """CAN messages that let boards send readings by themselves.

    Grouping of all modules, period, and automatic synchronisation, in this order. The boards must
    be in their application phase: leaving the bootloader is the maker's tool's work.

    Parameters
    ----------
    boards : iterable of CySkinBoard
        Of one bus.
    wire : CySkinWire
    period_ms : int, ms
        Between two readings, 1 to 65535.
    """
    check_count("period_ms", period_ms, 1, 0xFFFF, "ms between two readings")
    wire = wire or CySkinWire()
    period = wire.number(period_ms, 2)
    messages: list[Message] = []
    for board in boards:
        for command, data in (
            (Command.SET_MODULE_GROUPING, bytes([EVERY_MODULE, SINGLY])),
            (Command.SET_AUTO_SYNC_PERIOD, period),
            (Command.SET_AUTO_SYNC, b"\x01"),
        ):
            messages += wire.messages(board.number, wire.packet(command, data))
    return messages


def stop_messages(boards: Iterable[CySkinBoard], wire: CySkinWire | None = None) -> list[Message]:
    """CAN messages after which boards wait for SYNC, and so are silent."""
    wire = wire or CySkinWire()
    return [
        message
        for board in boards
        for message in wire.messages(board.number, wire.packet(Command.SET_AUTO_SYNC, b"\x00"))
    ]


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
    syncs : int
        How often it was asked for one reading.
    ignored : int
        Packets that it did not understand.
    """

    board: CySkinBoard
    wire: CySkinWire
    sending: bool = False
    period_ms: int = PERIOD_MS
    syncs: int = 0
    ignored: int = 0

    def after(self, command: int, data: bytes) -> tuple["CySkinBoardState", list[Packet]]:
        """State after a packet of the host, and the packets that it answers with."""
        match command, len(data):
            case Command.SET_AUTO_SYNC, n if n >= 1:
                return replace(self, sending=bool(data[0])), []
            case Command.SET_AUTO_SYNC_PERIOD, n if n >= 2:
                period = int.from_bytes(data[:2], "big" if self.wire.big_endian else "little")
                if period == 0:
                    return self._refused(command, Refusal.INVALID)
                return replace(self, period_ms=period), []
            case Command.SET_MODULE_GROUPING, n if n >= 2:
                return self, [(command, data[:1])]
            case Command.SYNC, _:
                return replace(self, syncs=self.syncs + 1), []
            case Command.DECLARE, _:
                sensors = [len(module.sensors) for module in self.board.modules]
                return self, [(command, bytes([len(sensors), 0, *sensors]))]
            case Command.MODULE_DETAILS, n if n >= 1:
                return self._details(data[0])
        return self._refused(command, Refusal.UNSUPPORTED)

    def _details(self, index: int) -> tuple["CySkinBoardState", list[Packet]]:
        modules = list(enumerate(self.board.modules))
        chosen = modules if index == EVERY_MODULE else modules[index : index + 1]
        if not chosen:
            return self._refused(Command.MODULE_DETAILS, Refusal.INVALID)
        return self, [
            (Command.MODULE_DETAILS, self._detail(place, module)) for place, module in chosen
        ]

    def _detail(self, place: int, module: CySkinModule) -> bytes:
        """Index u8, sui u32, sensors u8, grouping u8, uncut u16, control and speed of the CDC."""
        sui, uncut = self.wire.number(module.sui, 4), self.wire.number(module.uncut, 2)
        return bytes([place]) + sui + bytes([len(module.sensors), SINGLY]) + uncut + bytes(2)

    def _refused(self, command: int, error: Refusal) -> tuple["CySkinBoardState", list[Packet]]:
        state = replace(self, ignored=self.ignored + 1)
        return state, [(Command.ERROR, bytes([command, error]))]

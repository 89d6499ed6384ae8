"""Boards of CySkin: a host's commands, and the state of a board that obeys them.

Commands and their arguments are those of the public functions (`cynet_comm_utils.h`). Numbers of
several octets have the order of `CySkinWire.big_endian`.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from skinfield.errors import check_count
from skinfield.wire.cyskin.modules import EVERY_MODULE, Command, CySkinBoard
from skinfield.wire.cyskin.wire import CySkinWire, Message

PERIOD_MS = 50  # as the makers' own start
SINGLY = 0  # grouping of a module's sensors: none are read together


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
    period = period_ms.to_bytes(2, wire.order)
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


@dataclass(frozen=True)
class CySkinBoardState:
    """A board as it is after what it was told; `after` gives the next one.

    Parameters
    ----------
    wire : CySkinWire
    sending : bool
        Whether it sends readings by itself: automatic synchronisation.
    period_ms : int, ms
    syncs : int
        How often it was asked for one reading.
    """

    wire: CySkinWire
    sending: bool = False
    period_ms: int = PERIOD_MS
    syncs: int = 0

    def after(self, command: int, data: bytes) -> "CySkinBoardState":
        """State after a packet of the host; the same after one that means nothing to it."""
        match command, len(data):
            case Command.SET_AUTO_SYNC, n if n >= 1:
                return replace(self, sending=bool(data[0]))
            case Command.SET_AUTO_SYNC_PERIOD, n if n >= 2:
                period = int.from_bytes(data[:2], self.wire.order)
                return replace(self, period_ms=period or self.period_ms)
            case Command.SYNC, _:
                return replace(self, syncs=self.syncs + 1)
        return self

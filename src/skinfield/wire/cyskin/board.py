"""Boards of CySkin: a host's commands, and the state of a board that obeys them.

Commands and their arguments are those of the public functions (`cynet_comm_utils.h`); the order of
the answers' fields is that of their arguments and of the same structures on EtherCAT. Numbers of
several octets have the order of `CySkinWire.big_endian`.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Literal

from skinfield.errors import InputError, check_count
from skinfield.wire.cyskin.modules import (
    EVERY_MODULE,
    CdcSpeed,
    Command,
    CySkinBoard,
    CySkinModule,
    Grouping,
    Refusal,
)
from skinfield.wire.cyskin.wire import CySkinWire, Message

PERIOD_MS = 50  # as the makers' own start
Packet = tuple[int, bytes]  # command, data


def order_of(wire: CySkinWire) -> Literal["big", "little"]:
    """Of the octets of a number."""
    return "big" if wire.big_endian else "little"


def command_messages(
    wire: CySkinWire, board: int, command: int, data: bytes = b""
) -> Iterator[Message]:
    """CAN messages of a command to a board, or to `wire.every_board`."""
    return wire.messages(board, wire.packet(command, data))


def start_messages(
    boards: Iterable[CySkinBoard],
    wire: CySkinWire | None = None,
    *,
    period_ms: int = PERIOD_MS,
    grouping: Grouping = Grouping.NONE,
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
    grouping : Grouping
        Sensors that are read together; none in ordinary use.
    """
    check_count("period_ms", period_ms, 1, 0xFFFF, "ms between two readings")
    wire = wire or CySkinWire()
    period = period_ms.to_bytes(2, order_of(wire))
    found: list[Message] = []
    for board in boards:
        for command, data in (
            (Command.SET_MODULE_GROUPING, bytes([EVERY_MODULE, grouping])),
            (Command.SET_AUTO_SYNC_PERIOD, period),
            (Command.SET_AUTO_SYNC, b"\x01"),
        ):
            found += command_messages(wire, board.number, command, data)
    return found


def stop_messages(boards: Iterable[CySkinBoard], wire: CySkinWire | None = None) -> list[Message]:
    """CAN messages after which boards wait for SYNC, and so are silent."""
    wire = wire or CySkinWire()
    return [
        message
        for board in boards
        for message in command_messages(wire, board.number, Command.SET_AUTO_SYNC, b"\x00")
    ]


@dataclass(frozen=True)
class Declaration:
    """Answer to DECLARE: count, first, then the number of sensors of each module from it on.

    Parameters
    ----------
    modules : int
        Of the board, in all.
    first : int
    sensors : tuple of int
    """

    modules: int
    first: int
    sensors: tuple[int, ...]

    @property
    def data(self) -> bytes:
        """Octets of the packet's data."""
        return bytes([self.modules, self.first, *self.sensors])

    @classmethod
    def from_data(cls, data: bytes) -> "Declaration":
        """Read it back; raises InputError if it is too short."""
        if len(data) < 2:
            raise InputError(f"declaration {data.hex()} is too short, expected 2 octets or more")
        return cls(data[0], data[1], tuple(data[2:]))


@dataclass(frozen=True, kw_only=True)
class ModuleDetails:
    """Answer to MODULE_DETAILS: index u8, sui u32, sensors u8, grouping u8, uncut u16, CDC u8 u8.

    On EtherCAT the same 11 octets, little-endian, follow one another.

    Parameters
    ----------
    index : int
        Of the module on its board.
    sui : int
    sensors : int
    grouping : int
    uncut : int
        Bit s is set if sensor s is there.
    cdc_control, cdc_speed : int
    """

    index: int
    sui: int
    sensors: int
    grouping: int = Grouping.NONE
    uncut: int = 0xFFF
    cdc_control: int = 0
    cdc_speed: int = 0

    def data(self, order: Literal["big", "little"]) -> bytes:
        """Octets of the packet's data."""
        return (
            bytes([self.index])
            + self.sui.to_bytes(4, order)
            + bytes([self.sensors, self.grouping])
            + self.uncut.to_bytes(2, order)
            + bytes([self.cdc_control, self.cdc_speed])
        )

    @classmethod
    def from_data(cls, data: bytes, order: Literal["big", "little"]) -> "ModuleDetails":
        """Read it back; raises InputError if it is too short."""
        if len(data) < DETAILS:
            raise InputError(
                f"details of a module {data.hex()} have {len(data)} octets, expected {DETAILS}"
            )
        return cls(
            index=data[0], sui=int.from_bytes(data[1:5], order), sensors=data[5],
            grouping=data[6], uncut=int.from_bytes(data[7:9], order), cdc_control=data[9],
            cdc_speed=data[10],
        )  # fmt: skip

    @property
    def module(self) -> CySkinModule:
        """As a part of a board; raises InputError if it has no sensor.

        With the low 16 bits of the sui: the maker's tools make uids of no more, and so have layouts
        and recordings.
        """
        return CySkinModule(self.sui & 0xFFFF, self.uncut & 0xFFF)


DETAILS = 11  # octets


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

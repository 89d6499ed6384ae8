"""What a host tells CySkin's boards, and what they answer.

Commands and their arguments are those of the public functions (`cynet_comm_utils.h`); the order of
the answers' fields is that of their arguments and of the same structures on EtherCAT. Numbers of
several octets have the order of `CySkinWire.big_endian`.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal

from skinfield.errors import InputError, check_count
from skinfield.protocols.cyskin.modules import CySkinBoard, CySkinModule
from skinfield.protocols.cyskin.numbers import EVERY_MODULE, Command, Grouping
from skinfield.protocols.cyskin.wire import CySkinWire, Message

PERIOD_MS = 50  # as the makers' own start


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

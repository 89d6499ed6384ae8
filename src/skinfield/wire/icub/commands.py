"""Commands between a host and skin boards of an iCub, and the state of a board that obeys them.

From the public sources of robotology (icub-main, icub-firmware, icub-firmware-shared).
"""

from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Annotated

from skinfield.errors import check_count, check_type
from skinfield.settings import Range, Section

BOARDS = 16  # addresses of a bus
TRIANGLES = 16  # of a board
TAXELS = 12  # channels of a triangle, thermal pads included
BOARD_CHANNELS = TRIANGLES * TAXELS


SET_TRANSMISSION = 0x07
SET_BOARD = 0x4D
SET_TRIANGLES = 0x50
POLLING = 2  # class of the host's messages
CDC_OFFSET = 0x2200  # of the converter, on robots
Message = tuple[int, bytes]  # identifier, data


class MessageClass(IntEnum):
    """Class of the messages that carry readings."""

    ANALOG = 3  # of firmware that nobody configured, and of old firmware
    SKIN = 4  # once the board was configured by a 4D or a 50 message


class SkinType(IntEnum):
    """What a board is told that hangs on it: which correction of drift it makes."""

    COMPENSATED = 0  # by pad 6, gains of the first generation
    PALM = 1  # palm and fingertips: by pad 11, all gains 0
    UNCOMPENSATED = 2
    ERGO_HAND = 3  # hand of ergoCub: triangles 0 to 4 as PALM, the others as COMPENSATED_V2
    COMPENSATED_V2 = 8  # by pad 6, gains of the second generation


class Firmware(IntEnum):
    """Generation of the board: how it rounds a negative drift."""

    MTB3 = 3  # shifts, then takes the sign
    MTB4 = 4  # takes the sign, then shifts: 1 lower wherever bits fall away


def message_id(message_class: int, board: int, triangle: int) -> int:
    """Identifier of a triangle's readings, 11 bits."""
    check_count("message_class", message_class, 0, 7, "bits 10 to 8 of the identifier")
    check_count("board", board, 0, BOARDS - 1, "address on its bus")
    check_count("triangle", triangle, 0, TRIANGLES - 1, "of a board")
    return message_class << 8 | board << 4 | triangle


@dataclass(frozen=True, kw_only=True)
class SetBoard(Section):
    """Skin, period and rest of a board. ``4D type period no_load``.

    Parameters
    ----------
    kind : int
        See `SkinType`; numbers that the firmware does not know switch the correction of drift off.
    period_ms : int, ms
        Between two readings, 1 to 255. 50 on most robots.
    no_load : int
        Byte of an unloaded taxel. 240 on most robots.
    """

    kind: Annotated[int, Range(0, 255, "of skin; 0 is that with correction of drift")] = 0
    period_ms: Annotated[int, Range(1, 255, "milliseconds between readings")] = 40
    no_load: Annotated[int, Range(0, 255, "the byte of an unloaded taxel")] = 240

    @property
    def data(self) -> bytes:
        """Bytes of the message."""
        return bytes([SET_BOARD, self.kind, self.period_ms, self.no_load])


@dataclass(frozen=True, kw_only=True)
class TriangleState(Section):
    """How a board treats one triangle.

    Parameters
    ----------
    shift : int
        Bits that the board drops. 2 on most robots.
    enabled : bool
        Whether it is sent.
    cdc_offset : int
        Of the converter, 16 bits. 0x2200 on most robots.
    """

    shift: Annotated[int, Range(0, 15, "bits that the board drops")] = 2
    enabled: bool = True
    cdc_offset: Annotated[int, Range(0, 0xFFFF, "16 bits")] = CDC_OFFSET


@dataclass(frozen=True, kw_only=True)
class SetTriangles(TriangleState):
    """Settings of a run of triangles. ``50 first last shift enabled offset_low offset_high``.

    Parameters
    ----------
    first, last : int
        Of the run, both within it.
    """

    first: int = 0
    last: int = TRIANGLES - 1

    def __post_init__(self) -> None:
        super().__post_init__()
        check_count("last", self.last, 0, TRIANGLES - 1, "a triangle of the board")
        check_count("first", self.first, 0, self.last, "a triangle not behind the last")

    @property
    def data(self) -> bytes:
        """Bytes of the message."""
        head = bytes([SET_TRIANGLES, self.first, self.last, self.shift, int(self.enabled)])
        return head + self.cdc_offset.to_bytes(2, "little")


@dataclass(frozen=True)
class Transmit:
    """Start, ``07 00``, or stop, ``07 01``."""

    on: bool

    @property
    def data(self) -> bytes:
        """Bytes of the message."""
        return bytes([SET_TRANSMISSION, 0 if self.on else 1])


Command = SetBoard | SetTriangles | Transmit


def host_message(board: int, command: Command) -> Message:
    """Identifier and data of a command to a board."""
    check_count("board", board, 0, BOARDS - 1, "address on its bus")
    return POLLING << 8 | board, command.data


def addressed_board(identifier: int) -> int | None:
    """Board that a host's message is for; None for any other message."""
    return identifier & 15 if identifier & ~0xF == POLLING << 8 else None


def command_from(data: bytes) -> Command | None:
    """Command of a host's message; None where it is unknown, too short, or makes no sense.

    Octets behind those that a command needs are passed over, as the firmware does.
    """
    code = data[0] if data else -1
    match code, len(data):
        case 0x07, n if n >= 2:
            return Transmit(data[1] == 0)
        case 0x4D, n if n >= 4 and data[2] > 0:
            return SetBoard(kind=data[1], period_ms=data[2], no_load=data[3])
        case 0x50, n if n >= 7 and data[1] <= data[2] < TRIANGLES and data[3] < 16:
            return SetTriangles(
                first=data[1],
                last=data[2],
                shift=data[3],
                enabled=bool(data[4] & 1),
                cdc_offset=data[5] | data[6] << 8,
            )
    return None


@dataclass(frozen=True, kw_only=True)
class BoardState(SetBoard):
    """A board as it is after what it was told; `after` gives the next one.

    A board that boots again is a new `BoardState(firmware=...)`: silent, as nobody configured it.
    Defaults are those that the robots' software sends where a file says nothing; the firmware's own
    are 50 ms and 245. See `SetBoard` for its kind, period and rest.

    Parameters
    ----------
    firmware : Firmware
    triangles : tuple of 16 TriangleState
    configured : bool
        Whether a 4D, a 50 or a start came. Boards of the mtb3 send class 3 until then.
    sending : bool
    calibrations : int
        How often it took its base anew. Whoever plays the converters sets base to raw when this
        has changed.
    """

    firmware: Firmware = Firmware.MTB4
    triangles: tuple[TriangleState, ...] = (TriangleState(),) * TRIANGLES
    configured: bool = False
    sending: bool = False
    calibrations: int = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        check_type("firmware", self.firmware, Firmware, "MTB3 or MTB4")
        check_count("triangles", len(self.triangles), TRIANGLES, TRIANGLES, "one state for each")

    @property
    def message_class(self) -> MessageClass:
        """Class of its readings."""
        old = self.firmware == Firmware.MTB3 and not self.configured
        return MessageClass.ANALOG if old else MessageClass.SKIN

    def after(self, data: bytes) -> "BoardState":
        """State after a message of the host with such data; the same after an unknown one.

        ======= ========================================================================
        message what follows
        ======= ========================================================================
        4D      kind, period, rest; mtb4 also switches all triangles off until a 50 comes
        50      settings of triangles; new calibration; mtb4 stops to send
        07      sends, or stops
        ======= ========================================================================
        """
        match command_from(data):
            case SetBoard() as board:
                triangles = self.triangles
                if self.firmware == Firmware.MTB4:
                    triangles = tuple(replace(each, enabled=False) for each in triangles)
                return replace(self, **vars(board), triangles=triangles, configured=True)
            case SetTriangles(first=first, last=last, shift=shift, enabled=on, cdc_offset=offset):
                new = TriangleState(shift=shift, enabled=on, cdc_offset=offset)
                before, behind = self.triangles[:first], self.triangles[last + 1 :]
                return replace(
                    self,
                    triangles=(*before, *[new] * (last + 1 - first), *behind),
                    configured=True,
                    sending=self.sending and self.firmware == Firmware.MTB3,
                    calibrations=self.calibrations + 1,
                )
            case Transmit(on=on):
                return replace(self, sending=on, configured=self.configured or on)
        return self

"""What a host tells the boards: commands and their bytes, both ways."""

from dataclasses import dataclass

from skinfield.errors import check_count
from skinfield.protocols.icub.numbers import (
    BOARDS,
    POLLING,
    SET_BOARD,
    SET_OLD_BOARD,
    SET_OLD_SKIN,
    SET_TRANSMISSION,
    SET_TRIANGLES,
    TRIANGLES,
)

CDC_OFFSET = 0x2200  # of the converter, on robots
Message = tuple[int, bytes]  # identifier, data


@dataclass(frozen=True, kw_only=True)
class SetBoard:
    """Skin, period and rest of a board. ``4D type period no_load``.

    Parameters
    ----------
    kind : int
        See `SkinType`.
    period_ms : int, ms
        Between two readings, 1 to 255. 50 on most robots.
    no_load : int
        Byte of an unloaded taxel. 240 on most robots.
    """

    kind: int = 0
    period_ms: int = 40
    no_load: int = 240

    def __post_init__(self) -> None:
        check_count("kind", self.kind, 0, 255, "of skin; 0 is that with correction of drift")
        check_count("period_ms", self.period_ms, 1, 255, "milliseconds between readings")
        check_count("no_load", self.no_load, 0, 255, "the byte of an unloaded taxel")

    @property
    def data(self) -> bytes:
        """Bytes of the message."""
        return bytes([SET_BOARD, self.kind, self.period_ms, self.no_load])


@dataclass(frozen=True, kw_only=True)
class SetTriangles:
    """Settings of a run of triangles. ``50 first last shift enabled offset_low offset_high``.

    Parameters
    ----------
    first, last : int
        Of the run, both within it.
    shift : int
        Bits that the board drops. 2 on most robots.
    enabled : bool
        Whether they are sent.
    cdc_offset : int
        Of the converter, 16 bits. 0x2200 on most robots.
    """

    first: int = 0
    last: int = TRIANGLES - 1
    shift: int = 2
    enabled: bool = True
    cdc_offset: int = CDC_OFFSET

    def __post_init__(self) -> None:
        check_count("last", self.last, 0, TRIANGLES - 1, "a triangle of the board")
        check_count("first", self.first, 0, self.last, "a triangle not behind the last")
        check_count("shift", self.shift, 0, 15, "bits that the board drops")
        check_count("cdc_offset", self.cdc_offset, 0, 0xFFFF, "16 bits")

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


@dataclass(frozen=True, kw_only=True)
class SetOldBoard:
    """Setup of old firmware. ``4C 01 01 timer offset_low offset_high time_low time_high``.

    The board takes the offset, calibrates and starts to send.

    Parameters
    ----------
    timer : int
        1: every 40 ms; 3: by `time`.
    cdc_offset : int
        Of the converter, 16 bits.
    time : int
        Of the timer, in its own steps: 312.5 to a millisecond.
    """

    timer: int = 1
    cdc_offset: int = 0x2000
    time: int = 0

    def __post_init__(self) -> None:
        check_count("timer", self.timer, 0, 255, "1 for 40 ms, 3 for a time of your own")
        check_count("cdc_offset", self.cdc_offset, 0, 0xFFFF, "16 bits")
        check_count("time", self.time, 0, 0xFFFF, "16 bits")

    @property
    def data(self) -> bytes:
        """Bytes of the message."""
        words = self.cdc_offset.to_bytes(2, "little") + self.time.to_bytes(2, "little")
        return bytes([SET_OLD_BOARD, 0x01, 0x01, self.timer]) + words


@dataclass(frozen=True, kw_only=True)
class SetOldSkin:
    """Second setup of old firmware. ``4E shift shift3_1 no_load param mask_low mask_high 0A``.

    Parameters
    ----------
    shift : int
        Bits that the board drops.
    coarse_shifts : int
        The same for sums of three and of all taxels, four bits each.
    no_load : int
        Byte of an unloaded taxel.
    param : int
        Bit 3: correct the drift; bits 1 and 0: kind of skin.
    mask : int
        Bit t is set if triangle t is sent.
    """

    shift: int = 2
    coarse_shifts: int = 0x22
    no_load: int = 240
    param: int = 0
    mask: int = 0xFFFF

    def __post_init__(self) -> None:
        check_count("shift", self.shift, 0, 15, "bits that the board drops")
        check_count("coarse_shifts", self.coarse_shifts, 0, 255, "four bits each")
        check_count("no_load", self.no_load, 0, 255, "the byte of an unloaded taxel")
        check_count("param", self.param, 0, 255, "8 bits")
        check_count("mask", self.mask, 0, 0xFFFF, "a bit per triangle")

    @property
    def data(self) -> bytes:
        """Bytes of the message."""
        head = bytes([SET_OLD_SKIN, self.shift, self.coarse_shifts, self.no_load, self.param])
        return head + self.mask.to_bytes(2, "little") + b"\x0a"


Command = SetBoard | SetTriangles | Transmit | SetOldBoard | SetOldSkin


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
        case 0x4C, 8:
            return SetOldBoard(
                timer=data[3], cdc_offset=data[4] | data[5] << 8, time=data[6] | data[7] << 8
            )
        case 0x4E, n if n >= 7:
            return SetOldSkin(
                shift=data[1] & 15,
                coarse_shifts=data[2],
                no_load=data[3],
                param=data[4],
                mask=data[5] | data[6] << 8,
            )
    return None

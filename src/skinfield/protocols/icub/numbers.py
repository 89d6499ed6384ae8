"""Numbers of the iCub's skin boards: identifiers, commands, kinds of skin.

From the public sources of robotology (icub-main, icub-firmware, icub-firmware-shared).
"""

from enum import IntEnum

from skinfield.errors import InputError, check_count

BOARDS = 16  # addresses of a bus
TRIANGLES = 16  # of a board
TAXELS = 12  # channels of a triangle, thermal pads included
BOARD_CHANNELS = TRIANGLES * TAXELS

HEAD, TAIL = 0x40, 0xC0  # first octet of the two messages of a triangle
HEAD_TAXELS, TAIL_TAXELS = 7, 5
DEBUG_ID = 0x100  # of messages that hosts skip

SET_TRANSMISSION = 0x07
SET_OLD_BOARD = 0x4C
SET_BOARD = 0x4D
SET_OLD_SKIN = 0x4E
SET_TRIANGLES = 0x50
POLLING = 2  # class of the host's messages


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
    RAW_TEST = 7  # the low octet of what the converter reads, nothing else
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


def skin_type(value: int) -> SkinType:
    """Kind of skin of a number.

    Raises
    ------
    InputError
        If there is none of that number.
    """
    try:
        return SkinType(value)
    except ValueError:
        known = ", ".join(f"{int(each)} ({each.name.lower()})" for each in SkinType)
        raise InputError(f"skin type is {value!r}, expected one of {known}") from None

"""CySkin's numbers, as in its public headers: `ihbcmd.h`, `skin_cmd_pc.h`, `skin_const.h`."""

from enum import IntEnum, IntFlag

SENSORS = 12  # of a module; number 0 is its temperature
MODULES = 248  # of a board
EVERY_MODULE = 255
LONGEST_DATA = 255  # octets, as one octet says how many
RESPONSES = 126  # in one packet of sensor data at most: (255 - 2) / 2

STANDARD_ID, EXTENDED_ID = 0xFF, 0x03FFFFFF  # bits of a board's number; all set: every board
STANDARD_SHIFT, EXTENDED_SHIFT = 8, 26  # above which `Part` stands
FIRST_COMMAND = 0x10  # what is below is a sequence number


class Part(IntFlag):
    """Which part of an application packet a CAN message is; alone it is both ends."""

    FIRST = 1
    MID = 2
    LAST = 4
    SINGLE = 5


class Command(IntEnum):
    """First octet of an application packet, and of the answer to it."""

    DISCOVERY_PING = 0x10
    DISCOVERY_RECEIVE_ID = 0x11
    PING = 0x12
    ERROR = 0x13
    COLD_REBOOT = 0x32
    WARM_REBOOT = 0x33
    SET_MODULE_GROUPING = 0x36
    SET_AUTO_SYNC = 0x37
    SET_AUTO_SYNC_PERIOD = 0x38
    SET_SPI_SPEED = 0x39
    GET_SPI_SPEED = 0x3A
    SYNC = 0x3B
    DECLARE = 0x3C
    MODULE_DETAILS = 0x3D
    VERSION = 0x3E
    UID = 0x41
    CDC_SPEED = 0x42
    SENSOR_DATA = 0x43
    CDC_CONTROL = 0x44
    PHASE_SHIFT = 0x45
    SET_CUT_SENSORS = 0x47


class Grouping(IntEnum):
    """Which sensors of a module are read together."""

    NONE = 0x00
    THREE = 0x50
    ALL = 0xF0
    AUTO = 0x88


class CdcSpeed(IntEnum):
    """Decimation of the converter."""

    SLOW = 0  # 256
    AVERAGE = 1  # 128
    FAST = 2  # 64


class Refusal(IntEnum):
    """Error codes of an `ERROR` answer."""

    FAILED = 0xE1
    UNSUPPORTED = 0xE2
    INVALID = 0xE3
    NO_COMMAND = 0xE4
    NO_ARGUMENT = 0xE5
    FORMAT = 0xE6
    CHECKSUM = 0xE7
    NO_ROOM = 0xE8
    WRONG_PHASE = 0xE9
    BUSY = 0xEA
    COMPONENT = 0xEB

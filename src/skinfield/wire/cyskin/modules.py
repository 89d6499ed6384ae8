"""Boards and modules of CySkin: their numbers, and the channels of their sensors.

A board (IHB, intelligent hub board) carries up to 248 triangular modules of up to 12 sensors.
Sensor s of module m, counted over all boards of the port, is channel 12 m + s; the uid of a sensor
is `sui << 4 | s`. Number 0 is the module's temperature: it has a channel, which no taxel has.
Sensors that were cut off are left out of what a board sends, so their channels stay empty.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum, IntFlag
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.errors import InputError, Ints, check_count
from skinfield.settings import Range, Section
from skinfield.signal import Port
from skinfield.skin.patch import Skin

SENSORS = 12  # of a module; number 0 is its temperature
MODULES = 248  # of a board
EVERY_MODULE = 255
LONGEST_DATA = 255  # octets, as one octet says how many
RESPONSES = 126  # in one packet of sensor data at most: (255 - 2) / 2

STANDARD_ID, EXTENDED_ID = 0xFF, 0x03FFFFFF  # bits of a board's number; all set: every board
STANDARD_SHIFT, EXTENDED_SHIFT = 8, 26  # above which `Part` stands
FIRST_COMMAND = 0x10  # what is below is a sequence number
ALL_SENSORS = (1 << SENSORS) - 1
Uids = NDArray[np.uint64]


class PacketPart(IntFlag):
    """Which part of an application packet a CAN message is; alone it is both ends."""

    FIRST = 1
    MID = 2
    LAST = 4
    SINGLE = 5


class Command(IntEnum):
    """First octet of an application packet."""

    SET_MODULE_GROUPING = 0x36
    SET_AUTO_SYNC = 0x37
    SET_AUTO_SYNC_PERIOD = 0x38
    SYNC = 0x3B
    SENSOR_DATA = 0x43


@dataclass(frozen=True)
class CySkinModule(Section):
    """A triangle with up to 12 sensors.

    Parameters
    ----------
    sui : int
        Its number, unique among all; a uid is ``sui << 4 | sensor``.
    uncut : int
        Bit s is set if sensor s is there; default all 12.
    """

    sui: Annotated[int, Range(0, 2**32 - 1, "number of a module")]
    uncut: Annotated[int, Range(1, ALL_SENSORS, "bits of 12 sensors, at least one")] = ALL_SENSORS

    @property
    def sensors(self) -> tuple[int, ...]:
        """Numbers of the sensors that are there, in the order in which they are sent."""
        return tuple(s for s in range(SENSORS) if self.uncut >> s & 1)


@dataclass(frozen=True)
class CySkinBoard(Section):
    """A board with its modules.

    Parameters
    ----------
    number : int
        In the identifiers of its CAN messages.
    modules : tuple of CySkinModule
        In the board's own order, which its answers to MODULE_DETAILS tell. Sensor data names them
        by it.
    bus : int
        Index into the buses of the source.
    """

    number: Annotated[int, Range(0, EXTENDED_ID - 1, "of a board; all ones is everyone")]
    modules: tuple[CySkinModule, ...]
    bus: Annotated[int, Range(0, 255, "index into the buses of the source")] = 0

    def check(self) -> None:
        """See `Section`."""
        check_count("modules", len(self.modules), 1, MODULES, "of one board")


def checked_boards(boards: Iterable[CySkinBoard]) -> tuple[CySkinBoard, ...]:
    """Boards as a tuple."""
    boards = tuple(boards)
    addresses = [(board.bus, board.number) for board in boards]
    if not boards or len(set(addresses)) < len(addresses):
        raise InputError(
            f"boards have the addresses {addresses}, expected one or more, each (bus, number) once"
        )
    suis = [module.sui for board in boards for module in board.modules]
    twice = {sui for sui in suis if suis.count(sui) > 1}
    if twice:
        raise InputError(
            f"modules {sorted(twice)[:5]} stand there twice, expected each once: a sui is unique"
        )
    return boards


def channels_of(boards: Sequence[CySkinBoard]) -> int:
    """Of the port of such boards: 12 per module."""
    return SENSORS * sum(len(board.modules) for board in boards)


def port_of(boards: Sequence[CySkinBoard]) -> Port:
    """Port of such boards."""
    return Port("skin", channels_of(boards))


def uids_of(boards: Sequence[CySkinBoard]) -> tuple[Uids, Ints]:
    """Uids of all sensors that are there, and their channels (S,), in the order of sending."""
    modules = [module for board in boards for module in board.modules]
    pairs = [
        (module.sui << 4 | sensor, SENSORS * place + sensor)
        for place, module in enumerate(modules)
        for sensor in module.sensors
    ]
    uids, channels = zip(*pairs, strict=True)
    return np.array(uids, np.uint64), np.array(channels, np.int64)


def boards_from_uids(
    uids: ArrayLike, numbers: Sequence[int] = (1,), *, temperature: bool = True
) -> tuple[CySkinBoard, ...]:
    """Boards for the taxels of a layout, where nobody knows better.

    Modules go by rising sui, in equal runs, to the boards. A real board tells its own order in its
    answers to MODULE_DETAILS.

    Parameters
    ----------
    uids : (n,) array
        ``sui << 4 | sensor`` of each taxel.
    numbers : sequence of int
        Of the boards.
    temperature : bool
        Whether each module also sends sensor 0, its temperature, as the CAN tool records it.

    Raises
    ------
    InputError
        If a sensor's number is above 11, or there are fewer modules than boards.
    """
    values = np.asarray(uids, np.uint64).ravel()
    suis, sensors = (values >> np.uint64(4)).astype(np.int64), (values & np.uint64(15)).astype(int)
    if len(values) == 0 or sensors.max() >= SENSORS:
        raise InputError(
            f"uids are {values[sensors >= SENSORS][:5].tolist()}, expected sui << 4 | sensor with "
            f"sensors from 0 to {SENSORS - 1}: a module has no more"
        )
    numbered, place = np.unique(suis, return_inverse=True)
    uncut = np.full(len(numbered), int(temperature))
    np.bitwise_or.at(uncut, place, 1 << sensors)
    modules = list(map(CySkinModule, numbered.tolist(), uncut.tolist()))
    if len(modules) < len(numbers) or not numbers:
        raise InputError(
            f"there are {len(modules)} modules for {len(numbers)} boards, expected one or more each"
        )
    runs = np.array_split(np.arange(len(modules)), len(numbers))
    return checked_boards(
        CySkinBoard(number, tuple(modules[i] for i in run))
        for number, run in zip(numbers, runs, strict=True)
    )


def skin_on_boards(skin: Skin, boards: Iterable[CySkinBoard]) -> Skin:
    """The same skin, its taxels on the channels of such boards.

    Raises
    ------
    InputError
        If a taxel's uid is of no sensor of the boards.
    """
    boards = checked_boards(boards)
    uids, channels = uids_of(boards)
    order = np.argsort(uids)
    patches = []
    for patch in skin:
        at = np.minimum(np.searchsorted(uids[order], patch.uid), len(uids) - 1)
        missing = patch.uid[uids[order][at] != patch.uid]
        if len(missing):
            raise InputError(
                f"patch {patch.name} has taxels with uids {missing[:5].tolist()}, expected those "
                f"of the boards' modules (sui << 4 | sensor): {len(missing)} have no sensor"
            )
        patches.append(replace(patch, channel=channels[order][at], n_channels=channels_of(boards)))
    return replace(skin, patches=tuple(patches))


def on_boards(
    skin: Skin, numbers: Sequence[int] | None = None
) -> tuple[Skin, tuple[CySkinBoard, ...]]:
    """Boards for any skin, and the skin on their channels.

    Uids that are CySkin's are kept. Others, such as the rows of a layout that has none, are made
    anew: up to 12 taxels of a module become sensors 0 to 11 of a triangle.

    Parameters
    ----------
    skin : Skin
    numbers : sequence of int
        Of the boards; default 1, 2, ... as many as the modules need.
    """
    uids = np.concatenate([patch.uid for patch in skin])
    if len(np.unique(uids)) < len(uids) or (uids & np.uint64(15) >= SENSORS).any():
        skin = _with_new_uids(skin)
        uids = np.concatenate([patch.uid for patch in skin])
    if numbers is None:
        modules = len(np.unique(uids >> np.uint64(4)))
        numbers = range(1, 1 + math.ceil(modules / MODULES))
    temperature = bool((uids & np.uint64(15) != 0).all())
    boards = boards_from_uids(uids, numbers, temperature=temperature)
    return skin_on_boards(skin, boards), boards


def _with_new_uids(skin: Skin) -> Skin:
    patches, sui = [], 0
    for patch in skin:
        uids = np.zeros(len(patch), np.uint64)
        for module in np.unique(patch.module):
            rows = np.flatnonzero(patch.module == module)
            within = np.arange(len(rows))
            uids[rows] = (sui + 1 + within // SENSORS) << 4 | within % SENSORS
            sui += -(-len(rows) // SENSORS)
        patches.append(replace(patch, uid=uids))
    return replace(skin, patches=tuple(patches))

"""CySkin over EtherCAT: what a slave's process data hold. No transport: hand in the octets.

A slave sends three segments of 1280 octets, one in each cycle, which follow one another here. Its
messages, as `msg_struct.h` and `ecatHandler.cpp` have them:

====== ===== ===================================================================
offset bytes message of data
====== ===== ===================================================================
0      1     2
1      1     type of sensor
2      2     octets of the whole message, big-endian
4      1     module, from 0 on, among those of the first message
5      1     first sensor of it
6      2     responses, big-endian, running on across modules
====== ===== ===================================================================

The first message, once after the start: 1, 0xAA, length, then little-endian the number of the board
(4), its modules (1), and for each of them the 11 octets of `ModuleDetails`.
"""

from collections.abc import Iterable
from struct import pack

import numpy as np
from numpy.typing import ArrayLike

from skinfield.acquisition import Blocks, Count
from skinfield.acquisition.block import Octets
from skinfield.errors import InputError, Ints, check_shape
from skinfield.protocols.cyskin.commands import DETAILS, ModuleDetails
from skinfield.protocols.cyskin.decoder import sensor_table
from skinfield.protocols.cyskin.modules import CySkinBoard, channels_of, checked_boards
from skinfield.protocols.cyskin.numbers import MODULES

SEGMENT = 1280  # octets
SEGMENTS = 3
PROCESS = SEGMENT * SEGMENTS
INIT, DATA, INIT_MARK = 1, 2, 0xAA
HEAD = 9  # octets before the modules of the first message


def board_from_init(octets: bytes, bus: int = 0) -> CySkinBoard:
    """Board and modules that a slave's first message tells.

    Raises
    ------
    InputError
        If it is no such message, or shorter than its modules.
    """
    if len(octets) < HEAD or octets[0] != INIT or octets[1] != INIT_MARK:
        raise InputError(
            f"process data begin with {octets[:HEAD].hex(' ')}, expected 01 aa: the first message "
            "of a slave"
        )
    number, count = int.from_bytes(octets[4:8], "little"), octets[8]
    if count > MODULES or len(octets) < HEAD + DETAILS * count:
        raise InputError(
            f"{len(octets)} octets say that {count} modules follow, expected at most {MODULES} "
            f"and {DETAILS} octets for each"
        )
    modules = []
    for i in range(count):
        at = HEAD + DETAILS * i
        modules.append(ModuleDetails.from_data(octets[at : at + DETAILS], "little").module)
    return CySkinBoard(number, tuple(modules), bus)


def init_from_board(board: CySkinBoard) -> bytes:
    """First message of a slave, as `board_from_init` reads it."""
    details = [
        ModuleDetails(index=i, sui=m.sui, sensors=len(m.sensors), uncut=m.uncut).data("little")
        for i, m in enumerate(board.modules)
    ]
    length = HEAD + DETAILS * len(details)
    head = bytes([INIT, INIT_MARK]) + length.to_bytes(2, "big")
    return head + pack("<IB", board.number, len(details)) + b"".join(details)


def data_from_responses(module: int, sensor: int, responses: ArrayLike) -> bytes:
    """Message of data.

    Parameters
    ----------
    module, sensor : int
        Of the first response.
    responses : (n,) array
        Whole numbers from 0 to 65535.

    Raises
    ------
    InputError
        If they do not fit into the three segments.
    """
    values = np.asarray(responses, ">u2")
    length = 6 + 2 * len(values)
    if length > PROCESS:
        raise InputError(f"{len(values)} responses, expected at most {(PROCESS - 6) // 2}")
    head = bytes([DATA, 0]) + length.to_bytes(2, "big") + bytes([module, sensor])
    return head + values.tobytes()


class CySkinEtherCat:
    """Process data of slaves to blocks; the same channels as `CySkinDecoder`.

    A slave has no number for its reading: hand in what is new. Nothing tells what was lost.

    Parameters
    ----------
    boards : sequence of CySkinBoard
        In the order of the slaves.
    """

    def __init__(self, boards: Iterable[CySkinBoard]) -> None:
        self.boards = checked_boards(CySkinBoard(board.number, board.modules) for board in boards)
        self.table = sensor_table(self.boards, 0)

    @property
    def channels(self) -> int:
        """Of the port: 12 per module."""
        return channels_of(self.boards)

    def decode(
        self,
        octets: Octets,
        slave: int,
        blocks: Blocks,
        channel: int,
        counters: Ints,
        now_ns: int,
    ) -> bool:
        """Append what one slave's segments hold.

        Parameters
        ----------
        octets : (3840,) uint8 array
            Its three segments, one after the other.
        slave : int
            Index into `boards`.
        blocks, channel, counters
            As for `CySkinDecoder.decode`.
        now_ns : int, ns

        Returns
        -------
        bool
            False if the blocks have no room; then nothing changed.
        """
        from skinfield.protocols.cyskin.decode_kernel import take_responses

        check_shape("octets", octets, (PROCESS,), "three segments of 1280 octets")
        length = int(octets[2]) << 8 | int(octets[3])
        if octets[0] != DATA or not 6 <= length <= PROCESS:
            counters[Count.MALFORMED] += 1
            return True
        table = self.table
        taken = take_responses(
            octets, 4, length - 4, slave, now_ns, True, table.channels, table.begins,
            table.counts, blocks.words, blocks.octets, blocks.end, channel, counters,
        )  # fmt: skip
        if taken:
            counters[Count.RECEIVED] += 1
            counters[Count.BYTES] += length
        return bool(taken)

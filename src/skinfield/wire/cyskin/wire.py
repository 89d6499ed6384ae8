"""Packets of CySkin on CAN: checksums, and what is not public of the protocol as settings.

`cynet_network.h` sets CRC-16 for the bootloader and CRC-8 for the application, and `ihbcmd.h` has
one octet of checksum behind an application packet. The polynomial is in a library that is not
public, so it is a setting: take `matching_checksums` with packets of your board.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cache
from itertools import product
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import InputError, check_count
from skinfield.wire.can.messages import EXTENDED
from skinfield.wire.cyskin.modules import (
    EXTENDED_ID,
    EXTENDED_SHIFT,
    FIRST_COMMAND,
    LONGEST_DATA,
    STANDARD_ID,
    STANDARD_SHIFT,
    PacketPart,
)

Table = NDArray[np.int64]
SUM, CRC, UNCHECKED = 0, 1, 2  # how a kernel goes about it
NO_TABLE: Table = np.zeros(256, np.int64)
POLYNOMIALS_8 = (0x07, 0x31, 0x9B, 0xD5, 0x1D, 0x2F, 0x39, 0xA7)
POLYNOMIALS_16 = (0x1021, 0x8005, 0x3D65, 0x8BB7)
Message = tuple[int, bytes]  # identifier, data


@dataclass(frozen=True, kw_only=True)
class Crc:
    """Cyclic sum of all octets before it.

    Parameters
    ----------
    octets : int
        1 or 2; of two the low one stands first, or the high one with `high_first`.
    polynomial : int
        Without its highest bit: 0x07 is x⁸ + x² + x + 1.
    begin, final : int
        With what it begins, and what is added (exclusive or) at the end.
    reflected : bool
        Whether bits enter from the lowest on.
    """

    octets: int = 1
    polynomial: int = 0x07
    begin: int = 0
    final: int = 0
    reflected: bool = False
    high_first: bool = False

    def __post_init__(self) -> None:
        check_count("octets", self.octets, 1, 2, "of the checksum")
        for name in ("polynomial", "begin", "final"):
            check_count(name, getattr(self, name), 0, (1 << 8 * self.octets) - 1, "of its width")

    @property
    def numbers(self) -> Table:
        """How, octets, begin, final, reflected, high first: for the kernels."""
        return np.array(
            [CRC, self.octets, self.begin, self.final, self.reflected, self.high_first], np.int64
        )

    @property
    def table(self) -> Table:
        """What each octet contributes (256,), for the kernels."""
        return _crc_table(self.octets, self.polynomial, self.reflected)


@cache
def _crc_table(octets: int, polynomial: int, reflected: bool) -> Table:
    width, table = 8 * octets, np.zeros(256, np.int64)
    mirrored = int(f"{polynomial:0{width}b}"[::-1], 2)
    for octet in range(256):
        rest = octet if reflected else octet << (width - 8)
        for _ in range(8):
            if reflected:
                rest = rest >> 1 ^ (mirrored if rest & 1 else 0)
            else:
                rest = rest << 1 ^ (polynomial if rest >> (width - 1) & 1 else 0)
        table[octet] = rest & ((1 << width) - 1)
    return table


@dataclass(frozen=True)
class Sum:
    """Octet with which all octets together are 0 modulo 256, or their plain sum.

    Parameters
    ----------
    negated : bool
        True as in Cypress' bootloader, whose packets it is named after.
    """

    negated: bool = True
    octets: ClassVar[int] = 1
    table: ClassVar[Table] = NO_TABLE

    @property
    def numbers(self) -> Table:
        """See `Crc`."""
        return np.array([SUM, 1, 0, self.negated, 0, 0], np.int64)


@dataclass(frozen=True)
class Unchecked:
    """Octets behind the packet that are not looked at; what is written there is 0.

    Parameters
    ----------
    octets : int
        0, 1 or 2.
    """

    octets: int = 1
    table: ClassVar[Table] = NO_TABLE

    def __post_init__(self) -> None:
        check_count("octets", self.octets, 0, 2, "of the checksum that is not looked at")

    @property
    def numbers(self) -> Table:
        """See `Crc`."""
        return np.array([UNCHECKED, self.octets, 0, 0, 0, 0], np.int64)


Checksum = Crc | Sum | Unchecked


def octets_behind(data: bytes, checksum: Checksum) -> bytes:
    """Octets of the checksum that follow `data`; zeros where they are not looked at."""
    from skinfield.wire.cyskin.kernel import summed

    octets, check = np.frombuffer(bytearray(data), np.uint8), (checksum.numbers, checksum.table)
    return int(summed(octets, 0, len(octets), check)).to_bytes(checksum.octets, "little")


def usual_checksums() -> Iterator[Checksum]:
    """Sums and the usual polynomials, the default first."""
    yield Crc()
    yield Sum()
    yield Sum(negated=False)
    for octets, polynomials in ((1, POLYNOMIALS_8), (2, POLYNOMIALS_16)):
        ends, flags = (0, (1 << 8 * octets) - 1), (False, True)
        for polynomial, begin, final, reflected, high_first in product(
            polynomials, ends, ends, flags, flags[:octets]
        ):
            yield Crc(
                octets=octets, polynomial=polynomial, begin=begin, final=final,
                reflected=reflected, high_first=high_first,
            )  # fmt: skip


def matching_checksums(packets: Iterable[bytes]) -> tuple[Checksum, ...]:
    """Checksums that fit all of some packets of a real board.

    Parameters
    ----------
    packets : iterable of bytes
        Whole application packets: command, size, data, checksum. One in 256 fits by chance, so
        take ten or more that differ.

    Returns
    -------
    tuple of Checksum
        Of `usual_checksums`, those that fit; empty if none does.

    Raises
    ------
    InputError
        If there are no packets, or one is shorter than it says.
    """
    packets = [bytes(packet) for packet in packets]
    for packet in packets:
        if len(packet) < 3 or len(packet) < 3 + packet[1]:
            raise InputError(
                f"packet {packet.hex()} has {len(packet)} octets, expected command, size, as many "
                "octets of data, and the checksum"
            )
    if not packets:
        raise InputError("there are no packets, expected ten or more that differ")
    parts = [(packet[: 2 + packet[1]], packet[2 + packet[1] :]) for packet in packets]
    return tuple(
        checksum
        for checksum in dict.fromkeys(usual_checksums())
        if all(octets_behind(body, checksum) == rest for body, rest in parts)
    )


@dataclass(frozen=True, kw_only=True)
class CySkinWire:
    """What the public headers leave open, with what is assumed.

    Parameters
    ----------
    extended : bool
        Identifiers of 29 bits, as the bootloader's; the application's have 11.
    big_endian : bool
        Order of the two octets of a response, of periods and of numbers; EtherCAT has it so, and
        of CAN it is not public.
    checksum : Checksum
        CRC-8 by the header `cynet_network.h`; its polynomial is not public.
    """

    extended: bool = False
    big_endian: bool = True
    checksum: Checksum = field(default_factory=Crc)

    @property
    def every_board(self) -> int:
        """Number of a board that means all of them."""
        return EXTENDED_ID if self.extended else STANDARD_ID

    @property
    def order(self) -> Literal["big", "little"]:
        """Of the octets of a number."""
        return "big" if self.big_endian else "little"

    def identifier(self, board: int, part: PacketPart) -> int:
        """CAN identifier, with the bit `EXTENDED` where it has 29 bits."""
        check_count("board", board, 0, self.every_board, "number of a board, or of all")
        if self.extended:
            return EXTENDED | int(part) << EXTENDED_SHIFT | board
        return int(part) << STANDARD_SHIFT | board

    def packet(self, command: int, data: bytes = b"") -> bytes:
        """Application packet: command, size, data, checksum.

        Parameters
        ----------
        command : int
            Octet from 0x10 on.
        data : bytes
            At most 255.
        """
        check_count("command", command, FIRST_COMMAND, 255, "an octet; below are numbers")
        check_count("octets of data", len(data), 0, LONGEST_DATA, "split it up")
        body = bytes([command, len(data)]) + data
        return body + octets_behind(body, self.checksum)

    def messages(self, board: int, packet: bytes) -> Iterator[Message]:
        """CAN messages that carry a packet to or from a board."""
        for at in range(0, len(packet), 8):
            part = PacketPart.MID
            if at == 0:
                part = PacketPart.FIRST
            if at + 8 >= len(packet):
                part = PacketPart.LAST if at else PacketPart.SINGLE
            yield self.identifier(board, part), packet[at : at + 8]

    def unpacked(self, packet: bytes) -> tuple[int, bytes] | None:
        """Command and data of an application packet; None if it is damaged."""
        cut = len(packet) - self.checksum.octets
        body, rest = packet[:cut], packet[cut:]
        if cut < 2 or cut != 2 + body[1]:
            return None
        whole = rest == octets_behind(body, self.checksum) or isinstance(self.checksum, Unchecked)
        return (body[0], body[2:]) if whole else None

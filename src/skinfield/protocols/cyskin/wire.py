"""How CySkin's application packets lie in CAN messages, and what of it is a setting."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from skinfield.acquisition.can import EXTENDED
from skinfield.errors import InputError, check_count
from skinfield.protocols.cyskin.checksum import Checksum, Crc, checksum_of
from skinfield.protocols.cyskin.numbers import (
    EXTENDED_ID,
    EXTENDED_SHIFT,
    FIRST_COMMAND,
    LONGEST_DATA,
    STANDARD_ID,
    STANDARD_SHIFT,
    Part,
)

Message = tuple[int, bytes]  # identifier, data


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
    numbered : bool
        Whether a packet that begins with an octet below 0x10 is taken as sequence number (which
        the header says) followed by a packet as usual (which is assumed), numbers counting to 15.
        Otherwise it is left out.
    """

    extended: bool = False
    big_endian: bool = True
    checksum: Checksum = field(default_factory=Crc)
    numbered: bool = False

    @property
    def every_board(self) -> int:
        """Number of a board that means all of them."""
        return EXTENDED_ID if self.extended else STANDARD_ID

    def identifier(self, board: int, part: Part) -> int:
        """CAN identifier, with the bit `EXTENDED` where it has 29 bits."""
        check_count("board", board, 0, self.every_board, "number of a board, or of all")
        if self.extended:
            return EXTENDED | int(part) << EXTENDED_SHIFT | board
        return int(part) << STANDARD_SHIFT | board

    def packet(self, command: int, data: bytes = b"", number: int | None = None) -> bytes:
        """Application packet: command, size, data, checksum.

        Parameters
        ----------
        command : int
            Octet from 0x10 on.
        data : bytes
            At most 255.
        number : int, optional
            Sequence number, 0 to 15, to stand before it.
        """
        check_count("command", command, FIRST_COMMAND, 255, "an octet; below are numbers")
        check_count("octets of data", len(data), 0, LONGEST_DATA, "split it up")
        head = b""
        if number is not None:
            check_count("number", number, 0, FIRST_COMMAND - 1, "of a packet")
            head = bytes([number])
        body = head + bytes([command, len(data)]) + data
        return body + checksum_of(body, self.checksum)

    def messages(self, board: int, packet: bytes) -> Iterator[Message]:
        """CAN messages that carry a packet to or from a board."""
        for at in range(0, len(packet), 8):
            part = Part.MID
            if at == 0:
                part = Part.FIRST
            if at + 8 >= len(packet):
                part = Part.LAST if at else Part.SINGLE
            yield self.identifier(board, part), packet[at : at + 8]

    def unpacked(self, packet: bytes) -> tuple[int, bytes]:
        """Command and data of an application packet.

        Raises
        ------
        InputError
            If it is shorter or longer than it says, or its checksum is wrong.
        """
        at = 1 if self.numbered and packet and packet[0] < FIRST_COMMAND else 0
        tail = int(self.checksum.numbers[1])
        if len(packet) < at + 2 or len(packet) != at + 2 + packet[at + 1] + tail:
            raise InputError(
                f"packet {packet.hex()} has {len(packet)} octets, expected command, size, as many "
                f"octets of data and {tail} of checksum"
            )
        body, rest = packet[: len(packet) - tail], packet[len(packet) - tail :]
        expected = checksum_of(body, self.checksum)
        if rest != expected and self.checksum.numbers[0] != 2:
            raise InputError(
                f"packet {packet.hex()} ends with the checksum {rest.hex()}, expected "
                f"{expected.hex()}: it is damaged, or the board sums in another way; see "
                "matching_checksums"
            )
        return body[at], body[at + 2 :]


class Assembler:
    """Packets of CAN messages, in plain Python: for boards in software and for tools."""

    def __init__(self, wire: CySkinWire | None = None) -> None:
        self.wire = wire or CySkinWire()
        self._parts: dict[int, bytes] = {}

    def take(self, identifier: int, data: bytes) -> tuple[int, bytes] | None:
        """Board and packet that a message completes, if it does; pieces without a start fall away.

        Parameters
        ----------
        identifier : int
            With the bit `EXTENDED` where it has 29 bits.
        data : bytes
        """
        extended = bool(identifier & EXTENDED)
        if extended != self.wire.extended:
            return None
        shift = EXTENDED_SHIFT if extended else STANDARD_SHIFT
        board, part = identifier & self.wire.every_board, identifier >> shift & 7
        if part == Part.SINGLE:
            self._parts.pop(board, None)
            return board, data
        if part == Part.FIRST:
            self._parts[board] = data
        elif board in self._parts and part in (Part.MID, Part.LAST):
            self._parts[board] += data
            if part == Part.LAST:
                return board, self._parts.pop(board)
        return None

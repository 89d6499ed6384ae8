"""Records of an MCAP file, one by one, from whatever is left of it.

mcap's own readers trust what they read: a cut message comes out short, a chunk is unpacked to
whatever size its head claims. Here every length is checked against the file before it is believed,
and every chunk against its checksum.
"""

import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, NamedTuple

from skinfield.errors import FileError
from skinfield.sources.recordings.mcap_bodies import (
    CHUNK_HEAD,
    HEAD,
    LARGEST,
    Damaged,
    Op,
    parsed,
    text_at,
)

MAGIC = b"\x89MCAP0\r\n"


class Record(NamedTuple):
    """Where a record stands: its first byte, its opcode, and the first byte behind it."""

    start: int
    opcode: int
    end: int

    @property
    def length(self) -> int:
        """Bytes without opcode and length."""
        return self.end - self.start - HEAD.size


class Damage(NamedTuple):
    """A place that cannot be read, and why."""

    byte: int
    why: str


@dataclass
class Outline:
    """All records of a file, by their heads.

    Attributes
    ----------
    size : int, bytes
    records : list of Record
        Of the data.
    tail : list of Record
        Behind it.
    finished : bool
        Whether the file ends as it should.
    end : int, bytes
        Of the last whole record of the data: what follows is cut, damaged, or the summary.
    damage : Damage or None
        Where the walk from head to head had to end.
    """

    size: int
    records: list[Record] = field(default_factory=list)
    tail: list[Record] = field(default_factory=list)
    finished: bool = False
    end: int = len(MAGIC)
    damage: Damage | None = None


def open_file(path: Path) -> BinaryIO:
    """Open an MCAP file; raises FileError if it cannot be read, or is none."""
    try:
        file = path.open("rb")
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise FileError(f"{path} cannot be read: {why}; expected a recording (.mcap)") from error
    start = file.read(len(MAGIC))
    if start != MAGIC:
        file.close()
        what = "is empty" if not start else f"begins with {start[:8]!r} at byte 0"
        raise FileError(f"{path} {what}, expected {MAGIC!r}: it is no MCAP file")
    return file


def outline_of(file: BinaryIO) -> Outline:
    """Walk from head to head; ends at the footer, at the end, or where a length cannot be."""
    size = file.seek(0, 2)
    outline, at = Outline(size), len(MAGIC)
    while at < size:
        file.seek(at)
        head = file.read(HEAD.size)
        if len(head) < HEAD.size:
            outline.damage = Damage(at, f"{len(head)} bytes of a record's head, the file is cut")
            break
        opcode, length = HEAD.unpack(head)
        end = at + HEAD.size + length
        if opcode == 0 or length > LARGEST:
            outline.damage = Damage(at, f"no record begins here (opcode {opcode}, {length} bytes)")
            break
        if end > size:
            kind = Op(opcode).name.lower() if opcode in set(Op) else f"record of kind {opcode}"
            outline.damage = Damage(
                at, f"{size - at} of {end - at} bytes of a {kind}, the file is cut"
            )
            break
        outline.records.append(Record(at, opcode, end))
        at = end
        if opcode == Op.FOOTER:
            break
    _conclude(file, outline)
    return outline


def _conclude(file: BinaryIO, outline: Outline) -> None:
    """Find the end of the data and whether the file was finished."""
    kinds = [record.opcode for record in outline.records]
    data = kinds.index(Op.DATA_END) if Op.DATA_END in kinds else len(kinds)
    if Op.FOOTER in kinds and kinds[-1] != Op.FOOTER:
        data = min(data, kinds.index(Op.FOOTER))
    outline.end = outline.records[data - 1].end if data else len(MAGIC)
    if kinds and kinds[-1] == Op.FOOTER and data < len(kinds):
        last = outline.records[-1].end
        file.seek(last)
        outline.finished = file.read(len(MAGIC) + 1) == MAGIC
        if not outline.finished:
            outline.damage = Damage(last, "the file does not end behind its footer as MCAP does")
    outline.records, outline.tail = outline.records[:data], outline.records[data:]


def body_of(file: BinaryIO, record: Record) -> bytes:
    """Bytes of a record; raises OSError."""
    file.seek(record.start + HEAD.size)
    return file.read(record.length)


class ChunkSize(NamedTuple):
    """What a chunk's head says: times of its first and last message, and bytes."""

    first_ns: int
    last_ns: int
    compression: str
    packed: int
    unpacked: int


def chunk_size(file: BinaryIO, record: Record) -> ChunkSize:
    """Read the head of a chunk alone; raises Damaged."""
    file.seek(record.start + HEAD.size)
    head = file.read(min(record.length, CHUNK_HEAD.size + 4 + 64))
    if len(head) < CHUNK_HEAD.size + 4:
        raise Damaged(f"a chunk of {record.length} bytes")
    first, last, unpacked, _ = CHUNK_HEAD.unpack_from(head)
    name, at = text_at(head, CHUNK_HEAD.size)
    return ChunkSize(first, last, name, record.length - at - 8, unpacked)


def right_end(file: BinaryIO, outline: Outline) -> Damage | None:
    """Check a finished file's own checksums, of its data and of its summary; None if right."""
    footer = outline.tail[-1]
    try:
        found = parsed(Op.FOOTER, body_of(file, footer))
    except Damaged as error:
        return Damage(footer.start, str(error))
    summary = found.summary_start or footer.start
    if found.summary_crc and found.summary_crc != _crc(file, summary, footer.end - 4):
        return Damage(summary, "a summary whose checksum is wrong")
    data_end = outline.tail[0]
    stated = int.from_bytes(body_of(file, data_end)[:4], "little")
    if data_end.opcode == Op.DATA_END and stated and stated != _crc(file, 0, data_end.start):
        return Damage(0, "data whose checksum as a whole is wrong")
    return None


def _crc(file: BinaryIO, start: int, end: int) -> int:
    """CRC-32 of bytes of the file."""
    crc = 0
    file.seek(start)
    while start < end and (piece := file.read(min(end - start, 1 << 20))):
        crc, start = zlib.crc32(piece, crc), start + len(piece)
    return crc

"""Records of an MCAP file, one by one, from whatever is left of it.

mcap's own readers trust what they read: a cut message comes out short, a chunk is unpacked to
whatever size its head claims. Here every length is checked before it is believed, and every chunk
against its checksum; what stands in a record that is whole, mcap parses.
"""

import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from struct import Struct
from typing import Any, BinaryIO, NamedTuple

from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode

from skinfield.errors import FileError
from skinfield.files.mcap.container import MAGIC

Op = Opcode
LARGEST = 1 << 28  # bytes of a record, or of a chunk's content: far more than is ever written
HEAD = Struct("<BQ")
MESSAGE_HEAD = Struct("<HIQQ")


class Damaged(ValueError):
    """A record whose content cannot be: its own checksum or lengths say so."""


class Message(NamedTuple):
    """One message."""

    channel: int
    sequence: int
    time_ns: int
    data: bytes


def parsed(kind: Op, body: bytes) -> Any:
    """A record as mcap has it, of a kind whose name is one word; raises Damaged."""
    name = kind.name.lower()
    try:
        return getattr(records, name.capitalize()).read(ReadDataStream(BytesIO(body)))
    except Exception as error:  # struct's, Unicode's and mcap's own
        raise Damaged(f"a {name} that cannot be read ({type(error).__name__})") from error


def chunk_content(body: bytes) -> bytes:
    """Unpacked content of a chunk; raises Damaged."""
    chunk = parsed(Op.CHUNK, body)
    size, crc = chunk.uncompressed_size, chunk.uncompressed_crc
    if size > LARGEST:
        raise Damaged(f"a chunk that claims {size} bytes unpacked")
    try:
        content = _unpacked(chunk.compression, chunk.data, size)
    except Exception as error:  # zstandard and lz4 each have errors of their own
        raise Damaged(
            f"a chunk that {chunk.compression[:20]} cannot unpack ({str(error)[:80]})"
        ) from error
    if len(content) != size:
        raise Damaged(f"a chunk that unpacks to {len(content)} of {size} bytes")
    if crc and zlib.crc32(content) != crc:
        raise Damaged("a chunk whose checksum is wrong")
    return content


def _unpacked(name: str, data: bytes, size: int) -> bytes:
    """Content of `size` bytes; never makes room for more."""
    if name == "zstd":
        import zstandard

        stated = zstandard.frame_content_size(data)
        if stated > size:
            raise ValueError(f"it would unpack to {stated} of {size} bytes")
        return bytes(zstandard.ZstdDecompressor().decompress(data, max_output_size=size or 1))
    if name == "lz4":
        import lz4.frame

        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1))
    if name:
        raise ValueError("its compression is not known")
    return data


def message_of(body: bytes) -> Message:
    """Message of a record's body; raises Damaged."""
    if len(body) < MESSAGE_HEAD.size:
        raise Damaged(f"a message of {len(body)} bytes")
    channel, sequence, time_ns, _ = MESSAGE_HEAD.unpack_from(body)
    return Message(channel, sequence, time_ns, body[MESSAGE_HEAD.size :])


def attachment_of(body: bytes) -> records.Attachment:
    """Attachment of a record's body, as mcap has it; raises Damaged."""
    found: records.Attachment = parsed(Op.ATTACHMENT, body)
    crc = int.from_bytes(body[-4:], "little")
    if crc and zlib.crc32(body[:-4]) != crc:
        raise Damaged(f"an attachment {found.name[:40]!r} whose checksum is wrong")
    return found


class Record(NamedTuple):
    """Where a record stands: its first byte, its opcode, and the first byte behind it."""

    start: int
    opcode: int
    end: int


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
    part = outline.records
    while at < size and outline.damage is None:
        file.seek(at)
        head = file.read(HEAD.size)
        opcode, length = HEAD.unpack(head) if len(head) == HEAD.size else (0, 0)
        end = at + HEAD.size + length
        if len(head) < HEAD.size:
            outline.damage = Damage(at, f"{len(head)} bytes of a record's head, the file is cut")
        elif opcode == 0 or length > LARGEST:
            outline.damage = Damage(at, f"no record begins here (opcode {opcode}, {length} bytes)")
        elif end > size:
            kind = Op(opcode).name.lower() if opcode in set(Op) else f"record of kind {opcode}"
            why = f"{size - at} of {end - at} bytes of a {kind}, the file is cut"
            outline.damage = Damage(at, why)
        else:
            part = outline.tail if opcode == Op.DATA_END else part
            part.append(Record(at, opcode, end))
            at = end
            outline.end = end if part is outline.records else outline.end
            if opcode == Op.FOOTER:
                break
    if outline.tail and outline.tail[-1].opcode == Op.FOOTER:
        file.seek(at)
        outline.finished = file.read(len(MAGIC) + 1) == MAGIC
        if not outline.finished:
            outline.damage = Damage(at, "the file does not end behind its footer as MCAP does")
    return outline


def body_of(file: BinaryIO, record: Record) -> bytes:
    """Bytes of a record; raises OSError."""
    start = record.start + HEAD.size
    file.seek(start)
    return file.read(record.end - start)


def header_of(file: BinaryIO, outline: Outline) -> tuple[str, str]:
    """Profile and library of a file; empty where the header is damaged."""
    try:
        (first,) = outline.records[:1]
        header = parsed(Op.HEADER, body_of(file, first) if first.opcode == Op.HEADER else b"")
    except ValueError:  # damaged, or there is none
        return "", ""
    return header.profile, header.library


def entries_of(file: BinaryIO, record: Record) -> Iterator[tuple[int, int, bytes]]:
    """Opcode, first byte and content of what stands in a chunk, or of a record without one.

    Raises Damaged, after what was yielded of the chunk, and OSError.
    """
    body = body_of(file, record)
    if record.opcode != Op.CHUNK:
        yield record.opcode, 0, body
        return
    content, at = chunk_content(body), 0
    while at < len(content):
        if len(content) - at < HEAD.size:
            raise Damaged(f"a chunk that ends within a head, at its byte {at}")
        opcode, length = HEAD.unpack_from(content, at)
        start, at = at + HEAD.size, at + HEAD.size + length
        if at > len(content):
            raise Damaged(f"a chunk that ends within a record, at its byte {start}")
        yield opcode, start, content[start:at]


def right_end(file: BinaryIO, outline: Outline) -> Damage | None:
    """Check a finished file's own checksums, of its data and of its summary; None if right."""
    data_end, footer = outline.tail[0], outline.tail[-1]
    try:
        found = parsed(Op.FOOTER, body_of(file, footer))
    except Damaged as error:
        return Damage(footer.start, str(error))
    summary = found.summary_start or footer.start
    if found.summary_crc and found.summary_crc != _crc(file, summary, footer.end - 4):
        return Damage(summary, "a summary whose checksum is wrong")
    stated = int.from_bytes(body_of(file, data_end)[:4], "little")
    if stated and stated != _crc(file, 0, data_end.start):
        return Damage(0, "data whose checksum as a whole is wrong")
    return None


def _crc(file: BinaryIO, start: int, end: int) -> int:
    """CRC-32 of bytes of the file."""
    crc = 0
    file.seek(start)
    while start < end and (piece := file.read(min(end - start, 1 << 20))):
        crc, start = zlib.crc32(piece, crc), start + len(piece)
    return crc

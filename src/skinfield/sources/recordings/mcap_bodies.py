"""What stands in the records of an MCAP file: chunks, messages, channels, attachments.

Every length is checked before it is believed, and every chunk against its checksum.
"""

import zlib
from collections.abc import Iterator
from enum import IntEnum
from io import BytesIO
from struct import Struct
from typing import Any, NamedTuple

LARGEST = 1 << 28  # bytes of a record, or of a chunk's content: far more than is ever written
HEAD = Struct("<BQ")
CHUNK_HEAD = Struct("<QQQI")
MESSAGE_HEAD = Struct("<HIQQ")


class Op(IntEnum):
    """Opcodes that are looked at; see MCAP's specification."""

    HEADER = 1
    FOOTER = 2
    SCHEMA = 3
    CHANNEL = 4
    MESSAGE = 5
    CHUNK = 6
    MESSAGE_INDEX = 7
    CHUNK_INDEX = 8
    ATTACHMENT = 9
    METADATA = 12
    DATA_END = 15


class Damaged(ValueError):
    """A record whose content cannot be: its own checksum or lengths say so."""


class Message(NamedTuple):
    """One message."""

    channel: int
    sequence: int
    time_ns: int
    data: bytes


def chunk_content(body: bytes) -> bytes:
    """Unpacked content of a chunk; raises Damaged."""
    if len(body) < CHUNK_HEAD.size + 4:
        raise Damaged(f"a chunk of {len(body)} bytes")
    _, _, size, crc = CHUNK_HEAD.unpack_from(body)
    name, at = text_at(body, CHUNK_HEAD.size)
    if len(body) < at + 8:
        raise Damaged("a chunk without content")
    length, at = int.from_bytes(body[at : at + 8], "little"), at + 8
    if at + length != len(body):
        raise Damaged(f"a chunk that claims {length} bytes of {len(body) - at}")
    if size > LARGEST:
        raise Damaged(f"a chunk that claims {size} bytes unpacked")
    content = _unpacked(name, body[at:], size)
    if len(content) != size:
        raise Damaged(f"a chunk that unpacks to {len(content)} of {size} bytes")
    if crc and zlib.crc32(content) != crc:
        raise Damaged("a chunk whose checksum is wrong")
    return content


def _unpacked(name: str, data: bytes, size: int) -> bytes:
    try:
        if name == "zstd":
            import zstandard

            stated = zstandard.frame_content_size(data)
            if stated > size:
                raise Damaged(f"a chunk that would unpack to {stated} of {size} bytes")
            return bytes(zstandard.ZstdDecompressor().decompress(data, max_output_size=size or 1))
        if name == "lz4":
            import lz4.frame

            return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1))
    except Damaged:
        raise
    except Exception as error:  # zstandard and lz4 each have errors of their own
        raise Damaged(f"a chunk that {name} cannot unpack ({str(error)[:80]})") from error
    if name:
        raise Damaged(f"a chunk that is compressed by {name[:20]!r}, which is not known")
    return data


def inner_records(content: bytes) -> Iterator[tuple[int, int, int]]:
    """Opcode, first and last byte of each record within a chunk; raises Damaged at a wrong one."""
    at = 0
    while at < len(content):
        if len(content) - at < HEAD.size:
            raise Damaged(f"a chunk that ends within a head, at its byte {at}")
        opcode, length = HEAD.unpack_from(content, at)
        start, at = at + HEAD.size, at + HEAD.size + length
        if at > len(content):
            raise Damaged(f"a chunk that ends within a record, at its byte {start}")
        yield opcode, start, at


def message_of(data: bytes, start: int, end: int) -> Message:
    """Message of a record's body; raises Damaged."""
    if end - start < MESSAGE_HEAD.size:
        raise Damaged(f"a message of {end - start} bytes")
    channel, sequence, time_ns, _ = MESSAGE_HEAD.unpack_from(data, start)
    return Message(channel, sequence, time_ns, data[start + MESSAGE_HEAD.size : end])


class Channel(NamedTuple):
    """What a channel states of itself."""

    number: int
    schema: int
    topic: str
    encoding: str
    metadata: dict[str, str]


def channel_of(body: bytes) -> Channel:
    """Channel of a record's body; raises Damaged."""
    found = parsed(Op.CHANNEL, body)
    return Channel(
        found.id, found.schema_id, found.topic, found.message_encoding, dict(found.metadata)
    )


def parsed(kind: Op, body: bytes) -> Any:
    """One of mcap's records: header, footer, schema, channel, metadata; raises Damaged."""
    from mcap import records
    from mcap.data_stream import ReadDataStream

    name = kind.name.lower()
    try:
        return getattr(records, name.capitalize()).read(ReadDataStream(BytesIO(body)))
    except Exception as error:  # struct's, Unicode's and mcap's own
        raise Damaged(f"a {name} that cannot be read ({type(error).__name__})") from error


class Attached(NamedTuple):
    """An attachment: name, media type, content."""

    name: str
    media_type: str
    data: bytes


def attachment_of(body: bytes) -> Attached:
    """Attachment of a record's body; raises Damaged."""
    name, at = text_at(body, 16)
    kind, at = text_at(body, at)
    length = int.from_bytes(body[at : at + 8], "little")
    end = at + 8 + length
    if end + 4 != len(body):
        raise Damaged(f"an attachment that claims {length} bytes of {len(body) - at - 12}")
    crc = int.from_bytes(body[end:], "little")
    if crc and zlib.crc32(body[:end]) != crc:
        raise Damaged(f"an attachment {name[:40]!r} whose checksum is wrong")
    return Attached(name, kind, body[at + 8 : end])


def text_at(body: bytes, at: int) -> tuple[str, int]:
    """Text behind its length, and the byte behind it."""
    if at + 4 > len(body):
        raise Damaged("a record that ends within a text")
    end = at + 4 + int.from_bytes(body[at : at + 4], "little")
    if end > len(body):
        raise Damaged("a record that ends within a text")
    try:
        return body[at + 4 : end].decode(), end
    except UnicodeDecodeError as error:
        raise Damaged("a text that is not UTF-8") from error


class Logged(NamedTuple):
    """A run of the ring's log.

    Attributes
    ----------
    position : int, bytes
        Of its first byte in the log.
    time_ns : int, ns
        When it was taken from the log, since the epoch.
    data : bytes
        Blocks, see `skinfield.acquisition.blocks_of`.
    """

    position: int
    time_ns: int
    data: bytes

"""MCAP container that grows by whole pieces, so that a full disk or a crash cuts no chunk in two.

mcap's own writer closes a chunk by its size alone, leaves half a chunk and a wrong index behind a
write that fails, and has the channels in the first chunk only; the records are mcap's own.
"""

import os
import zlib
from array import array
from collections import Counter, defaultdict, deque
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from struct import Struct
from typing import Any, Literal, NamedTuple

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from skinfield.errors import FileError, InputError

MAGIC = b"\x89MCAP0\r\n"
COMPRESSIONS = ("zstd", "lz4", "none")
LEVEL = 1  # of zstandard: the quickest, a third smaller for 8-bit counts and little for 16-bit ones
Bytes = bytes | bytearray | memoryview
Compression = Literal["zstd", "lz4", "none"]
_FOOTER = Struct("<BQQQ")
_MESSAGE = Struct("<BQHIQQ")
_INDEX = Struct("<BQHI")


def compressed(data: bytes, by: Compression) -> tuple[str, bytes]:
    """A chunk's content as it stands in the file, and the name that the file has for how."""
    if by == "zstd":
        import zstandard

        return "zstd", zstandard.ZstdCompressor(level=LEVEL).compress(data)
    if by == "lz4":
        import lz4.frame

        return "lz4", lz4.frame.compress(data)
    return "", data


def octets(record: Any) -> bytes:
    """Bytes of one of mcap's records, with its opcode and length."""
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]


class FileOutput:
    """A file, unbuffered: what was appended survives the end of the process.

    Attributes
    ----------
    end : int
        Bytes so far.

    Parameters
    ----------
    path : Path
    overwrite : bool
        Whether a file of this name may be replaced.

    Raises
    ------
    InputError
        If there is one and it may not.
    FileError
        If it cannot be made.
    """

    def __init__(self, path: Path, *, overwrite: bool = False) -> None:
        self.end = 0
        flags = os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC | (os.O_TRUNC if overwrite else os.O_EXCL)
        try:
            self._file = os.open(path, flags, 0o666)
        except FileExistsError as error:
            raise InputError(
                f"{path} is there already, expected a new name: choose another, or allow to "
                "overwrite it"
            ) from error
        except (OSError, ValueError) as error:  # a zero byte in the name is a ValueError
            why = getattr(error, "strerror", None) or error
            raise FileError(
                f"{path} cannot be made: {why}; expected a folder that can be written to"
            ) from error

    def append(self, piece: Bytes) -> None:
        """Add a piece; on OSError nothing of it is there."""
        left = memoryview(piece)
        try:
            while left:
                left = left[os.pwrite(self._file, left, self.end + len(piece) - len(left)) :]
        except OSError:
            os.ftruncate(self._file, self.end)  # what a full disk took of it
            raise
        self.end += len(piece)

    def sync(self) -> None:
        """Have the system write everything to the disk."""
        os.fdatasync(self._file)

    def close(self) -> None:
        """Let go of the file."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1


SUMMARY = (  # groups of records, in their order in the file
    Opcode.SCHEMA,
    Opcode.CHANNEL,
    Opcode.STATISTICS,
    Opcode.CHUNK_INDEX,
    Opcode.ATTACHMENT_INDEX,
    Opcode.METADATA_INDEX,
)


@dataclass
class Summary:
    """Index and statistics of a file that is being written.

    Attributes
    ----------
    groups : dict of Opcode to bytearray
        Records of each kind.
    counts : Counter of Opcode
        How many these are.
    messages : Counter of int
        Of each channel.
    first_ns, last_ns : int, ns
        Of the messages.
    """

    groups: dict[Opcode, bytearray] = field(default_factory=lambda: defaultdict(bytearray))
    counts: Counter[Opcode] = field(default_factory=Counter)
    messages: Counter[int] = field(default_factory=Counter)
    first_ns: int = 0
    last_ns: int = 0

    def add(self, opcode: Opcode, record: Any) -> None:
        """Add a record of the index."""
        self.groups[opcode] += octets(record)
        self.counts[opcode] += 1

    def add_chunk(self, index: ChunkIndex, messages: dict[int, int]) -> None:
        """A chunk is in the file, with so many messages of each channel."""
        first = index.message_start_time
        self.first_ns = min(first, self.first_ns) if self.counts[Opcode.CHUNK_INDEX] else first
        self.last_ns = max(index.message_end_time, self.last_ns)
        self.messages.update(messages)
        self.add(Opcode.CHUNK_INDEX, index)

    def ending(self, start: int, crc: int) -> bytes:
        """Everything after the data, for a file whose data ends at byte `start`.

        Parameters
        ----------
        start : int, bytes
        crc : int
            CRC-32 of all bytes before; 0 if not known.
        """
        statistics = Statistics(
            attachment_count=self.counts[Opcode.ATTACHMENT_INDEX],
            channel_count=self.counts[Opcode.CHANNEL],
            channel_message_counts=dict(self.messages),
            chunk_count=self.counts[Opcode.CHUNK_INDEX],
            message_count=self.messages.total(),
            message_end_time=self.last_ns,
            message_start_time=self.first_ns,
            metadata_count=self.counts[Opcode.METADATA_INDEX],
            schema_count=self.counts[Opcode.SCHEMA],
        )
        groups: dict[Opcode, Bytes] = {**self.groups, Opcode.STATISTICS: octets(statistics)}
        data_end = octets(DataEnd(crc))
        base = start + len(data_end)
        body, offsets = bytearray(), bytearray()
        for opcode in SUMMARY:
            if group := groups.get(opcode):
                offsets += octets(SummaryOffset(opcode, base + len(body), len(group)))
                body += group
        offset_start = base + len(body)
        body += offsets
        check = zlib.crc32(_FOOTER.pack(Opcode.FOOTER, 20, base, offset_start), zlib.crc32(body))
        return data_end + bytes(body) + octets(Footer(base, offset_start, check)) + MAGIC


class OpenChunk:
    """Messages that are not compressed yet.

    Attributes
    ----------
    data : bytearray
    """

    def __init__(self) -> None:
        self.data = bytearray()
        self._index: dict[int, array[int]] = defaultdict(lambda: array("Q"))
        self._first_ns = self._last_ns = 0

    def __len__(self) -> int:
        return len(self.data)

    def add(self, channel: int, sequence: int, time_ns: int, parts: tuple[Bytes, ...]) -> None:
        """Append a message that consists of `parts`."""
        if not self.data:
            self._first_ns = self._last_ns = time_ns
        self._first_ns, self._last_ns = min(self._first_ns, time_ns), max(self._last_ns, time_ns)
        self._index[channel].extend((time_ns, len(self.data)))
        size = 22 + sum(map(len, parts))
        self.data += _MESSAGE.pack(
            Opcode.MESSAGE, size, channel, sequence & 0xFFFFFFFF, time_ns, time_ns
        )
        for part in parts:
            self.data += part

    def sealed(self, compression: Compression) -> tuple[bytes, ChunkIndex, dict[int, int]]:
        """The chunk as bytes of the file with its index behind it.

        Returns
        -------
        bytes
        ChunkIndex
            For the file's index, as if the chunk stood at byte 0.
        dict of int to int
            How many messages of each channel.
        """
        name, packed = compressed(bytes(self.data), compression)
        chunk = octets(
            Chunk(
                compression=name,
                data=packed,
                message_start_time=self._first_ns,
                message_end_time=self._last_ns,
                uncompressed_crc=zlib.crc32(self.data),
                uncompressed_size=len(self.data),
            )
        )
        piece, offsets = bytearray(chunk), {}
        for channel, pairs in self._index.items():
            offsets[channel] = len(piece)
            table = pairs.tobytes()  # of this machine, which is little-endian as the file is
            piece += _INDEX.pack(Opcode.MESSAGE_INDEX, 6 + len(table), channel, len(table)) + table
        entry = ChunkIndex(
            chunk_length=len(chunk),
            chunk_start_offset=0,
            compression=name,
            compressed_size=len(packed),
            message_end_time=self._last_ns,
            message_index_length=len(piece) - len(chunk),
            message_index_offsets=offsets,
            message_start_time=self._first_ns,
            uncompressed_size=len(self.data),
        )
        return bytes(piece), entry, {key: len(pairs) // 2 for key, pairs in self._index.items()}


class Piece(NamedTuple):
    """Bytes to be written, what to note then of the byte they begin at, and the messages in it."""

    data: Bytes
    written: Callable[[int], None]
    messages: dict[int, int]


class Container:
    """Writes records; nothing that could not be written is forgotten.

    Parameters
    ----------
    output : FileOutput
    compression : Compression
    chunk_bytes : int
        A chunk is closed when it has as many.
    profile, library : str
        Of the header.

    Attributes
    ----------
    summary : Summary
        Of what is in the file.
    """

    def __init__(
        self,
        output: FileOutput,
        compression: Compression,
        chunk_bytes: int,
        profile: str = "",
        library: str = "",
    ) -> None:
        self._output, self._compression, self._chunk_bytes = output, compression, chunk_bytes
        self.summary = Summary()
        self._chunk = OpenChunk()
        self._ready: deque[Piece] = deque()
        self._channels = 0
        self._crc = 0
        self._ready.append(Piece(MAGIC + octets(Header(profile, library)), lambda start: None, {}))

    @property
    def waiting(self) -> int:
        """Bytes that are not in the file yet."""
        return len(self._chunk) + sum(len(piece.data) for piece in self._ready)

    def add_channel(
        self,
        topic: str,
        encoding: str,
        schema: tuple[str, str, bytes],
        metadata: dict[str, str] | None = None,
    ) -> int:
        """Add a channel with its schema (name, encoding, text); its number."""
        self._channels += 1
        name, kind, text = schema
        self.put(Schema(self._channels, text, kind, name))
        self.put(Channel(self._channels, topic, encoding, metadata or {}, self._channels))
        return self._channels

    def add_attachment(self, name: str, media_type: str, data: bytes, time_ns: int) -> None:
        """Add a file."""
        self.put(Attachment(time_ns, time_ns, name, media_type, data))

    def put(self, record: Schema | Channel | Metadata | Attachment) -> None:
        """Add a record; schemas and channels have their numbers."""
        piece = octets(record)
        self._seal()
        self._ready.append(
            Piece(piece, lambda start: self.summary.add(*_entry(record, start, len(piece))), {})
        )

    def add_message(self, channel: int, sequence: int, time_ns: int, *parts: Bytes) -> None:
        """Add a message that consists of `parts`.

        Raises
        ------
        OSError
            If a chunk became full and could not be written: it waits, see `flush`.
        """
        self._chunk.add(channel, sequence, time_ns, parts)
        if len(self._chunk) >= self._chunk_bytes:
            self.flush()

    def flush(self) -> None:
        """Close the chunk and hand everything to the system.

        Raises
        ------
        OSError
            If something could not be written: it waits for the next call.
        """
        self._seal()
        while self._ready:
            piece, start = self._ready[0], self._output.end
            self._output.append(piece.data)
            self._crc = zlib.crc32(piece.data, self._crc)
            piece.written(start)
            self._ready.popleft()

    def sync(self) -> None:
        """Have the system write everything to the disk; raises OSError if it cannot."""
        self._output.sync()

    def give_up_waiting(self) -> Counter[int]:
        """Forget what could not be written; messages of each channel that are lost by that."""
        self._seal()
        lost: Counter[int] = Counter()
        for piece in self._ready:
            lost.update(piece.messages)
        self._ready.clear()
        return lost

    def finish(self) -> None:
        """Write what waits and the end of the file; raises OSError if that cannot be written."""
        self.flush()
        self._output.append(self.summary.ending(self._output.end, self._crc))
        self._output.sync()

    def _seal(self) -> None:
        if not self._chunk:
            return
        piece, entry, messages = self._chunk.sealed(self._compression)
        self._chunk = OpenChunk()

        def written(start: int) -> None:
            entry.chunk_start_offset = start
            offsets = entry.message_index_offsets
            entry.message_index_offsets = {key: at + start for key, at in offsets.items()}
            self.summary.add_chunk(entry, messages)

        self._ready.append(Piece(piece, written, messages))


def _entry(
    record: Schema | Channel | Metadata | Attachment, start: int, length: int
) -> tuple[Opcode, Any]:
    """Kind and record of the summary, of a record of so many bytes from byte `start`."""
    if isinstance(record, Schema):
        return Opcode.SCHEMA, record
    if isinstance(record, Channel):
        return Opcode.CHANNEL, record
    if isinstance(record, Metadata):
        return Opcode.METADATA_INDEX, MetadataIndex(start, length, record.name)
    times, size = (record.log_time, record.create_time), len(record.data)
    index = AttachmentIndex(start, length, *times, size, record.name, record.media_type)
    return Opcode.ATTACHMENT_INDEX, index

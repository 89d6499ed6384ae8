"""MCAP container that grows by whole pieces, so that a full disk or a crash cuts no chunk in two.

mcap's own writer closes a chunk by its size alone, leaves half a chunk and a wrong index behind a
write that fails, and has the channels in the first chunk only; the records are mcap's own.
"""

import os
import zlib
from array import array
from collections import Counter, defaultdict, deque
from pathlib import Path
from struct import Struct
from typing import Any, NamedTuple

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
LEVEL = 1  # of zstandard: the quickest, a third smaller for 8-bit counts and little for 16-bit ones
CHUNK_BYTES = 1 << 19  # a chunk is closed when it has as many
Bytes = bytes | bytearray | memoryview
_FOOTER = Struct("<BQQQ")
_MESSAGE = Struct("<BQHIQQ")
_INDEX = Struct("<BQHI")
SUMMARY = (  # groups of records, in their order in the file
    Opcode.SCHEMA,
    Opcode.CHANNEL,
    Opcode.STATISTICS,
    Opcode.CHUNK_INDEX,
    Opcode.ATTACHMENT_INDEX,
    Opcode.METADATA_INDEX,
)


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
        try:
            self._file = path.open("wb" if overwrite else "xb", buffering=0)
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
                done = self.end + len(piece) - len(left)
                left = left[os.pwrite(self._file.fileno(), left, done) :]
        except OSError:
            self._file.truncate(self.end)  # what a full disk took of it
            raise
        self.end += len(piece)

    def sync(self) -> None:
        """Have the system write everything to the disk."""
        os.fdatasync(self._file.fileno())

    def close(self) -> None:
        """Let go of the file."""
        self._file.close()


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

    def sealed(self) -> "Piece":
        """The chunk as bytes of the file with its index behind it."""
        import zstandard

        packed = zstandard.ZstdCompressor(level=LEVEL).compress(bytes(self.data))
        times = {"message_start_time": self._first_ns, "message_end_time": self._last_ns}
        size, crc = len(self.data), zlib.crc32(self.data)
        chunk = octets(Chunk("zstd", packed, uncompressed_crc=crc, uncompressed_size=size, **times))
        piece, offsets = bytearray(chunk), {}
        for channel, pairs in self._index.items():
            offsets[channel] = len(piece)
            table = pairs.tobytes()  # of this machine, which is little-endian as the file is
            piece += _INDEX.pack(Opcode.MESSAGE_INDEX, 6 + len(table), channel, len(table)) + table
        entry = ChunkIndex(
            chunk_length=len(chunk),
            chunk_start_offset=0,
            compression="zstd",
            compressed_size=len(packed),
            message_index_length=len(piece) - len(chunk),
            message_index_offsets=offsets,
            uncompressed_size=size,
            **times,
        )
        counts = {channel: len(pairs) // 2 for channel, pairs in self._index.items()}
        return Piece(bytes(piece), entry, counts)


class Piece(NamedTuple):
    """Bytes to be written, their entry in the index as if they stood at byte 0, messages in them.

    Attributes
    ----------
    data : bytes
    entry : record of mcap, or None
    messages : dict of int to int
        How many of each channel.
    """

    data: Bytes
    entry: Any = None
    messages: dict[int, int] = {}  # noqa: RUF012 - nobody writes into it


class Container:
    """Writes records; nothing that could not be written is forgotten.

    Parameters
    ----------
    output : FileOutput
    profile, library : str
        Of the header.

    Attributes
    ----------
    messages : Counter of int
        In the file, of each channel.
    first_ns, last_ns : int, ns
        Of these.
    """

    def __init__(self, output: FileOutput, profile: str = "", library: str = "") -> None:
        self._output = output
        self.messages: Counter[int] = Counter()
        self.first_ns = self.last_ns = 0
        self._groups: dict[Opcode, bytearray] = defaultdict(bytearray)  # of the index
        self._counts: Counter[Opcode] = Counter()
        self._chunk = OpenChunk()
        self._ready = deque([Piece(MAGIC + octets(Header(profile, library)))])
        self._crc = 0

    @property
    def waiting(self) -> int:
        """Bytes that are not in the file yet."""
        return len(self._chunk) + sum(len(piece.data) for piece in self._ready)

    def put(self, record: Schema | Channel | Metadata | Attachment) -> None:
        """Add a record; schemas and channels have their numbers."""
        piece = octets(record)
        entry: Any = record
        if isinstance(record, Metadata):
            entry = MetadataIndex(0, len(piece), record.name)
        elif isinstance(record, Attachment):
            entry = AttachmentIndex(
                0, len(piece), record.log_time, record.create_time, len(record.data), record.name,
                record.media_type,
            )  # fmt: skip
        self._seal()
        self._ready.append(Piece(piece, entry))

    def add_message(self, channel: int, sequence: int, time_ns: int, *parts: Bytes) -> None:
        """Add a message that consists of `parts`.

        Raises
        ------
        OSError
            If a chunk became full and could not be written: it waits, see `flush`.
        """
        self._chunk.add(channel, sequence, time_ns, parts)
        if len(self._chunk) >= CHUNK_BYTES:
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
            start = self._output.end
            self._output.append(self._ready[0].data)
            self._note(self._ready.popleft(), start)

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
        self._output.append(self._ending())
        self._output.sync()

    def _seal(self) -> None:
        if self._chunk:
            self._ready.append(self._chunk.sealed())
            self._chunk = OpenChunk()

    def _note(self, piece: Piece, start: int) -> None:
        """A piece is in the file, from byte `start` on."""
        entry = piece.entry
        self._crc = zlib.crc32(piece.data, self._crc)
        if entry is None:
            return
        if isinstance(entry, ChunkIndex):
            entry.chunk_start_offset = start
            offsets = entry.message_index_offsets
            entry.message_index_offsets = {key: at + start for key, at in offsets.items()}
            first = entry.message_start_time
            self.first_ns = min(first, self.first_ns) if self.messages else first
            self.last_ns = max(entry.message_end_time, self.last_ns)
            self.messages.update(piece.messages)
        elif isinstance(entry, AttachmentIndex | MetadataIndex):
            entry.offset = start
        data = octets(entry)
        self._groups[Opcode(data[0])] += data
        self._counts[Opcode(data[0])] += 1

    def _ending(self) -> bytes:
        """Everything after the data."""
        statistics = Statistics(
            attachment_count=self._counts[Opcode.ATTACHMENT_INDEX],
            channel_count=self._counts[Opcode.CHANNEL],
            channel_message_counts=dict(self.messages),
            chunk_count=self._counts[Opcode.CHUNK_INDEX],
            message_count=self.messages.total(),
            message_end_time=self.last_ns,
            message_start_time=self.first_ns,
            metadata_count=self._counts[Opcode.METADATA_INDEX],
            schema_count=self._counts[Opcode.SCHEMA],
        )
        groups: dict[Opcode, Bytes] = {**self._groups, Opcode.STATISTICS: octets(statistics)}
        data_end = octets(DataEnd(self._crc))
        base = self._output.end + len(data_end)
        body, offsets = bytearray(), bytearray()
        for opcode in SUMMARY:
            if group := groups.get(opcode):
                offsets += octets(SummaryOffset(opcode, base + len(body), len(group)))
                body += group
        offset_start = base + len(body)
        body += offsets
        check = zlib.crc32(_FOOTER.pack(Opcode.FOOTER, 20, base, offset_start), zlib.crc32(body))
        return data_end + bytes(body) + octets(Footer(base, offset_start, check)) + MAGIC

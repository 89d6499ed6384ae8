"""MCAP container that grows by whole pieces, so that a full disk or a crash cuts no chunk in two.

mcap's own writer closes a chunk by its size alone, leaves half a chunk and a wrong index behind a
write that fails, and has the channels in the first chunk only; the records are mcap's own.
"""

import os
import zlib
from collections import Counter, defaultdict, deque
from pathlib import Path
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
    Message,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)

from skinfield.errors import FileError, InputError

MAGIC = b"\x89MCAP0\r\n"
LEVEL = 1  # of zstandard: the quickest, a third smaller for 8-bit counts and little for 16-bit ones
CHUNK_BYTES = 1 << 19  # a chunk is closed when it has as many
Bytes = bytes | bytearray | memoryview


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
        self._groups: dict[int, list[bytes]] = defaultdict(list)  # of the summary
        self._records = RecordBuilder()  # of the open chunk
        self._index: dict[int, list[tuple[int, int]]] = defaultdict(list)
        self._ready = deque([Piece(MAGIC + octets(Header(profile, library)))])
        self._crc = 0

    @property
    def waiting(self) -> int:
        """Bytes that are not in the file yet."""
        return self._records.count + sum(len(piece.data) for piece in self._ready)

    def put(self, record: Schema | Channel | Metadata | Attachment) -> None:
        """Add a record; schemas and channels have their numbers."""
        piece = octets(record)
        entry: Any = record
        if isinstance(record, Metadata):
            entry = MetadataIndex(0, len(piece), record.name)
        elif isinstance(record, Attachment):
            times = record.log_time, record.create_time
            size, name = len(record.data), record.name
            entry = AttachmentIndex(0, len(piece), *times, size, name, record.media_type)
        self._seal()
        self._ready.append(Piece(piece, entry))

    def add_message(self, channel: int, sequence: int, time_ns: int, data: Bytes) -> None:
        """Add a message.

        Raises
        ------
        OSError
            If a chunk became full and could not be written: it waits, see `flush`.
        """
        self._index[channel].append((time_ns, self._records.count))
        message = Message(channel, time_ns, bytes(data), time_ns, sequence & 0xFFFFFFFF)
        message.write(self._records)
        if self._records.count >= CHUNK_BYTES:
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
        """Close the chunk: it waits as bytes of the file, with its index behind it."""
        import zstandard

        if not self._index:
            return
        records, index = self._records, self._index
        self._records, self._index = RecordBuilder(), defaultdict(list)
        data: bytes = records.end()  # type: ignore[no-untyped-call]
        packed = zstandard.ZstdCompressor(level=LEVEL).compress(data)
        stamps = [stamp for entries in index.values() for stamp, _ in entries]
        times = {"message_start_time": min(stamps), "message_end_time": max(stamps)}
        size, crc = len(data), zlib.crc32(data)
        chunk = octets(Chunk("zstd", packed, uncompressed_crc=crc, uncompressed_size=size, **times))
        piece, offsets = bytearray(chunk), {}
        for channel, entries in index.items():
            offsets[channel] = len(piece)
            piece += octets(MessageIndex(channel, entries))
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
        counts = {channel: len(entries) for channel, entries in index.items()}
        self._ready.append(Piece(bytes(piece), entry, counts))

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
        self._groups[data[0]].append(data)

    def _ending(self) -> bytes:
        """Everything after the data."""
        count = {opcode: len(entries) for opcode, entries in self._groups.items()}
        statistics = Statistics(
            attachment_count=count.get(Opcode.ATTACHMENT_INDEX, 0),
            channel_count=count.get(Opcode.CHANNEL, 0),
            channel_message_counts=dict(self.messages),
            chunk_count=count.get(Opcode.CHUNK_INDEX, 0),
            message_count=self.messages.total(),
            message_end_time=self.last_ns,
            message_start_time=self.first_ns,
            metadata_count=count.get(Opcode.METADATA_INDEX, 0),
            schema_count=count.get(Opcode.SCHEMA, 0),
        )
        groups = {**self._groups, Opcode.STATISTICS: [octets(statistics)]}
        summary = b"".join(b"".join(groups[opcode]) for opcode in sorted(groups))
        data_end = octets(DataEnd(self._crc))
        start = self._output.end + len(data_end)
        check = zlib.crc32(octets(Footer(start, 0, 0))[:-4], zlib.crc32(summary))
        return data_end + summary + octets(Footer(start, 0, check)) + MAGIC

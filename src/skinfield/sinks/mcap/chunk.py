"""Messages of one chunk, until it is written."""

import zlib
from array import array
from collections import defaultdict
from struct import Struct

from mcap.opcode import Opcode
from mcap.records import Chunk, ChunkIndex

from skinfield.sinks.mcap.compression import Bytes, Compression
from skinfield.sinks.mcap.summary import octets

_MESSAGE = Struct("<BQHIQQ")
_INDEX = Struct("<BQHI")


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

    @property
    def messages(self) -> dict[int, int]:
        """How many of each channel."""
        return {channel: len(pairs) // 2 for channel, pairs in self._index.items()}

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

    def sealed(self, compression: Compression) -> "SealedChunk":
        """The chunk as bytes of the file."""
        packed = compression.pack(bytes(self.data))
        return self.sealed_as(compression.name, bytes(packed))

    def sealed_as(self, name: str, packed: bytes) -> "SealedChunk":
        """The chunk as bytes of the file, where its content is compressed already."""
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
        index = ChunkIndex(
            chunk_length=len(chunk),
            chunk_start_offset=0,
            compression=name,
            compressed_size=len(packed),
            message_end_time=self._last_ns,
            message_index_length=0,
            message_index_offsets={},
            message_start_time=self._first_ns,
            uncompressed_size=len(self.data),
        )
        piece = bytearray(chunk)
        for channel, pairs in self._index.items():
            index.message_index_offsets[channel] = len(piece)
            table = pairs.tobytes()  # of this machine, which is little-endian as the file is
            piece += _INDEX.pack(Opcode.MESSAGE_INDEX, 6 + len(table), channel, len(table)) + table
        index.message_index_length = len(piece) - len(chunk)
        return SealedChunk(piece, index, self.messages)


class SealedChunk:
    """A chunk with its index, to be written.

    Attributes
    ----------
    piece : bytes
    messages : dict of int to int
        How many of each channel.
    """

    def __init__(self, piece: Bytes, index: ChunkIndex, messages: dict[int, int]) -> None:
        self.piece, self.messages, self._index = piece, messages, index

    def index_at(self, start: int) -> ChunkIndex:
        """Entry of the file's index, once the chunk stands at byte `start`."""
        index = self._index
        index.chunk_start_offset = start
        index.message_index_offsets = {
            channel: offset + start for channel, offset in index.message_index_offsets.items()
        }
        return index

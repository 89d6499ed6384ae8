"""An MCAP file that grows by whole pieces, so that a full disk or a crash cuts no chunk in two.

mcap's own writer would do, but for three things: a write that fails leaves half a chunk behind and
an index that is wrong; the level of compression is fixed; and channels stand in the first chunk
alone. Records are mcap's own.
"""

import zlib
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from mcap.records import Attachment, Channel, Header, Metadata, Schema

from skinfield.sinks.mcap.chunk import OpenChunk, SealedChunk
from skinfield.sinks.mcap.compression import Bytes, Compression
from skinfield.sinks.mcap.output import Output
from skinfield.sinks.mcap.summary import MAGIC, Summary, octets


@dataclass(frozen=True)
class Piece:
    """Bytes to be written, what to note then, and the messages in it."""

    data: Bytes
    written: Callable[[int], None]
    messages: dict[int, int]


class Container:
    """Writes records; nothing that could not be written is forgotten.

    Parameters
    ----------
    output : Output
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
        output: Output,
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
        self._append(MAGIC + octets(Header(profile, library)), lambda _: None)

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
        self.put_schema(Schema(self._channels, text, kind, name))
        self.put_channel(Channel(self._channels, topic, encoding, metadata or {}, self._channels))
        return self._channels

    def put_schema(self, schema: Schema) -> None:
        """Add a schema whose number is known."""
        self._seal()
        self._append(octets(schema), lambda _: self.summary.add_schema(schema))

    def put_channel(self, channel: Channel) -> None:
        """Add a channel whose number and schema are known."""
        self._seal()
        self._append(octets(channel), lambda _: self.summary.add_channel(channel))

    def put_metadata(self, metadata: Metadata) -> None:
        """Add a record of metadata."""
        piece = octets(metadata)
        self._seal()
        self._append(piece, lambda start: self.summary.add_metadata(metadata, start, len(piece)))

    def put_chunk(self, sealed: SealedChunk) -> None:
        """Add a chunk that is compressed already."""
        self._seal()
        self._ready_chunk(sealed)

    def add_attachment(self, name: str, media_type: str, data: bytes, time_ns: int) -> None:
        """Add a file."""
        attachment = Attachment(time_ns, time_ns, name, media_type, data)
        piece = octets(attachment)
        self._seal()
        self._append(
            piece, lambda start: self.summary.add_attachment(attachment, start, len(piece))
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

    def give_up_waiting(self) -> dict[int, int]:
        """Forget what could not be written; messages of each channel that are lost by that."""
        lost: dict[int, int] = {}
        self._seal()
        for piece in self._ready:
            for channel, count in piece.messages.items():
                lost[channel] = lost.get(channel, 0) + count
        self._ready.clear()
        return lost

    def finish(self) -> None:
        """Write what waits and the end of the file; raises OSError if that cannot be written."""
        self.flush()
        self._output.append(self.summary.ending(self._output.end, self._crc))
        self._output.sync()

    def _append(self, data: bytes, written: Callable[[int], None]) -> None:
        self._ready.append(Piece(data, written, {}))

    def _seal(self) -> None:
        if not self._chunk:
            return
        sealed = self._chunk.sealed(self._compression)
        self._chunk = OpenChunk()
        self._ready_chunk(sealed)

    def _ready_chunk(self, sealed: SealedChunk) -> None:
        def written(start: int) -> None:
            self.summary.add_chunk(sealed.index_at(start), sealed.messages)

        self._ready.append(Piece(sealed.piece, written, sealed.messages))

"""The end of an MCAP file: what it holds, and where."""

import zlib
from collections import defaultdict
from dataclasses import dataclass, field
from struct import Struct
from typing import Any

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

MAGIC = b"\x89MCAP0\r\n"
_FOOTER = Struct("<BQQQ")


def octets(record: Any) -> bytes:
    """Bytes of one of mcap's records, with its opcode and length."""
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]


@dataclass
class Summary:
    """Index and statistics of a file that is being written, as bytes of their records.

    Attributes
    ----------
    messages : dict of int to int
        Of each channel.
    """

    schemas: bytearray = field(default_factory=bytearray)
    channels: bytearray = field(default_factory=bytearray)
    chunks: bytearray = field(default_factory=bytearray)
    attachments: bytearray = field(default_factory=bytearray)
    metadata: bytearray = field(default_factory=bytearray)
    messages: dict[int, int] = field(default_factory=lambda: defaultdict(int))
    first_ns: int = 0
    last_ns: int = 0
    counts: dict[str, int] = field(default_factory=lambda: defaultdict(int))

    def add_schema(self, schema: Schema) -> None:
        """A schema is in the file."""
        self.schemas += octets(schema)
        self.counts["schema"] += 1

    def add_channel(self, channel: Channel) -> None:
        """A channel is in the file."""
        self.channels += octets(channel)
        self.counts["channel"] += 1

    def add_attachment(self, attachment: Attachment, start: int, length: int) -> None:
        """An attachment is in the file, `length` bytes from byte `start`."""
        index = AttachmentIndex(
            start,
            length,
            attachment.log_time,
            attachment.create_time,
            len(attachment.data),
            attachment.name,
            attachment.media_type,
        )
        self.attachments += octets(index)
        self.counts["attachment"] += 1

    def add_metadata(self, metadata: Metadata, start: int, length: int) -> None:
        """A metadata record is in the file."""
        self.metadata += octets(MetadataIndex(start, length, metadata.name))
        self.counts["metadata"] += 1

    def add_chunk(self, index: ChunkIndex, messages: dict[int, int]) -> None:
        """A chunk is in the file, with so many messages of each channel."""
        self.chunks += octets(index)
        first = not self.counts["chunk"]
        self.counts["chunk"] += 1
        for channel, count in messages.items():
            self.messages[channel] += count
        start, end = index.message_start_time, index.message_end_time
        self.first_ns = start if first else min(start, self.first_ns)
        self.last_ns = max(end, self.last_ns)

    def ending(self, start: int, crc: int) -> bytes:
        """Everything after the data, for a file whose data ends at byte `start`.

        Parameters
        ----------
        start : int, bytes
        crc : int
            CRC-32 of all bytes before; 0 if not known.
        """
        data_end = octets(DataEnd(crc))
        base = start + len(data_end)
        body, offsets = bytearray(), bytearray()
        for opcode, group in self._groups():
            if group:
                offsets += octets(SummaryOffset(opcode, base + len(body), len(group)))
            body += group
        offset_start = base + len(body)
        body += offsets
        check = zlib.crc32(_FOOTER.pack(Opcode.FOOTER, 20, base, offset_start), zlib.crc32(body))
        return data_end + bytes(body) + octets(Footer(base, offset_start, check)) + MAGIC

    def _groups(self) -> list[tuple[Opcode, bytes]]:
        said = self.counts
        statistics = Statistics(
            attachment_count=said["attachment"],
            channel_count=said["channel"],
            channel_message_counts=dict(self.messages),
            chunk_count=said["chunk"],
            message_count=sum(self.messages.values()),
            message_end_time=self.last_ns,
            message_start_time=self.first_ns,
            metadata_count=said["metadata"],
            schema_count=said["schema"],
        )
        return [
            (Opcode.SCHEMA, bytes(self.schemas)),
            (Opcode.CHANNEL, bytes(self.channels)),
            (Opcode.STATISTICS, octets(statistics)),
            (Opcode.CHUNK_INDEX, bytes(self.chunks)),
            (Opcode.ATTACHMENT_INDEX, bytes(self.attachments)),
            (Opcode.METADATA_INDEX, bytes(self.metadata)),
        ]

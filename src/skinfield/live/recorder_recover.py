"""A whole file from what a crash, a full disk or a bad sector left of a recording."""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from skinfield.errors import FileError, InputError
from skinfield.sinks.mcap.chunk import OpenChunk
from skinfield.sinks.mcap.compression import Zstd
from skinfield.sinks.mcap.container import Container
from skinfield.sinks.mcap.output import FileOutput
from skinfield.sources.recordings.mcap_bodies import (
    CHUNK_HEAD,
    Damaged,
    Message,
    Op,
    attachment_of,
    chunk_content,
    inner_records,
    message_of,
    parsed,
)
from skinfield.sources.recordings.mcap_records import (
    Damage,
    Outline,
    Record,
    body_of,
    open_file,
    outline_of,
    right_end,
)

Progress = Callable[[int, int], None]


@dataclass
class Recovered:
    """What was saved and what was not.

    Attributes
    ----------
    size : int, bytes
        Of the damaged file.
    was_whole : bool
        Whether nothing was wrong with it.
    messages : dict of str to int
        Saved, by topic.
    first_ns, last_ns : int, ns
        Of the messages that were saved; 0 without one.
    dropped_bytes : int
        At the end of the damaged file: what belongs to no whole record.
    chunk_was_cut : bool
        Whether these are a chunk's beginning.
    damage : list of Damage
        Places that were left out, by their bytes in the damaged file.
    """

    size: int
    was_whole: bool = False
    messages: Counter[str] = field(default_factory=Counter)
    first_ns: int = 0
    last_ns: int = 0
    dropped_bytes: int = 0
    chunk_was_cut: bool = False
    damage: list[Damage] = field(default_factory=list)


def recover(
    bad: str | Path,
    good: str | Path,
    *,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> Recovered:
    """Write everything that can be read of an MCAP file into a new, whole one.

    Chunks are copied as they are once their checksum is found right; the index is made anew.

    Parameters
    ----------
    bad, good : str or Path
    overwrite : bool
        Whether a file named `good` may be replaced.
    progress : callable, optional
        Called with bytes done and bytes in all.

    Raises
    ------
    FileError
        If `bad` cannot be read or is no MCAP file, or `good` cannot be written.
    InputError
        If they are one file, or `good` is there already.
    """
    bad, good = Path(bad), Path(good)
    with open_file(bad) as file:
        if good.exists() and good.samefile(bad):
            raise InputError(f"{good} is the damaged file itself, expected another name")
        outline = outline_of(file)
        output = FileOutput(good, overwrite=overwrite)
        try:
            salvage = _Salvage(
                file, outline, Container(output, Zstd(), 1 << 19, *_profile(file, outline))
            )
            for record in outline.records:
                salvage.take(record)
                if progress is not None:
                    progress(record.end, outline.size)
            if outline.finished and (wrong := right_end(file, outline)) is not None:
                salvage.damage.append(wrong)
            salvage.container.finish()
        except OSError as error:
            raise FileError(f"{bad} to {good}: {error.strerror or error}") from error
        finally:
            output.close()
    return salvage.report()


@dataclass
class _Salvage:
    """What was found so far, and where it goes."""

    file: BinaryIO
    outline: Outline
    container: Container
    topics: dict[int, str] = field(default_factory=dict)
    schemas: set[int] = field(default_factory=set)
    damage: list[Damage] = field(default_factory=list)

    def take(self, record: Record) -> None:
        """Save a record, or note why not."""
        if record.opcode in (Op.HEADER, Op.MESSAGE_INDEX):
            return  # written anew
        try:
            body = body_of(self.file, record)
            if record.opcode == Op.CHUNK:
                self._chunk(body)
            elif record.opcode == Op.MESSAGE:
                self._message(message_of(body, 0, len(body)))
            else:
                self._other(record.opcode, body)
            self.container.flush()
        except Damaged as error:
            self.damage.append(Damage(record.start, str(error)))

    def report(self) -> Recovered:
        """What came of it."""
        outline, summary = self.outline, self.container.summary
        found = Recovered(outline.size, damage=list(self.damage))
        found.was_whole = outline.finished and not self.damage
        if not outline.finished:
            found.dropped_bytes = outline.size - outline.end
            if outline.damage is not None:
                found.damage.append(outline.damage)
                self.file_head(found, outline.damage.byte)
        found.first_ns, found.last_ns = summary.first_ns, summary.last_ns
        for channel, count in summary.messages.items():
            found.messages[self.topics[channel]] += count
        return found

    def file_head(self, found: Recovered, byte: int) -> None:
        """See whether a chunk begins at `byte`."""
        with open_file(Path(self.file.name)) as again:
            again.seek(byte)
            found.chunk_was_cut = again.read(1) == bytes([Op.CHUNK])

    def _chunk(self, body: bytes) -> None:
        content = chunk_content(body)
        chunk, plain = OpenChunk(), True
        for opcode, message in self._inner(content):
            if opcode == Op.MESSAGE and message is not None and message.channel in self.topics:
                chunk.add(message.channel, message.sequence, message.time_ns, (message.data,))
            else:
                plain = False
        if not chunk:
            return
        if plain and chunk.data == content:
            length = int.from_bytes(body[CHUNK_HEAD.size : CHUNK_HEAD.size + 4], "little")
            at = CHUNK_HEAD.size + 4 + length
            name = body[CHUNK_HEAD.size + 4 : at].decode()
            self.container.put_chunk(chunk.sealed_as(name, body[at + 8 :]))
        else:
            self.container.put_chunk(chunk.sealed(Zstd()))

    def _inner(self, content: bytes) -> Iterator[tuple[int, Message | None]]:
        for opcode, start, end in inner_records(content):
            if opcode == Op.MESSAGE:
                yield opcode, message_of(content, start, end)
            else:
                self._other(opcode, content[start:end])
                yield opcode, None

    def _message(self, message: Message) -> None:
        if message.channel in self.topics:
            self.container.add_message(
                message.channel, message.sequence, message.time_ns, message.data
            )

    def _other(self, opcode: int, body: bytes) -> None:
        if opcode == Op.ATTACHMENT:
            self._attachment(body)
        elif opcode == Op.SCHEMA:
            schema = parsed(Op.SCHEMA, body)
            if schema.id and schema.id not in self.schemas:
                self.schemas.add(schema.id)
                self.container.put_schema(schema)
        elif opcode == Op.CHANNEL:
            channel = parsed(Op.CHANNEL, body)
            if channel.id not in self.topics:
                if channel.schema_id not in self.schemas:
                    channel.schema_id = 0  # its schema is lost; readers refuse an unknown one
                self.topics[channel.id] = channel.topic
                self.container.put_channel(channel)
        elif opcode == Op.METADATA:
            self.container.put_metadata(parsed(Op.METADATA, body))

    def _attachment(self, body: bytes) -> None:
        found = attachment_of(body)
        time_ns = int.from_bytes(body[:8], "little")
        self.container.add_attachment(found.name, found.media_type, found.data, time_ns)


def _profile(file: BinaryIO, outline: Outline) -> tuple[str, str]:
    """Profile and library of the header; empty where it is damaged."""
    if outline.records and outline.records[0].opcode == Op.HEADER:
        try:
            header = parsed(Op.HEADER, body_of(file, outline.records[0]))
        except Damaged:
            return "", ""
        return header.profile, header.library
    return "", ""

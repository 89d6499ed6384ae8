"""Recovery of recordings: a whole file from what a crash, a full disk or a bad sector left."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from skinfield.errors import FileError, InputError
from skinfield.files.mcap.container import Container, FileOutput
from skinfield.files.mcap.records import (
    Damage,
    Damaged,
    Op,
    Outline,
    Record,
    attachment_of,
    entries_of,
    header_of,
    message_of,
    open_file,
    outline_of,
    parsed,
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
    bad: str | Path, good: str | Path, *, overwrite: bool = False, progress: Progress | None = None
) -> Recovered:
    """Write everything that can be read of an MCAP file into a new, whole one.

    Chunks whose checksum is right are read and written anew, and so is the index.

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
            container = Container(output, *header_of(file, outline))
            salvage = _Salvage(file, outline, container)
            for record in outline.records:
                salvage.take(record)
                if progress is not None:
                    progress(record.end, outline.size)
            salvage.container.finish()
            return salvage.report()
        except OSError as error:
            raise FileError(f"{bad} to {good}: {error.strerror or error}") from error
        finally:
            output.close()


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
        """Save a record, or what of a chunk is whole, or note why not."""
        if record.opcode in (Op.HEADER, Op.MESSAGE_INDEX):
            return  # written anew
        try:
            for opcode, _, body in entries_of(self.file, record):
                self._save(opcode, body)
        except Damaged as error:
            self.damage.append(Damage(record.start, str(error)))
        if record.opcode == Op.CHUNK:
            self.container.flush()

    def report(self) -> Recovered:
        """What came of it."""
        outline, container, damage = self.outline, self.container, self.damage
        if outline.finished and (wrong := right_end(self.file, outline)) is not None:
            damage.append(wrong)
        found = Recovered(outline.size, outline.finished and not damage, damage=damage)
        if not outline.finished:
            found.dropped_bytes = outline.size - outline.end
            if outline.damage is not None:
                damage.append(outline.damage)
                self.file.seek(outline.damage.byte)
                found.chunk_was_cut = self.file.read(1) == bytes([Op.CHUNK])
        found.first_ns, found.last_ns = container.first_ns, container.last_ns
        for channel, count in container.messages.items():
            found.messages[self.topics[channel]] += count
        return found

    def _save(self, opcode: int, body: bytes) -> None:
        container = self.container
        if opcode == Op.MESSAGE:
            message = message_of(body)
            if message.channel in self.topics:
                container.add_message(*message)
        elif opcode == Op.ATTACHMENT:
            container.put(attachment_of(body))
        elif opcode == Op.SCHEMA:
            schema = parsed(Op.SCHEMA, body)
            if schema.id and schema.id not in self.schemas:
                self.schemas.add(schema.id)
                container.put(schema)
        elif opcode == Op.CHANNEL:
            channel = parsed(Op.CHANNEL, body)
            if channel.id not in self.topics:
                if channel.schema_id not in self.schemas:
                    channel.schema_id = 0  # its schema is lost; readers refuse an unknown one
                self.topics[channel.id] = channel.topic
                container.put(channel)
        elif opcode == Op.METADATA:
            container.put(parsed(Op.METADATA, body))

"""Recordings of a live skin, whole or cut: what they hold, message by message."""

import json
from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, BinaryIO, Self, TypeVar

from skinfield.acquisition.recorded import (
    BLOCKS,
    CALIBRATION,
    CONFIGURATION,
    CYCLES,
    DESCRIPTION,
    EVENTS,
    LAYOUT,
    POSITION,
    TIMING,
    Cycle,
    CycleLayout,
)
from skinfield.conditioning import Calibration
from skinfield.errors import FileError, InputError
from skinfield.layout import Skin
from skinfield.sources.recordings.mcap_bodies import (
    Attached,
    Channel,
    Damaged,
    Logged,
    Message,
    Op,
    attachment_of,
    channel_of,
    chunk_content,
    inner_records,
    message_of,
)
from skinfield.sources.recordings.mcap_records import (
    Damage,
    Outline,
    Record,
    body_of,
    open_file,
    outline_of,
)

T = TypeVar("T")


@dataclass
class LiveRecording:
    """What a recording of a live skin holds; made by `LiveRecording.open`.

    A file that was not finished is read as far as it goes. What cannot be read is passed over and
    told in `damage`: at once where the walk from record to record ends, else when a method comes
    to it.

    Attributes
    ----------
    path : Path
    outline : Outline
        Records of the file, and whether it was finished.
    channels : dict of int to Channel
    attached : dict of str to Attached
    damage : list of Damage
        Places that cannot be read, by their bytes in the file, so far.
    """

    path: Path
    outline: Outline
    channels: dict[int, Channel] = field(default_factory=dict)
    attached: dict[str, Attached] = field(default_factory=dict)
    damage: list[Damage] = field(default_factory=list)

    @classmethod
    def open(cls, path: str | Path) -> Self:
        """Look at all records' heads, and read channels and attachments.

        Raises
        ------
        FileError
            If the file cannot be read, is no MCAP file, or has no channel of ours.
        """
        path = Path(path)
        with open_file(path) as file:
            found = cls(path, outline_of(file))
            if found.outline.damage is not None:
                found.damage.append(found.outline.damage)
            found._read_heads(file)
            if not found._has_channels():
                found._look_into_chunks(file)
        if not found._has_channels():
            there = ", ".join(sorted(each.topic for each in found.channels.values())[:8])
            where = (
                f"; it cannot be read from byte {found.damage[0].byte} on" if found.damage else ""
            )
            raise FileError(
                f"{path} has the channels {there or 'none'}, expected {BLOCKS}: it is no recording "
                f"of a skin{where}"
            )
        return found

    @property
    def finished(self) -> bool:
        """Whether the file was closed as it should; else the end may be missing."""
        return self.outline.finished

    @cached_property
    def skin(self) -> Skin:
        """Layout of the skin; raises FileError if none is enclosed or it is damaged."""
        from skinfield.layout.formats import read_layout

        with TemporaryDirectory() as folder:
            copy = Path(folder) / LAYOUT
            copy.write_bytes(self._enclosed(LAYOUT))
            return self._explained(lambda: read_layout(copy)[0], LAYOUT)

    @cached_property
    def calibrations(self) -> dict[str, Calibration]:
        """Calibrations by patch, as far as enclosed; raises FileError if one is damaged."""
        from skinfield.conditioning import load_calibration

        start, end = CALIBRATION.split("{patch}")
        found = {}
        with TemporaryDirectory() as folder:
            copy = Path(folder) / "calibration.npz"
            for name, attached in self.attached.items():
                if name.startswith(start) and name.endswith(end):
                    copy.write_bytes(attached.data)
                    patch = name.removeprefix(start).removesuffix(end)
                    found[patch] = self._explained(lambda: load_calibration(copy), name)
        return found

    @cached_property
    def configuration(self) -> dict[str, Any]:
        """How the engine was run; empty if not enclosed. Raises FileError if it is damaged."""
        return self._json(CONFIGURATION)

    @cached_property
    def description(self) -> dict[str, Any]:
        """Of the ring; empty if not enclosed. Raises FileError if it is damaged."""
        return self._json(DESCRIPTION)

    @cached_property
    def cycle_layout(self) -> CycleLayout:
        """Fields of the cycles' rows; raises FileError if the channel does not state them."""
        for channel in self.channels.values():
            if channel.topic == CYCLES:
                try:
                    return CycleLayout.from_metadata(channel.metadata)
                except InputError as error:
                    raise FileError(f"{self.path}: {error}") from error
        raise FileError(f"{self.path} has no channel {CYCLES}, expected one: its head is damaged")

    def messages(
        self, topics: Collection[str] = (), first: int = 0
    ) -> Iterator[tuple[str, int, Message]]:
        """Topic, byte in the file, and message, in the order of the file.

        Parameters
        ----------
        topics : collection of str
            Default all.
        first : int
            Record to begin with, such as `Moments` tells.
        """
        with open_file(self.path) as file:
            for record in self.outline.records[first:]:
                try:
                    for message in self._messages_in(file, record):
                        channel = self.channels.get(message.channel)
                        if channel is not None and (not topics or channel.topic in topics):
                            yield channel.topic, record.start, message
                except Damaged as error:
                    self.note(record.start, str(error))
                except OSError as error:
                    why = error.strerror or error
                    raise FileError(
                        f"{self.path} cannot be read at byte {record.start}: {why}"
                    ) from error

    def blocks(self) -> Iterator[Logged]:
        """Runs of the ring's log, in order."""
        for _, at, message in self.messages((BLOCKS,)):
            if (logged := self.logged_of(at, message)) is not None:
                yield logged

    def cycles(self) -> Iterator[Cycle]:
        """Cycles of the engine, in order."""
        for _, at, message in self.messages((CYCLES,)):
            if (cycle := self.cycle_of(at, message)) is not None:
                yield cycle

    def timing(self) -> Iterator[dict[str, Any]]:
        """What was measured, second by second."""
        yield from self._objects(TIMING)

    def events(self) -> Iterator[dict[str, Any]]:
        """What happened: `wall_ns`, `kind`, `text` and more, by kind."""
        yield from self._objects(EVENTS)

    def logged_of(self, at: int, message: Message) -> Logged | None:
        """Blocks of a message at byte `at`; None, and a note, if it is too short."""
        if len(message.data) < POSITION.size:
            self.note(at, f"a message of {BLOCKS} of {len(message.data)} bytes")
            return None
        (position,) = POSITION.unpack_from(message.data)
        return Logged(position, message.time_ns, message.data[POSITION.size :])

    def cycle_of(self, at: int, message: Message) -> Cycle | None:
        """Cycle of a message at byte `at`; None, and a note, if it cannot be read."""
        try:
            return self.cycle_layout.decode(message.data)
        except InputError as error:
            self.note(at, str(error))
            return None

    def _objects(self, topic: str) -> Iterator[dict[str, Any]]:
        for _, at, message in self.messages((topic,)):
            try:
                value = json.loads(message.data)
            except (ValueError, RecursionError) as error:
                self.note(at, f"a message of {topic} that is no JSON ({str(error)[:60]})")
                continue
            if isinstance(value, Mapping):
                yield dict(value)
            else:
                self.note(at, f"a message of {topic} that is no object")

    def _messages_in(self, file: BinaryIO, record: Record) -> Iterator[Message]:
        if record.opcode == Op.MESSAGE:
            body = body_of(file, record)
            yield message_of(body, 0, len(body))
        elif record.opcode == Op.CHUNK:
            content = chunk_content(body_of(file, record))
            for opcode, start, end in inner_records(content):
                if opcode == Op.MESSAGE:
                    yield message_of(content, start, end)
                elif opcode == Op.CHANNEL:
                    self._add_channel(content[start:end])

    def _read_heads(self, file: BinaryIO) -> None:
        for record in self.outline.records:
            try:
                if record.opcode == Op.CHANNEL:
                    self._add_channel(body_of(file, record))
                elif record.opcode == Op.ATTACHMENT:
                    attached = attachment_of(body_of(file, record))
                    self.attached[attached.name] = attached
            except Damaged as error:
                self.note(record.start, str(error))

    def _look_into_chunks(self, file: BinaryIO) -> None:
        """Channels that other writers put into the first chunk."""
        for record in self.outline.records:
            if record.opcode == Op.CHUNK and not self._has_channels():
                with suppress(Damaged):  # told when its messages are read
                    deque(self._messages_in(file, record), 0)

    def _add_channel(self, body: bytes) -> None:
        channel = channel_of(body)
        self.channels[channel.number] = channel

    def _has_channels(self) -> bool:
        return any(channel.topic == BLOCKS for channel in self.channels.values())

    def _enclosed(self, name: str) -> bytes:
        if name not in self.attached:
            there = ", ".join(sorted(self.attached)[:8]) or "nothing"
            raise FileError(f"{self.path} encloses {there}, expected {name}")
        return self.attached[name].data

    def _json(self, name: str) -> dict[str, Any]:
        if name not in self.attached:
            return {}
        try:
            value = json.loads(self.attached[name].data)
        except (ValueError, RecursionError) as error:
            raise FileError(f"{self.path}: {name} is no JSON: {error}") from error
        if not isinstance(value, dict):
            raise FileError(f"{self.path}: {name} is no object, expected one")
        return value

    def _explained(self, read: Callable[[], T], name: str) -> T:
        try:
            return read()
        except InputError as error:
            raise FileError(f"{self.path}: {name} cannot be used: {error}") from error

    def note(self, byte: int, why: str) -> None:
        """Keep in `damage` what cannot be read, and where."""
        damage = Damage(byte, why)
        if damage not in self.damage[-64:]:
            self.damage.append(damage)

"""Recordings of a live skin, whole or cut: what they hold, message by message, and when."""

import json
from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from struct import Struct
from tempfile import TemporaryDirectory
from typing import Any, BinaryIO, NamedTuple, Self, TypeVar

from mcap.records import Attachment, Channel

from skinfield.errors import FileError, InputError
from skinfield.files.mcap import records, schema
from skinfield.signal import Calibration
from skinfield.skin import Skin

T = TypeVar("T")
HEAD = Struct("<4xIq32xq")  # of a cycle's head: flags, number, wall_ns
PUBLISHED = Struct("<8xq")  # of the head of a field: when it was


class Logged(NamedTuple):
    """A run of the ring's log.

    Attributes
    ----------
    position : int, bytes
        Of its first byte in the log.
    data : bytes
        Blocks, see `skinfield.signal.blocks_of`.
    """

    position: int
    data: bytes

    @classmethod
    def of(cls, data: bytes) -> Self:
        """Of a message; raises InputError if it is too short."""
        if len(data) < schema.POSITION.size:
            raise InputError(f"a message of {schema.BLOCKS} of {len(data)} bytes")
        (position,) = schema.POSITION.unpack_from(data)
        return cls(position, data[schema.POSITION.size :])


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
        As mcap has them.
    attached : dict of str to Attachment
        By their names, likewise.
    damage : list of Damage
        Places that cannot be read, by their bytes in the file, so far.
    """

    path: Path
    outline: records.Outline
    channels: dict[int, Channel] = field(default_factory=dict)
    attached: dict[str, Attachment] = field(default_factory=dict)
    damage: list[records.Damage] = field(default_factory=list)

    @classmethod
    def open(cls, path: str | Path) -> Self:
        """Look at all records' heads, and read channels and attachments.

        Raises
        ------
        FileError
            If the file cannot be read, is no MCAP file, or has no channel of ours.
        """
        path = Path(path)
        with records.open_file(path) as file:
            found = cls(path, records.outline_of(file))
            if found.outline.damage is not None:
                found.damage.append(found.outline.damage)
            found._read_heads(file)
            for record in found.outline.records:  # other writers put channels into the first chunk
                if record.opcode == records.Op.CHUNK and not found._has_channels():
                    deque(found.messages_in(file, record), 0)
        if not found._has_channels():
            there = ", ".join(sorted(each.topic for each in found.channels.values())[:8])
            where = (
                f"; it cannot be read from byte {found.damage[0].byte} on" if found.damage else ""
            )
            raise FileError(
                f"{path} has the channels {there or 'none'}, expected {schema.BLOCKS}: it is no "
                f"recording of a skin{where}"
            )
        return found

    @property
    def finished(self) -> bool:
        """Whether the file was closed as it should; else the end may be missing."""
        return self.outline.finished

    @cached_property
    def skin(self) -> Skin:
        """Layout of the skin; raises FileError if none is enclosed or it is damaged."""
        from skinfield.files.layouts.load import read_layout

        return self._loaded(schema.LAYOUT, lambda path: read_layout(path)[0])

    @cached_property
    def calibrations(self) -> dict[str, Calibration]:
        """Calibrations by patch, as far as enclosed; raises FileError if one is damaged."""
        from skinfield.signal import load_calibration

        start, end = schema.CALIBRATION.split("{patch}")
        return {
            name.removeprefix(start).removesuffix(end): self._loaded(name, load_calibration)
            for name in self.attached
            if name.startswith(start) and name.endswith(end)
        }

    @cached_property
    def configuration(self) -> dict[str, Any]:
        """How the engine was run; empty if not enclosed. Raises FileError if it is damaged."""
        return self._json(schema.CONFIGURATION)

    @property
    def relative(self) -> bool:
        """Whether forces hold up to one factor only; older recordings do not say it."""
        return bool(self.configuration.get("relative", True))

    @cached_property
    def description(self) -> dict[str, Any]:
        """Of the ring; empty if not enclosed. Raises FileError if it is damaged."""
        return self._json(schema.DESCRIPTION)

    @cached_property
    def cycle_layout(self) -> schema.CycleLayout:
        """Fields of the cycles' rows; raises FileError if the channel does not state them."""
        for channel in self.channels.values():
            if channel.topic == schema.CYCLES:
                try:
                    return schema.CycleLayout.from_metadata(channel.metadata)
                except InputError as error:
                    raise FileError(f"{self.path}: {schema.CYCLES}: {error}") from error
        raise FileError(
            f"{self.path} has no channel {schema.CYCLES}, expected one: its head is damaged"
        )

    def messages(
        self, topics: Collection[str] = (), first: int = 0
    ) -> Iterator[tuple[str, int, records.Message]]:
        """Topic, byte in the file, and message, in the order of the file.

        Parameters
        ----------
        topics : collection of str
            Default all.
        first : int
            Record to begin with, such as `Index.record_before` gives.
        """
        with records.open_file(self.path) as file:
            for record in self.outline.records[first:]:
                for topic, message, _ in self.messages_in(file, record):
                    if not topics or topic in topics:
                        yield topic, record.start, message

    def blocks(self) -> Iterator[Logged]:
        """Runs of the ring's log, in order."""
        return self._all(schema.BLOCKS)

    def cycles(self) -> Iterator[schema.Cycle]:
        """Cycles of the engine, in order; raises as `cycle_layout`."""
        return self._all(schema.CYCLES)

    def fields(self) -> Iterator[schema.FieldRecord]:
        """What some cycles read, and their pressure, in order."""
        return self._all(schema.FIELDS)

    def timing(self) -> Iterator[dict[str, Any]]:
        """What was measured, second by second."""
        return self._all(schema.TIMING)

    def events(self) -> Iterator[dict[str, Any]]:
        """What happened: `wall_ns`, `kind`, `text` and more, by kind."""
        return self._all(schema.EVENTS)

    def contents(
        self, topics: Collection[str] = (), first: int = 0
    ) -> Iterator[tuple[str, int, Any]]:
        """Topic, byte in the file, and what a message there says; arguments as of `messages`."""
        for topic, at, message in self.messages(topics, first):
            if (what := self.decoded(topic, at, message.data)) is not None:
                yield topic, at, what

    def decoded(self, topic: str, at: int, data: bytes) -> Any:
        """What a message at byte `at` says, as the method of its topic has it.

        None, and a note, if it cannot be read. Raises FileError if its rows are not stated.
        """
        decode: Callable[[bytes], Any] = Logged.of if topic == schema.BLOCKS else _object
        if topic == schema.FIELDS:
            decode = schema.FieldRecord.decode
        elif topic == schema.CYCLES:
            decode = self.cycle_layout.decode
        try:
            return decode(data)
        except InputError as error:
            self.note(at, str(error))
            return None

    def _all(self, topic: str) -> Iterator[Any]:
        return (what for _, _, what in self.contents((topic,)))

    @cached_property
    def index(self) -> "Index":
        """When what was; found by one pass over the file. Raises FileError if it cannot be read."""
        return Index.of(self)

    def messages_in(
        self, file: BinaryIO, record: records.Record
    ) -> Iterator[tuple[str, records.Message, int]]:
        """Topic, message, and its place in the record; what cannot be read is noted."""
        if record.opcode not in (records.Op.MESSAGE, records.Op.CHUNK):
            return
        try:
            for opcode, start, body in records.entries_of(file, record):
                if opcode == records.Op.CHANNEL:
                    self._add_channel(body)
                elif opcode == records.Op.MESSAGE:
                    message = records.message_of(body)
                    if (channel := self.channels.get(message.channel)) is not None:
                        yield channel.topic, message, start
        except records.Damaged as error:
            self.note(record.start, str(error))
        except OSError as error:
            why = error.strerror or error
            raise FileError(f"{self.path} cannot be read at byte {record.start}: {why}") from error

    def _read_heads(self, file: BinaryIO) -> None:
        for record in self.outline.records:
            try:
                if record.opcode == records.Op.CHANNEL:
                    self._add_channel(records.body_of(file, record))
                elif record.opcode == records.Op.ATTACHMENT:
                    attached = records.attachment_of(records.body_of(file, record))
                    self.attached[attached.name] = attached
            except records.Damaged as error:
                self.note(record.start, str(error))

    def _add_channel(self, body: bytes) -> None:
        channel = records.parsed(records.Op.CHANNEL, body)
        self.channels[channel.id] = channel

    def _has_channels(self) -> bool:
        return any(channel.topic == schema.BLOCKS for channel in self.channels.values())

    def _loaded(self, name: str, load: Callable[[Path], T]) -> T:
        """An attachment as a file's reader has it."""
        if name not in self.attached:
            there = ", ".join(sorted(self.attached)[:8]) or "nothing"
            raise FileError(f"{self.path} encloses {there}, expected {name}")
        with TemporaryDirectory() as folder:
            copy = Path(folder) / schema.LAYOUT
            copy.write_bytes(self.attached[name].data)
            try:
                return load(copy)
            except InputError as error:
                raise FileError(f"{self.path}: {name} cannot be used: {error}") from error

    def _json(self, name: str) -> dict[str, Any]:
        if name not in self.attached:
            return {}
        try:
            return _object(self.attached[name].data)
        except InputError as error:
            raise FileError(f"{self.path}: {name}: {error}") from error

    def note(self, byte: int, why: str) -> None:
        """Keep in `damage` what cannot be read, and where."""
        damage = records.Damage(byte, why)
        if damage not in self.damage[-64:]:
            self.damage.append(damage)


def _object(data: bytes) -> dict[str, Any]:
    """An object of JSON; raises InputError."""
    try:
        value = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise InputError(f"it is no JSON: {str(error)[:60]}") from error
    if not isinstance(value, dict):
        raise InputError(f"it is {str(value)[:40]!r}, expected an object of JSON")
    return value


class MessagePlace(NamedTuple):
    """Where a message stands.

    Attributes
    ----------
    time_ns : int, ns
        What it says when it was, since the epoch.
    record, start : int
        Number of the record, and the byte of the message in its content.
    """

    time_ns: int
    record: int
    start: int


@dataclass
class Index:
    """Times of a recording, ns since the epoch; `LiveRecording.index` makes it.

    Attributes
    ----------
    cycles : int
    first_ns, last_ns : int, ns
        Of the first and of the last cycle; 0 of a recording without any.
    gaps : list of pair of int, ns
        Last cycle before and first behind each place where cycles are missing.
    starts : list of pair of int
        Where reading can begin: time of the first cycle in a record, and the record's number.
    fields : list of MessagePlace
        Of `FIELDS`, by time.
    events : list of dict
        See `LiveRecording.events`.
    """

    cycles: int = 0
    first_ns: int = 0
    last_ns: int = 0
    gaps: list[tuple[int, int]] = field(default_factory=list)
    starts: list[tuple[int, int]] = field(default_factory=list)
    fields: list[MessagePlace] = field(default_factory=list)
    events: list[dict[str, Any]] = field(default_factory=list)
    _number: int = 0

    @classmethod
    def of(cls, recording: LiveRecording) -> Self:
        """Look through a recording; what cannot be read is passed over and noted there."""
        found = cls()
        with records.open_file(recording.path) as file:
            for number, record in enumerate(recording.outline.records):
                for topic, message, start in recording.messages_in(file, record):
                    found._add(topic, message.data, number, start)
        return found

    def record_before(self, time_ns: int) -> int:
        """Number of the last record whose first cycle is not after a time; else of the first."""
        place = bisect_right(self.starts, (time_ns, len(self.starts) << 32))
        return self.starts[place - 1][1] if place else 0

    def _add(self, topic: str, data: bytes, record: int, start: int) -> None:
        if topic == schema.CYCLES and len(data) >= schema.CYCLE_HEAD.size:
            self._add_cycle(record, *HEAD.unpack_from(data))
        elif topic == schema.FIELDS and len(data) >= PUBLISHED.size:
            (time_ns,) = PUBLISHED.unpack_from(data)
            latest = max(time_ns, self.fields[-1].time_ns if self.fields else time_ns)
            self.fields.append(MessagePlace(latest, record, start))
        elif topic == schema.EVENTS:
            with suppress(InputError):
                event = _object(data)
                if isinstance(event.get("wall_ns"), int):
                    self.events.append(event)

    def _add_cycle(self, record: int, flags: int, number: int, wall_ns: int) -> None:
        wall_ns = max(wall_ns, self.last_ns)  # a clock may be set back
        if not self.cycles:
            self.first_ns = wall_ns
        elif number != self._number + 1 and not flags & schema.CycleFlag.RESTARTED:
            self.gaps.append((self.last_ns, wall_ns))
        if not self.starts or self.starts[-1][1] != record:
            self.starts.append((wall_ns, record))
        self.cycles, self.last_ns, self._number = self.cycles + 1, wall_ns, number


class NewestField:
    """The newest message of `FIELDS` up to any time, for one thread at a time.

    Parameters
    ----------
    recording : LiveRecording
    sound : function of byte in the file and the record there, optional
        Whether it can be used.
    """

    def __init__(
        self,
        recording: LiveRecording,
        sound: Callable[[int, schema.FieldRecord], bool] = lambda _, what: True,
    ) -> None:
        self._recording, self._sound = recording, sound
        self._places = recording.index.fields
        self._times = [each.time_ns for each in self._places]
        self._content: tuple[int, dict[int, bytes]] = (-1, {})  # the record that was read last
        self._newest: tuple[int, schema.FieldRecord | None] = (-1, None)

    def before(self, time_ns: int) -> schema.FieldRecord | None:
        """Up to a time, ns since the epoch; None without one, or where it cannot be read.

        Raises
        ------
        FileError
            If the file cannot be read any more.
        """
        place = bisect_right(self._times, time_ns) - 1
        if place < 0:
            return None
        if place != self._newest[0]:
            self._newest = place, self._at(self._places[place])
        return self._newest[1]

    def _at(self, place: MessagePlace) -> schema.FieldRecord | None:
        recording, record = self._recording, self._recording.outline.records[place.record]
        if place.record != self._content[0]:
            with records.open_file(recording.path) as file:
                there = recording.messages_in(file, record)
                self._content = place.record, {start: each.data for _, each, start in there}
        data = self._content[1].get(place.start, b"")
        found: schema.FieldRecord | None = recording.decoded(schema.FIELDS, record.start, data)
        return found if found is not None and self._sound(record.start, found) else None

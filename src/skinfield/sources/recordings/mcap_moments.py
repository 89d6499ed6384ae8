"""When things happened in a recording of a live skin: one pass, so that any time can be gone to."""

import json
from bisect import bisect_right
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from struct import Struct
from typing import Any, BinaryIO, NamedTuple, Self

import numpy as np

from skinfield.acquisition import Kind
from skinfield.acquisition.recorded import (
    BLOCKS,
    CYCLE_HEAD,
    CYCLES,
    EVENTS,
    POSITION,
    CycleFlag,
)
from skinfield.acquisition.recorded_fit import FIT_HEAD, FITS
from skinfield.errors import FileError
from skinfield.sources.recordings.mcap_bodies import (
    MESSAGE_HEAD,
    Damaged,
    Op,
    chunk_content,
    inner_records,
)
from skinfield.sources.recordings.mcap_live import LiveRecording
from skinfield.sources.recordings.mcap_records import Record, body_of, open_file

CYCLE = Struct("<4xIq32xqq")  # of a cycle's head: flags, number, wall_ns, log_position
TOLD = Struct("<8xq")  # of a fit's head: when it was published
KEY, RESTARTED = int(CycleFlag.KEY), int(CycleFlag.RESTARTED)
LASTING = int(Kind.CALIBRATION), int(max(Kind))  # kinds of blocks that hold until the next one


class FitPlace(NamedTuple):
    """Where an answer of a fit stands.

    Attributes
    ----------
    time_ns : int, ns
        When it was published, since the epoch.
    record, start, end : int
        Number of the record, and the answer's bytes in its content.
    """

    time_ns: int
    record: int
    start: int
    end: int


@dataclass
class Moments:
    """Times of a recording's cycles, ns since the epoch; made by `Moments.of`.

    Attributes
    ----------
    cycles : int
    first_ns, last_ns : int, ns
        Of the first and of the last cycle; 0 of a recording without any.
    keys : list of int, ns
        Of key cycles.
    breaks : list of int, ns
        Of cycles before which readings or cycles are missing, or an engine began: the first of the
        file is one.
    starts : list of pair of int
        Where reading can begin: time of the first cycle in a record, and the record's number.
    lasting : list of pair of int and bytes
        Number of a record, and the blocks of a message in it that has some that hold until the
        next of their kind comes.
    fits : list of FitPlace
        Answers of a fit beside the engine, by time.
    events : list of dict
        See `LiveRecording.events`.
    """

    cycles: int = 0
    first_ns: int = 0
    last_ns: int = 0
    keys: list[int] = field(default_factory=list)
    breaks: list[int] = field(default_factory=list)
    starts: list[tuple[int, int]] = field(default_factory=list)
    lasting: list[tuple[int, bytes]] = field(default_factory=list)
    fits: list[FitPlace] = field(default_factory=list)
    events: list[dict[str, Any]] = field(default_factory=list)

    @classmethod
    def of(cls, recording: LiveRecording) -> Self:
        """Look through a recording; what cannot be read is passed over.

        Raises
        ------
        FileError
            If the file cannot be read any more.
        """
        found = cls()
        scan = _Scan(recording, found)
        with open_file(recording.path) as file:
            for number, record in enumerate(recording.outline.records):
                try:
                    scan.record(file, number, record)
                except Damaged:  # told by whoever reads its messages
                    scan.broken = True
                except OSError as error:
                    why = error.strerror or error
                    raise FileError(
                        f"{recording.path} cannot be read at byte {record.start}: {why}"
                    ) from error
        return found

    def key_before(self, time_ns: int) -> int | None:
        """The newest key cycle up to a time, ns; None if there is none."""
        place = bisect_right(self.keys, time_ns)
        return self.keys[place - 1] if place else None

    def record_before(self, time_ns: int) -> int:
        """Number of the last record whose first cycle is not after a time; else of the first."""
        place = bisect_right(self.starts, (time_ns, len(self.starts) << 32))
        return self.starts[place - 1][1] if place else 0

    def lasting_before(self, record: int) -> bytes:
        """Blocks with all that was in force before a record, one after the other."""
        return b"".join(data for place, data in self.lasting if place < record)

    def holes(self, stale_ns: int) -> Iterator[tuple[int, int]]:
        """Spans (from, to), ns, in which no cycle can be answered again.

        Parameters
        ----------
        stale_ns : int, ns
            How long readings count: a replay begins at a key cycle before which nothing is
            missing for that long.
        """
        until = 0
        for each in self.breaks:
            place = bisect_right(self.keys, each + stale_ns)
            end = self.keys[place] if place < len(self.keys) else self.last_ns
            if end > max(until, each):
                yield max(until, each), end
            until = max(until, end)


class _Scan:
    """Fills `Moments`, record by record."""

    def __init__(self, recording: LiveRecording, found: Moments) -> None:
        from skinfield.acquisition.kernel import find_among

        self._find, self._found = find_among, found
        self._topics = {number: each.topic for number, each in recording.channels.items()}
        self._number, self._position = -1, -1
        self._newest = 0
        self.broken = True

    def record(self, file: BinaryIO, number: int, record: Record) -> None:
        """Take in a record; raises Damaged and OSError."""
        if record.opcode == Op.MESSAGE:
            body = body_of(file, record)
            self._message(number, body, 0, len(body))
        elif record.opcode == Op.CHUNK:
            content = chunk_content(body_of(file, record))
            for opcode, start, end in inner_records(content):
                if opcode == Op.MESSAGE:
                    self._message(number, content, start, end)

    def _message(self, record: int, content: bytes, start: int, end: int) -> None:
        if end - start < MESSAGE_HEAD.size:
            raise Damaged(f"a message of {end - start} bytes")
        topic = self._topics.get(int.from_bytes(content[start : start + 2], "little"))
        start += MESSAGE_HEAD.size
        if topic == CYCLES and end - start >= CYCLE_HEAD.size:
            self._cycle(record, *CYCLE.unpack_from(content, start))
        elif topic == BLOCKS and end - start >= POSITION.size:
            self._blocks(record, content[start:end])
        elif topic == EVENTS:
            self._event(content[start:end])
        elif topic == FITS and end - start >= FIT_HEAD.size:
            self._fit(record, start, end, *TOLD.unpack_from(content, start))

    def _fit(self, record: int, start: int, end: int, time_ns: int) -> None:
        fits = self._found.fits
        newest = fits[-1].time_ns if fits else time_ns
        fits.append(FitPlace(max(time_ns, newest), record, start, end))

    def _event(self, message: bytes) -> None:
        with suppress(ValueError, RecursionError):
            event = json.loads(message)
            if isinstance(event, dict) and isinstance(event.get("wall_ns"), int):
                self._found.events.append(event)

    def _cycle(self, record: int, flags: int, number: int, wall_ns: int, _: int) -> None:
        found = self._found
        wall_ns = self._newest = max(wall_ns, self._newest)  # a clock may be set back
        if not found.cycles:
            found.first_ns = wall_ns
        found.cycles, found.last_ns = found.cycles + 1, wall_ns
        if not found.starts or found.starts[-1][1] != record:
            found.starts.append((wall_ns, record))
        if self.broken or flags & RESTARTED or number != self._number + 1:
            found.breaks.append(wall_ns)
        self.broken, self._number = False, number
        if flags & KEY:
            found.keys.append(wall_ns)

    def _blocks(self, record: int, message: bytes) -> None:
        (position,) = POSITION.unpack_from(message)
        if self._position not in (-1, position):
            self.broken = True
        data = bytearray(message[POSITION.size :])
        self._position = position + len(data)
        words = np.frombuffer(data, "<i8", len(data) // 8)
        if self._find(words, 0, len(words), *LASTING) >= 0:
            self._found.lasting.append((record, bytes(data)))

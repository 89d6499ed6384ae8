"""Replay sources: recordings, on time."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from skinfield.errors import FileError, Floats, InputError, Ints, check_range
from skinfield.files.mcap.container import MAGIC
from skinfield.files.mcap.live import LiveRecording
from skinfield.files.recordings.matching import readings_for
from skinfield.files.recordings.open import open_recording
from skinfield.signal import Blocks, Count, Kind, Port, Stream, counters
from skinfield.signal.block import LONGEST, WORD, Words, block_bytes
from skinfield.skin import Patch, Skin
from skinfield.skin.reading import UNITS, Recording

ALL_AT_ONCE = float("inf")  # speed at which each poll brings the next reading
SLOWEST = 0.01
SPAN = 1 << 56  # ns, 2.3 years: what is divided by the least speed fits into 64 bits


def tape_of(counts: Floats, after_ns: Ints) -> Words:
    """Readings of a table as blocks of FLOATS, in words.

    Parameters
    ----------
    counts : (T, C) array
    after_ns : (T,) int64 array, ns
        Of each reading, since the first; not decreasing.
    """
    parts = []
    for first in range(0, counts.shape[1], LONGEST):
        columns = counts[:, first : first + LONGEST]
        count = columns.shape[1]
        part = np.zeros((len(counts), 2 + (count + 1) // 2), np.int64)
        part[:, 0] = after_ns
        part[:, 1] = first | count << 32 | int(Kind.FLOATS) << 48
        with np.errstate(over="ignore"):
            part[:, 2:].view(np.float32)[:, :count] = columns
        parts.append(part)
    return np.hstack(parts).ravel()


def begins_of(tape: Words) -> Ints:
    """First word of each block, and behind the last that is whole and of a kind that is known."""
    words, size_of, at = tape.data, cache(block_bytes), 0
    begins = [0]
    with suppress(InputError):
        while at + 2 <= len(words):
            head = words[at + 1]
            at += size_of(head >> 48 & 0xFF, head >> 32 & 0xFFFF) // WORD
            if at > len(words):
                break
            begins.append(at)
    return np.array(begins, np.int64)


class BlockReplayStream:
    """See `skinfield.signal.Stream`.

    Blocks of sources, losses and tares are left out: they were of another time. A round that nobody
    polled is not made up for.

    Parameters
    ----------
    ports : sequence of Port
        None: one port of the name "skin", of as many channels as there are.
    tape : (W,) int64 array
        Blocks.
    speed : float
        Times real time. Infinite: at each poll, what came until a channel came again.
    loop : bool
        Whether it begins anew behind the last.
    path : str
        Of the recording, for messages.
    pause_ns : int, ns
        From the last reading to the first of the next round.

    Attributes
    ----------
    index : int
        Of this source among all.
    ended : bool
        Whether the last block was delivered, for good.

    Raises
    ------
    FileError
        If there are no blocks, or of more channels than the ports have.
    """

    def __init__(
        self,
        ports: Sequence[Port],
        tape: Words,
        speed: float = 1.0,
        loop: bool = False,
        path: str = "table",
        pause_ns: int = 0,
    ) -> None:
        begins = begins_of(tape)
        stamps, heads = tape[begins[:-1]], tape[begins[:-1] + 1]
        wrong = np.append((stamps < 0) | (abs(stamps - stamps[:1]) > SPAN), True)
        whole = int(begins[np.argmax(wrong)])
        used = heads >> 48 & 0xFF <= Kind.STATUS
        stamps, heads, sizes = stamps[used], heads[used], np.diff(begins)[used]
        highest = int(np.max((heads & 0xFFFFFFFF) + (heads >> 32 & 0xFFFF), initial=0))
        if whole < len(tape) or not highest:
            raise FileError(
                f"{path}: byte {WORD * whole} of {WORD * len(tape)} of the readings is no block, "
                "expected blocks of readings: skinfield recover may help"
            )
        self._begins = np.append(0, np.cumsum(sizes))  # words
        shift = np.repeat(begins[:-1][used] - self._begins[:-1], sizes)
        self._tape = tape[shift + np.arange(len(shift))]
        self.ports = tuple(ports) or (Port("skin", highest),)
        channels = sum(port.channels for port in self.ports)
        if highest > channels:
            raise FileError(
                f"{path}: has readings of channel {highest - 1}, expected channels below "
                f"{channels}, of ports {', '.join(port.name for port in self.ports)}"
            )
        self.counters, self.index, self.up, self.ended = counters(), 0, True, False
        self._loop, self._step_by_step = loop, speed == ALL_AT_ONCE
        counted = heads >> 48 & 0xFF < Kind.STATUS
        self._counts = np.append(0, np.cumsum(counted))  # blocks of counts before each
        # a step ends where the channel with which all began comes once more
        starts = np.flatnonzero(counted & (heads & 0xFFFFFFFF == heads[0] & 0xFFFFFFFF))
        ends = stamps[starts] != np.append(stamps[0], stamps[starts[:-1]])
        self._steps = np.searchsorted(starts[ends], np.arange(len(heads)), "right")
        pace = 1.0 if self._step_by_step else speed
        self._times = ((stamps - stamps[0]) / pace).astype(np.int64)  # ns
        self._due = np.maximum.accumulate(self._times)  # in their order, whatever their stamps
        self._round = 0 if self._step_by_step else int(self._due[-1]) + round(pause_ns / pace)
        self._at, self._start, self._now = 0, 0, 0

    @property
    def fault(self) -> str:
        """Why it is not up: at the end of a recording that is not begun anew."""
        return "" if self.up else "the recording is over"

    def poll(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        """Append the blocks whose time has come."""
        if not self._start:
            self._start = now_ns
        elif now_ns < self._now:  # the clock was set back
            self._start -= self._now - now_ns
        self._now = now_ns
        taken = 0 if self.ended else self._taken_in(blocks, channel, now_ns)
        if self.ended and self.up and int(blocks.end[0]) + 3 <= len(blocks.words):
            blocks.put_number(now_ns, self.index, Kind.SOURCE, 0)
            self.up = False
        return taken

    def _taken_in(self, blocks: Blocks, channel: int, now_ns: int) -> int:
        """Append the blocks whose time has come, or those of a step, as far as there is room."""
        at, end = self._at, int(blocks.end[0])
        if self._step_by_step:
            last = np.searchsorted(self._steps, self._steps[at], "right")
        else:
            last = np.searchsorted(self._due, now_ns - self._start, "right")
        room = self._begins[at] + len(blocks.words) - end
        last = max(min(int(last), int(np.searchsorted(self._begins, room, "right")) - 1), at)
        first, size = int(self._begins[at]), int(self._begins[last] - self._begins[at])
        part, heads = blocks.words[end : end + size], self._begins[at:last] - first
        part[:] = self._tape[first : first + size]
        part[heads] = now_ns if self._step_by_step else self._start + self._times[at:last]
        part[heads + 1] += channel
        blocks.end[0] += size
        self._at = last
        self.counters[Count.RECEIVED] += last - at
        self.counters[Count.READINGS] += self._counts[last] - self._counts[at]
        self.counters[Count.BYTES] += WORD * size
        if last == len(self._due):
            self.ended, self._at = not self._loop, 0
            self._start += self._round
            if now_ns - self._start > self._round:
                self._start = now_ns
        return last - at

    def filenos(self) -> Sequence[int]:
        """None: it is a matter of time."""
        return ()

    def close(self) -> None:
        """Deliver nothing more."""
        self.up, self.ended = False, True


@dataclass(frozen=True, eq=False)
class ReplaySource:
    """A recording, with the time between its readings, at any speed.

    It is read as a whole when it is opened. Stamps are those of the replay: the first reading is
    stamped when it is delivered first.

    Parameters
    ----------
    recording : str, Path or Recording
        Path of whatever `open_recording` reads, or of an MCAP file of a live skin; or readings.
    speed : float
        Times real time; infinite delivers one reading at each poll.
    loop : bool
        Whether it begins anew behind the end; else the source goes down there.
    skin : Skin or Patch, optional
        To whose channels the columns belong: found by uid where the recording has uids. Without
        it, columns are channels of one port. Not for MCAP files, which hold channels.
    """

    recording: str | Path | Recording
    speed: float = 1.0
    loop: bool = False
    skin: Skin | Patch | None = None

    def __post_init__(self) -> None:
        if self.speed != ALL_AT_ONCE:
            check_range("speed", self.speed, SLOWEST, 1e9, "times real time, or infinite")

    def open(self) -> Stream:
        """Read the file; the first reading is there at the first poll.

        Raises
        ------
        FileError
            If it is no recording.
        InputError
            If its columns do not fit the skin.
        """
        recording, name = self.recording, "recording"
        if not isinstance(recording, Recording):
            path, name = Path(recording), str(recording)
            if _begins_as_mcap(path):
                ports, tape = recorded_blocks(path)
                return BlockReplayStream(ports, tape, self.speed, self.loop, name)
            recording = open_recording(path)
        if not recording.counts.size:
            raise FileError(f"{name} has no reading, expected one or more")
        if recording.unit not in UNITS:
            raise InputError(
                f"{name} holds {recording.unit!r}, expected readings of a skin in "
                f"{', '.join(UNITS)}: it is a force log, most likely"
            )
        after = np.maximum.accumulate(recording.stamp_ns) - recording.stamp_ns[0]
        pause = int(np.median(np.diff(after))) if len(after) > 1 else 10**7
        if self.speed == ALL_AT_ONCE:
            after = np.arange(len(after))  # each is a step of its own
        ports, counts = self._columns(recording)
        tape = tape_of(counts, after)
        return BlockReplayStream(ports, tape, self.speed, self.loop, name, pause)

    def _columns(self, recording: Recording) -> tuple[tuple[Port, ...], Floats]:
        """Ports, and counts of their channels."""
        unit = recording.unit
        if self.skin is None:
            return (Port("skin", recording.counts.shape[1], unit),), recording.counts
        patches = (self.skin,) if isinstance(self.skin, Patch) else tuple(self.skin)
        tables = [_on_channels(recording, patch) for patch in patches]
        return tuple(Port(each.name, each.n_channels, unit) for each in patches), np.hstack(tables)


def _on_channels(recording: Recording, patch: Patch) -> Floats:
    """Counts on the channels of a patch, NaN on those that no taxel has."""
    if recording.uid is None and recording.counts.shape[1] == patch.n_channels:
        return recording.counts
    table = np.full((len(recording), patch.n_channels), np.nan)
    table[:, patch.channel] = readings_for(recording, patch).counts
    return table


def _begins_as_mcap(path: Path) -> bool:
    with suppress(OSError, ValueError), path.open("rb") as file:  # whoever reads it next says why
        return file.read(len(MAGIC)) == MAGIC
    return False


def recorded_blocks(path: Path) -> tuple[tuple[Port, ...], Words]:
    """Ports of a live skin's recording, none if it does not say, and all its blocks."""
    recording = LiveRecording.open(path)
    data = b"".join(logged.data for logged in recording.blocks())
    if not data or len(data) % WORD:
        raise FileError(f"{path} has {len(data)} bytes of readings, expected whole blocks")
    ports: tuple[Port, ...] = ()
    with suppress(InputError, TypeError, ValueError):  # no configuration, or of another kind
        rows = recording.configuration.get("ports", [])
        ports = tuple(Port(str(name), channels, str(unit)) for name, channels, unit in rows)
    return ports, np.frombuffer(data, np.int64)

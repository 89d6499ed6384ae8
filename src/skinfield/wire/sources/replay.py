"""Replay sources: recordings and computed readings, on time."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skinfield.elastic import Layer
from skinfield.errors import (
    FileError,
    Floats,
    InputError,
    Ints,
    as_floats,
    check_positive,
    check_range,
)
from skinfield.signal import Blocks, Count, Kind, Port, Stream, counters
from skinfield.signal.block import LONGEST, WORD, Words
from skinfield.skin import Patch, Skin
from skinfield.skin.reading import UNITS, Recording
from skinfield.wire.sources.streams import narrowest

if TYPE_CHECKING:
    from skinfield.files.mcap.live import LiveRecording

ALL_AT_ONCE = float("inf")  # speed at which each poll brings the next reading

SLOWEST = 0.01
MCAP = b"\x89MCAP0\r\n"


def tape_of(counts: Floats, after_ns: Ints) -> Words:
    """Readings of a table as blocks, in words.

    Parameters
    ----------
    counts : (T, C) array
    after_ns : (T,) int64 array, ns
        Of each reading, since the first; not decreasing.
    """
    kind, table = narrowest(counts)
    parts = []
    for first in range(0, table.shape[1], LONGEST):
        columns = table[:, first : first + LONGEST]
        size = columns.shape[1] * table.itemsize
        part = np.zeros((len(table), 2 + -(-size // WORD)), np.int64)
        part[:, 0] = after_ns
        part[:, 1] = first | columns.shape[1] << 32 | int(kind) << 48
        part[:, 2:].view(np.uint8)[:, :size] = np.ascontiguousarray(columns).view(np.uint8)
        parts.append(part)
    return np.hstack(parts).ravel()


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
        from skinfield.wire.sources.kernels import survey

        self._tape: Words = np.zeros(len(tape), np.int64)
        table: Ints = np.zeros((1 + len(tape) // 2, 4), np.int64)
        bounds: Ints = np.zeros(3, np.int64)
        whole = survey(tape, self._tape, table, bounds)
        highest, rows, size = bounds.tolist()
        if whole < len(tape) or not highest:
            raise FileError(
                f"{path}: byte {8 * whole} of {8 * len(tape)} of the readings is no block, "
                "expected blocks of readings: skinfield recover may help"
            )
        self.ports = tuple(ports) or (Port("skin", highest),)
        channels = sum(port.channels for port in self.ports)
        if highest > channels:
            raise FileError(
                f"{path}: has readings of channel {highest - 1}, expected channels below "
                f"{channels}, of ports {', '.join(port.name for port in self.ports)}"
            )
        self.counters, self.index, self.up, self.ended = counters(), 0, True, False
        self._loop, self._step_by_step = loop, speed == ALL_AT_ONCE
        self._begins = np.append(table[:rows, 0], size)  # words
        self._counts = np.insert(table[:rows, 3], 0, 0)  # blocks of counts before each
        self._steps = table[:rows, 2].copy()
        pace = 1.0 if self._step_by_step else speed
        self._times = ((table[:rows, 1] - table[0, 1]) / pace).astype(np.int64)  # ns
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


def _table_stream(
    ports: Sequence[Port], counts: Floats, after_ns: Ints, speed: float, loop: bool, pause_ns: int
) -> BlockReplayStream:
    if speed == ALL_AT_ONCE:
        after_ns = np.arange(len(counts), dtype=np.int64)  # each is a step of its own
    return BlockReplayStream(ports, tape_of(counts, after_ns), speed, loop, "table", pause_ns)


@dataclass(frozen=True, eq=False)
class ReplaySource:
    """A recording, with the time between its readings, at any speed.

    It is read as a whole when it is opened. Stamps are those of the replay: the first reading is
    stamped when it is delivered first.

    Parameters
    ----------
    path : str or Path
        Whatever `open_recording` reads, or an MCAP file of a live skin.
    speed : float
        Times real time; infinite delivers one reading at each poll.
    loop : bool
        Whether it begins anew behind the end; else the source goes down there.
    skin : Skin or Patch, optional
        To whose channels the columns belong: found by uid where the recording has uids. Without
        it, columns are channels of one port. Not for MCAP files, which hold channels.
    """

    path: str | Path
    speed: float = 1.0
    loop: bool = False
    skin: Skin | Patch | None = None

    def __post_init__(self) -> None:
        if self.speed != ALL_AT_ONCE:
            check_range("speed", self.speed, SLOWEST, 1e9, "times real time, or infinite")

    def open(self) -> Stream:
        """Read the file.

        Raises
        ------
        FileError
            If it is no recording.
        InputError
            If its columns do not fit the skin.
        """
        path = Path(self.path)
        if _begins_as_mcap(path):
            ports, tape = recorded_blocks(path)
            return BlockReplayStream(ports, tape, self.speed, self.loop, str(path))
        from skinfield.files.recordings import open_recording

        ports, counts, stamps = self._columns(open_recording(path))
        after = np.maximum.accumulate(stamps) - stamps[0]
        step = int(np.median(np.diff(after))) if len(after) > 1 else 10**7
        return _table_stream(ports, counts, after, self.speed, self.loop, step)

    def _columns(
        self, recording: Recording
    ) -> tuple[tuple[Port, ...], NDArray[np.float64], NDArray[np.int64]]:
        """Ports, counts of their channels, and stamps."""
        if not len(recording):
            raise FileError(f"{self.path} has no reading, expected one or more")
        if recording.unit not in UNITS:
            raise InputError(
                f"{self.path} holds {recording.unit!r}, expected readings of a skin in "
                f"{', '.join(UNITS)}: it is a force log, most likely"
            )
        counts = as_floats("counts", recording.counts)
        stamps = recording.stamp_ns.astype(np.int64)
        if self.skin is None:
            return (Port("skin", counts.shape[1], recording.unit),), counts, stamps
        patches = (self.skin,) if isinstance(self.skin, Patch) else tuple(self.skin)
        tables = [_on_channels(recording, patch) for patch in patches]
        ports = tuple(Port(patch.name, patch.n_channels, recording.unit) for patch in patches)
        return ports, np.hstack(tables), stamps


def _on_channels(recording: Recording, patch: Patch) -> NDArray[np.float64]:
    """Counts on the channels of a patch, NaN on those that no taxel has."""
    from skinfield.files.recordings import readings_for

    if recording.uid is None and recording.counts.shape[1] == patch.n_channels:
        return recording.counts
    table = np.full((len(recording), patch.n_channels), np.nan)
    table[:, patch.channel] = readings_for(recording, patch).counts
    return table


def _begins_as_mcap(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            return file.read(len(MCAP)) == MCAP
    except (OSError, ValueError):
        return False  # whoever reads it next says why


def recorded_blocks(path: Path) -> tuple[tuple[Port, ...], Words]:
    """Ports of a live skin's recording, none if it does not say, and all its blocks."""
    from skinfield.files.mcap.live import LiveRecording

    recording = LiveRecording.open(path)
    data = b"".join(logged.data for logged in recording.blocks())
    if not data or len(data) % WORD:
        raise FileError(f"{path} has {len(data)} bytes of readings, expected whole blocks")
    return _ports_in(recording), np.frombuffer(data, np.int64)


def _ports_in(recording: "LiveRecording") -> tuple[Port, ...]:
    """Ports that the enclosed configuration names; none if there is none, or of another kind."""
    try:
        rows = recording.configuration.get("ports", [])
        return tuple(Port(str(name), channels, str(unit)) for name, channels, unit in rows)
    except (InputError, TypeError, ValueError):
        return ()


LADDER = 3  # forces that are solved; those between are interpolated
RADIUS = 6e-3  # m, of the ball that presses
REST, NOISE = 1000.0, 20.0  # counts


@dataclass(frozen=True, eq=False)
class SimulationSource:
    """Delivers the rows of a table at a steady rate.

    Parameters
    ----------
    counts : (T, C) array
        NaN where a taxel does not answer.
    rate : float, 1/s
    ports : sequence of Port
        Of C channels together; default one of the name "skin", in counts.
    loop : bool
        Whether it begins anew behind the last row.
    """

    counts: ArrayLike
    rate: float = 50.0
    ports: Sequence[Port] = ()
    loop: bool = True

    def __post_init__(self) -> None:
        check_positive("rate", self.rate, "readings per second")
        counts = as_floats("counts", self.counts)
        if counts.ndim != 2 or not counts.size:
            raise InputError(f"counts has shape {counts.shape}, expected (readings, channels)")
        ports = tuple(self.ports) or (Port("skin", counts.shape[1]),)
        channels = sum(port.channels for port in ports)
        if channels != counts.shape[1]:
            raise InputError(
                f"counts has {counts.shape[1]} columns, expected {channels}: the channels of "
                f"{', '.join(port.name for port in ports)}"
            )
        object.__setattr__(self, "counts", counts)
        object.__setattr__(self, "ports", ports)

    def open(self) -> BlockReplayStream:
        """Begin; the first reading is there at the first poll."""
        counts = np.asarray(self.counts, np.float64)
        step = round(1e9 / self.rate)
        after = np.arange(len(counts), dtype=np.int64) * step
        return _table_stream(self.ports, counts, after, 1.0, self.loop, step)


def pressed(
    skin: Skin | Patch,
    layer: Layer | None = None,
    *,
    force: float = 3.0,
    period: float = 4.0,
    rest: float = 6.0,
    rate: float = 50.0,
    seed: int = 0,
) -> SimulationSource:
    """A ball that presses into the middle of each patch in turn, again and again.

    Counts of 16 bits, which grow under pressure, of the gain that CySkin has, with white noise.

    Parameters
    ----------
    skin : Skin or Patch
    layer : Layer, optional
    force : float, N
        The greatest.
    period : float, s
        Of one press, from touch to lifting.
    rest : float, s
        Without touch, at first and between two patches.
    rate : float, 1/s
    seed : int
        Of the noise.

    Returns
    -------
    SimulationSource
        With a port for each patch; NaN on channels that no taxel has.
    """
    for name, value in (("period", period), ("rest", rest), ("rate", rate)):
        check_positive(name, value, "of the presses")
    patches = (skin,) if isinstance(skin, Patch) else tuple(skin)
    steps, idle = max(2, round(period * rate)), max(1, round(rest * rate))
    loads = np.zeros((len(patches), len(patches), idle + steps))  # of each patch, turn by turn
    turns = np.arange(len(patches))
    loads[turns, turns, idle:] = force * np.sin(np.pi * np.arange(steps) / steps) ** 2
    rng, forces = np.random.default_rng(seed), np.linspace(0.0, force, LADDER + 1)
    tables = [
        _counts(patch, loads[place].ravel(), forces, rungs, rng)
        for place, (patch, rungs) in enumerate(
            zip(patches, _ladder(layer or Layer(), force, patches), strict=True)
        )
    ]
    ports = tuple(Port(patch.name, patch.n_channels) for patch in patches)
    return SimulationSource(np.hstack(tables), rate, ports)


def _counts(
    patch: Patch, loads: Floats, forces: Floats, rungs: Floats, rng: np.random.Generator
) -> Floats:
    """Counts (T, C) of a patch under loads (T,), between the rungs of its ladder."""
    from skinfield.simulate.electronics import CySkinBoard

    table = np.full((len(loads), patch.n_channels), np.nan)
    for taxel, channel in enumerate(patch.channel):
        table[:, channel] = np.interp(loads, forces, rungs[:, taxel])
    noise = NOISE * rng.standard_normal(table.shape)
    return np.asarray(np.clip(np.rint(REST + CySkinBoard().gain * table + noise), 0.0, 65535.0))


def _ladder(layer: Layer, force: float, patches: Sequence[Patch]) -> list[Floats]:
    """Readings (LADDER + 1, L) of each patch for forces from 0 on, the ball in its middle."""
    from skinfield.simulate import Sphere, press_ladder

    presses = press_ladder(
        layer, Sphere(radius=RADIUS, force=force), np.linspace(0.0, force, LADDER + 1)[1:]
    )
    found = []
    for patch in patches:
        middle = patch.plane[np.argmin(np.sum((patch.plane - patch.plane.mean(0)) ** 2, axis=1))]
        at = patch.plane - middle
        rungs = [press.capacitance(at, patch.pad_diameter) for press in presses]
        found.append(np.array([np.zeros(len(patch)), *rungs]))
    return found

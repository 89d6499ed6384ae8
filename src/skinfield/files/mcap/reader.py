"""Counts over time of a live skin's recording (MCAP), from its blocks, as other formats have them.

A row is one scan: it ends where a channel comes that is in it already, and has the stamp of its
last block. A channel that did not come in a scan, or whose board says that nothing is connected, is
NaN there: earlier counts are never repeated. What else such a file holds, `LiveRecording` reads.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import FileError, Floats, InputError, Ints
from skinfield.files.mcap.live import LiveRecording
from skinfield.files.mcap.schema import BLOCKS
from skinfield.signal.block import WORD
from skinfield.skin import Patch
from skinfield.skin.reading import UNITS, Recording

Progress = Callable[[int, int], None]
PIECE = 1 << 19  # numbers of the rows that are handed on together: 4 MB
MOST_CHANNELS = 1 << 24  # of all ports together


class PortOf(NamedTuple):
    """A port as the recording's configuration states it, and its first channel among all."""

    name: str
    channels: int
    unit: str
    first: int


def ports_of(recording: LiveRecording) -> tuple[PortOf, ...]:
    """Ports of the sources that were recorded.

    Raises
    ------
    FileError
        If the configuration does not state them.
    """
    stated = recording.configuration.get("ports")
    ports: list[PortOf] = []
    first = 0
    try:
        for name, channels, unit in stated or ():
            ports.append(PortOf(str(name), int(channels), str(unit), first))
            first += ports[-1].channels
    except (TypeError, ValueError):
        ports = []
    good = all(port.channels > 0 and port.unit in UNITS for port in ports)
    if not ports or not good or first > MOST_CHANNELS:
        raise FileError(
            f"{recording.path}: the configuration states the ports {stated!r:.80}, expected "
            "[name, channels, unit] for each: it was recorded without its configuration"
        )
    return tuple(ports)


def port_of(patch: Patch, ports: tuple[PortOf, ...]) -> PortOf:
    """Port of a patch: that of its name, or the only one."""
    for port in ports:
        if port.name == patch.name or len(ports) == 1:
            return port
    names = ", ".join(port.name for port in ports)
    raise InputError(f"patch {patch.name!r} has no port, expected one of its name among {names}")


class Scan:
    """Rows of some channels.

    Parameters
    ----------
    channel : (K,) int array
        Among all ports; -1 for a column that never has a value.

    Attributes
    ----------
    words : int
        Dropped, as they begin no block.
    """

    def __init__(self, channel: Ints) -> None:
        self.words, count = 0, len(channel)
        there = np.flatnonzero((channel >= 0) & (channel < MOST_CHANNELS))
        self._column = np.full(int(channel[there].max(initial=-1)) + 1, -1, np.int64)
        self._column[channel[there]] = there
        self._row = np.full(count, np.nan)
        self._fresh, self._status = np.zeros(count, np.uint8), np.zeros(count, np.uint8)
        self._newest = np.zeros(1, np.int64)
        self._out = np.zeros((max(PIECE // count, 16), count))
        self._stamps = np.zeros(len(self._out), np.int64)
        self._used = 0

    def feed(self, data: bytes) -> Iterator[tuple[Ints, Floats]]:
        """Take in blocks; stamps (R,) and rows (R, K), copies, as often as enough are full."""
        from skinfield.files.mcap.kernel import scan

        words = np.frombuffer(data, "<i8", len(data) // WORD)
        views = (words, words.view(np.uint8), words.view(np.uint16), words.view(np.float32))
        at = 0
        while at < len(words):
            at, rows = scan(
                *views, at, self._column, self._row, self._fresh, self._status, self._newest,
                self._out[self._used :], self._stamps[self._used :],
            )  # fmt: skip
            self._used += rows
            if at < 0:
                self.words += len(words) + at + 1
                break
            if self._used == len(self._out):
                yield self._taken()

    def finish(self) -> Iterator[tuple[Ints, Floats]]:
        """The rest, with the scan that nothing ended."""
        from skinfield.files.mcap.kernel import put_row

        if self._used == len(self._out):
            yield self._taken()
        if self._fresh.any():
            put_row(self._row, self._fresh, self._status, self._out[self._used])
            self._stamps[self._used] = self._newest[0]
            self._used += 1
        if self._used:
            yield self._taken()

    def _taken(self) -> tuple[Ints, Floats]:
        used, self._used = self._used, 0
        return self._stamps[:used].copy(), self._out[:used].copy()


@dataclass
class LiveStream:
    """Counts of a live recording piece by piece, as other formats' `RecordingStream`.

    Attributes
    ----------
    channel : (C,) int array
        Of each column, among all ports; -1 for one without any.
    uid : (C,) uint64 array, optional
    unit : str
    notes : tuple of str
        Complete once `blocks` is exhausted.
    skipped : int
        Places of the file that could not be read, likewise.
    """

    recording: LiveRecording
    channel: Ints
    uid: NDArray[np.uint64] | None
    unit: str
    progress: Progress | None = None
    notes: tuple[str, ...] = ()
    skipped: int = 0

    def blocks(self) -> Iterator[Recording]:
        """Rows as recordings of some thousand readings each, once.

        Raises
        ------
        FileError
            If the file cannot be read any more, or holds no reading.
        """
        recording, path = self.recording, str(self.recording.path)
        rows = Scan(self.channel)
        empty = True
        for stamps, counts in self._pieces(rows):
            empty = False
            yield Recording(stamps, counts, self.uid, self.unit, path)
        if empty:
            raise FileError(f"{path} holds no reading of these channels")
        notes = [f"byte {each.byte}: {each.why}: left out" for each in recording.damage[:8]]
        if rows.words:
            notes.insert(0, f"{WORD * rows.words} bytes of readings are damaged: left out")
        if not recording.finished:
            notes.insert(0, "the recording was not finished: its end may be missing")
        self.notes, self.skipped = tuple(notes), len(recording.damage)

    def _pieces(self, rows: Scan) -> Iterator[tuple[Ints, Floats]]:
        for _, at, logged in self.recording.contents((BLOCKS,)):
            yield from rows.feed(logged.data)
            if self.progress is not None:
                self.progress(at, self.recording.outline.size)
        yield from rows.finish()


def live_stream(recording: LiveRecording, progress: Progress | None = None) -> LiveStream:
    """Counts of the port where there is only one, else of all taxels, by their identities.

    Raises
    ------
    FileError
        If the recording does not say where its channels belong.
    InputError
        If there are several ports, and taxels cannot be told apart.
    """
    ports = ports_of(recording)
    if len(ports) == 1:
        channel = np.arange(_width(recording, ports[0]))
        channel[ports[0].channels :] = -1
        return LiveStream(recording, channel, None, ports[0].unit, progress)
    patches = list(recording.skin)
    uid = np.concatenate([each.uid for each in patches])
    if len(np.unique(uid)) < len(uid) or len({port.unit for port in ports}) > 1:
        raise InputError(
            f"{recording.path} holds the patches {', '.join(each.name for each in patches)[:200]}, "
            "whose taxels have no identities of their own, expected one: export it by patch "
            "(skinfield export), or take LiveRecording"
        )
    channel = np.concatenate([each.channel + port_of(each, ports).first for each in patches])
    return LiveStream(recording, channel, uid, ports[0].unit, progress)


def _width(recording: LiveRecording, port: PortOf) -> int:
    """Columns that the layout says a port has; those of the port where it does not."""
    try:
        widths = {patch.n_channels for patch in recording.skin}
    except FileError as error:
        recording.note(0, str(error))
        return port.channels
    return widths.pop() if len(widths) == 1 else port.channels

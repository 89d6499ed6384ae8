"""Any recording as a source."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skinfield.acquisition import Port, Stream
from skinfield.acquisition.block import WORD, Words
from skinfield.errors import FileError, InputError, as_floats, check_range
from skinfield.layout import Patch, Skin
from skinfield.reading import UNITS, Recording
from skinfield.sources.live.table import ALL_AT_ONCE, TableStream
from skinfield.sources.live.tape import TapeStream

if TYPE_CHECKING:
    from skinfield.sources.recordings.mcap_live import LiveRecording

SLOWEST = 0.01
MCAP = b"\x89MCAP0\r\n"


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
    ports : sequence of Port
        Of an MCAP file's channels, in place of those that it names; one of all where it names none.
    """

    path: str | Path
    speed: float = 1.0
    loop: bool = False
    skin: Skin | Patch | None = None
    ports: Sequence[Port] = ()

    def __post_init__(self) -> None:
        if self.speed != ALL_AT_ONCE:
            check_range("speed", self.speed, SLOWEST, 1e9, "times real time, or infinite")
        object.__setattr__(self, "ports", tuple(self.ports))

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
            ports, tape = tape_of(path)
            return TapeStream(self.ports or ports, tape, self.speed, self.loop, str(path))
        from skinfield.sources.recordings import open_recording

        ports, counts, stamps = self._columns(open_recording(path))
        after = np.maximum.accumulate(stamps) - stamps[0]
        step = int(np.median(np.diff(after))) if len(after) > 1 else 10**7
        return TableStream(ports, counts, after, self.speed, self.loop, step)

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
    from skinfield.sources.recordings import readings_for

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


def tape_of(path: Path) -> tuple[tuple[Port, ...], Words]:
    """Ports of a live skin's recording, none if it does not say, and all its blocks.

    Raises
    ------
    FileError
        If it has no whole blocks.
    """
    from skinfield.sources.recordings.mcap_live import LiveRecording

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

"""How a running skin is recorded."""

from dataclasses import dataclass, field
from pathlib import Path

from skinfield.errors import check_count, check_range
from skinfield.sinks.mcap import FoxgloveViews, RecordingSettings, RosViews


@dataclass(frozen=True, kw_only=True)
class RecorderSettings:
    """Which skin, into which file, and how.

    Parameters
    ----------
    name : str
        Of the ring.
    path : Path
        Ends in .mcap by custom.
    file : RecordingSettings
    since_ns : int, ns
        Time since the epoch from which on a replay shall be possible: what came before it is
        recorded too as far as the ring still has it; 0: what comes from now on.
    flush : float, s
        After so long what was read is handed to the system, and survives a `kill -9`.
    sync : float, s
        After so long it is on the disk, and survives power loss.
    queue_bytes : int
        That may wait for the disk; what comes beyond is dropped and counted.
    views : tuple of classes
        Channels for other programs: `RosViews`, `FoxgloveViews`.
    view_rate : float, 1/s
        Of these.
    """

    name: str
    path: Path
    file: RecordingSettings = field(default_factory=RecordingSettings)
    since_ns: int = 0
    flush: float = 0.15
    sync: float = 1.5
    queue_bytes: int = 1 << 26
    views: tuple[type[RosViews] | type[FoxgloveViews], ...] = ()
    view_rate: float = 20.0

    def __post_init__(self) -> None:
        check_range("view_rate", self.view_rate, 1e-3, 1e3, "messages a second")
        check_range("flush", self.flush, 0.0, 60.0, "seconds until data is out of the process")
        check_range("sync", self.sync, 0.0, 3600.0, "seconds until data is on the disk")
        check_count("since_ns", self.since_ns, 0, 1 << 62, "nanoseconds since the epoch")
        check_count("queue_bytes", self.queue_bytes, 1 << 12, 1 << 36, "that wait for the disk")

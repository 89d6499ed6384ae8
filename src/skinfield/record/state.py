"""State of a recorder, in a file beside its ring."""

import json
import os
from dataclasses import asdict, dataclass

from skinfield.errors import FileError
from skinfield.ring.files import sidecar, write_sidecar


@dataclass
class RecorderState:
    """How a recording is going.

    Attributes
    ----------
    pid : int
    path : str
        Of the file.
    began_ns, told_ns : int, ns
        When it began, and when this was written; since the epoch.
    seconds : float, s
        It has been going on.
    bytes_written : int
        Of the file.
    bytes_read, cycles : int
        Of the ring's log, and of its slots.
    overrun_bytes, overrun_cycles : int
        Overwritten in the ring before they could be read.
    dropped_bytes, dropped_cycles : int
        That the disk was too slow for.
    given_up : int
        Messages that could not be written at the end.
    queue_bytes : int
        That wait for the disk.
    lag : float, s
        Age of the oldest reading that waits.
    since_flush, since_sync : float, s
    longest : float, s
        That one write or sync took.
    failing : bool
        Whether nothing can be written now.
    failure : str
        Why, or why it could not last time.
    finished : bool
        Whether the file has its end.
    ended : str
        Why the recording ended; empty while it goes on.
    """

    pid: int = 0
    path: str = ""
    began_ns: int = 0
    told_ns: int = 0
    seconds: float = 0.0
    bytes_written: int = 0
    bytes_read: int = 0
    cycles: int = 0
    overrun_bytes: int = 0
    overrun_cycles: int = 0
    dropped_bytes: int = 0
    dropped_cycles: int = 0
    given_up: int = 0
    queue_bytes: int = 0
    lag: float = 0.0
    since_flush: float = 0.0
    since_sync: float = 0.0
    longest: float = 0.0
    failing: bool = False
    failure: str = ""
    finished: bool = False
    ended: str = ""

    @property
    def lost(self) -> int:
        """Bytes of readings that are not in the file, for whatever reason."""
        return self.overrun_bytes + self.dropped_bytes

    def write(self, name: str) -> None:
        """Tell others, in one step; quietly not where the folder is full."""
        write_sidecar(name, "recorder", asdict(self))


def read_state(name: str) -> RecorderState | None:
    """What the recorder of the ring `name` last told; None if there is none.

    Of one that was killed, `ended` says so.

    Raises
    ------
    FileError
        If the file is something else.
    """
    path = sidecar(name, "recorder")
    try:
        state = RecorderState(**json.loads(path.read_text()))
    except FileNotFoundError:
        return None
    except (OSError, ValueError, TypeError) as error:
        raise FileError(f"{path} is no state of a recorder: {error}") from error
    if not state.ended and not _lives(state.pid):
        state.ended = f"its process {state.pid} is gone: skinfield recover mends the file"
    return state


def _lives(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):  # another user's
        return True
    return True


def forget_state(name: str) -> None:
    """Remove what this process told."""
    sidecar(name, "recorder").unlink(missing_ok=True)

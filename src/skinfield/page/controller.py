"""Controller of the page: what may be ordered from it; by itself, nothing."""

from collections import deque
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from skinfield.errors import InputError
from skinfield.page.source import DataSource, EngineView

if TYPE_CHECKING:
    from skinfield.page.presser import Presser
    from skinfield.page.recordings import Recordings

MOST_NOTICES = 20
NOT_HERE = "this page only looks on: order it where the skin runs"
TUNED = ("resolution", "deadline_us", "smoothing_ms", "threshold_N", "focus")


class Controller:
    """Orders from the page. This one refuses all: for engines elsewhere, and recordings.

    Methods may be called from any thread, one at a time.

    Parameters
    ----------
    shared : ReplaySource, optional
        A recording that all browsers look at, and play, together.

    Attributes
    ----------
    mode : str
        "live", "remote" or "replay".
    presser : Presser or None
        Of the virtual skin, where there is one.
    recordings : Recordings or None
        Where something can be recorded.
    """

    mode = "remote"
    presser: "Presser | None" = None
    recordings: "Recordings | None" = None

    def __init__(self, shared: Any = None) -> None:
        self.shared = shared
        if shared is not None:
            self.mode = "replay"
        self._notices: deque[tuple[str, str]] = deque(maxlen=MOST_NOTICES)

    def say(self, level: str, text: str) -> None:
        """Have all browsers shown a notice; `level` is "info", "warn" or "error"."""
        self._notices.append((level, text))

    def notices(self) -> list[tuple[str, str]]:
        """What was said since the last time, with its level."""
        return [self._notices.popleft() for _ in range(len(self._notices))]

    def views(self, sources: Sequence[DataSource]) -> list[EngineView]:
        """The newest cycle of each source."""
        lives = self.mode != "replay"
        return [EngineView(source.latest(), lives=lives) for source in sources]

    def hello(self) -> dict[str, Any]:
        """What the page must know of it: `press`, `record`, `recordings`."""
        presser, recordings = self.presser, self.recordings
        return {
            "press": None if presser is None else presser.offer(),
            "record": recordings is not None,
            "recordings": [] if recordings is None else recordings.names,
        }

    def controls(self) -> dict[str, Any]:
        """Values in force, what they may be, and why some cannot be changed."""
        off = dict.fromkeys((*TUNED, "solver", "tare", "record", "press"), NOT_HERE)
        return {"off": off, "busy": None}

    def truth(self) -> Sequence[Mapping[str, Any]]:
        """What really presses, where that is known."""
        return ()

    def set(self, what: str, value: Any) -> dict[str, Any]:
        """Change a setting of the engine."""
        raise InputError(f"{what} cannot be changed here: {NOT_HERE}")

    def tare(self) -> dict[str, Any]:
        """Take a new baseline."""
        raise InputError(f"no baseline can be taken here: {NOT_HERE}")

    @property
    def pressing(self) -> "Presser":
        """What presses the virtual skin, where there is one."""
        if self.presser is None:
            raise InputError("there is no virtual skin to be pressed here")
        return self.presser

    @property
    def recording(self) -> "Recordings":
        """What records and opens recordings, where that can be."""
        if self.recordings is None:
            raise InputError(f"nothing can be recorded here: {NOT_HERE}")
        return self.recordings

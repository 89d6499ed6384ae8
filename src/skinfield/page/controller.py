"""Controller of the page: what may be ordered from it; by itself, nothing."""

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from skinfield.errors import InputError
from skinfield.page.source import DataSource, EngineView, plain_view

KEPT = 20  # notices
NOT_HERE = "this page only looks on: order it where the skin runs"


class Press(NamedTuple):
    """Where and how a virtual skin is to be pressed.

    Attributes
    ----------
    id : str
    patch : str
    x, y : float, m
        In the patch's plane.
    force : float, N, or None
        None: as before.
    radius : float, m, or None
    shape : str
    """

    id: str
    patch: str
    x: float
    y: float
    force: float | None = None
    radius: float | None = None
    shape: str = "ball"


class Controller:
    """Orders from the page. This one refuses all: for engines elsewhere, and recordings.

    Methods may be called from any thread, one at a time.

    Attributes
    ----------
    mode : str
        "live", "remote" or "replay".
    shared : ReplaySource, optional
        A recording that all browsers look at, and play, together.
    """

    mode = "remote"

    def __init__(self) -> None:
        self._notices: deque[tuple[str, str]] = deque(maxlen=KEPT)

    def say(self, level: str, text: str) -> None:
        """Have all browsers shown a notice; `level` is "info", "warn" or "error"."""
        self._notices.append((level, text))

    def notices(self) -> list[tuple[str, str]]:
        """What was said since the last time, with its level."""
        found = []
        while self._notices:
            found.append(self._notices.popleft())
        return found

    shared: Any = None

    def views(self, sources: Sequence[DataSource]) -> list[EngineView]:
        """The newest cycle of each source, with the best contacts that are known of it."""
        return [plain_view(source.latest()) for source in sources]

    def hello(self) -> dict[str, Any]:
        """What the page must know of it: `press`, `record`, `recordings`."""
        return {"press": None, "record": False, "recordings": []}

    def controls(self) -> dict[str, Any]:
        """Values in force, what they may be, and why some cannot be changed."""
        names = ("resolution", "solver", "deadline_us", "smoothing_ms", "threshold_N", "focus")
        return {"off": dict.fromkeys((*names, "tare", "record", "press"), NOT_HERE), "busy": None}

    def truth(self) -> Sequence[Mapping[str, Any]]:
        """What really presses, where that is known."""
        return ()

    def set(self, what: str, value: Any) -> dict[str, Any]:
        """Change a setting of the engine."""
        raise InputError(f"{what} cannot be changed here: {NOT_HERE}")

    def tare(self) -> dict[str, Any]:
        """Take a new baseline."""
        raise InputError(f"no baseline can be taken here: {NOT_HERE}")

    def come(self) -> None:
        """Get ready what a browser that has come may order soon."""

    def record(self, on: bool) -> dict[str, Any]:
        """Begin or end a recording."""
        raise InputError(f"nothing can be recorded here: {NOT_HERE}")

    def press(self, press: Press) -> dict[str, Any]:
        """Press the virtual skin, or move a press."""
        raise InputError("there is no virtual skin to be pressed here")

    def lift(self, id: str | None) -> dict[str, Any]:
        """Lift off one press, or all."""
        raise InputError("there is no virtual skin to be pressed here")

    def leave(self, browser: str) -> None:
        """Lift off what a browser pressed that has gone: ids of its presses begin so."""

    def scene(self, name: str) -> dict[str, Any]:
        """Play another scene on the virtual skin."""
        raise InputError("there is no virtual skin to be pressed here")

    def recording(self, name: str) -> DataSource:
        """Open one of the recordings that `hello` names, for one browser."""
        raise InputError(f"there is no recording named {name!r} here")

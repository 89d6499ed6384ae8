"""What really pressed, and when."""

import json
from collections import deque
from collections.abc import Iterable
from pathlib import Path
from typing import IO, Any

from skinfield.errors import FileError
from skinfield.layout import Skin
from skinfield.virtual.touch import Touch

KEPT = 100_000  # lines in memory
INTERVAL_NS = 10_000_000  # between lines while a press only moves
Line = dict[str, Any]


class Truth:
    """Lines about the presses: one at each change of what presses, and every 10 ms on the way.

    A line holds from its stamp to that of the next one.

    Parameters
    ----------
    skin : Skin
    path : str, optional
        File to write the lines to as JSON, one object each.

    Raises
    ------
    FileError
        If the file cannot be written.
    """

    def __init__(self, skin: Skin, path: str = "") -> None:
        self._skin = skin
        self._lines: deque[Line] = deque(maxlen=KEPT)
        self._made = 0
        self._who: tuple[str, ...] | None = None
        self._last_ns = 0
        self._waiting: tuple[list[tuple[Touch, float]], int] | None = None
        self._file: IO[str] | None = None
        if path:
            try:
                self._file = Path(path).open("w", encoding="utf-8", buffering=1)  # noqa: SIM115
            except OSError as error:
                raise FileError(f"{path} cannot be written: {error.strerror}") from error

    def note(self, touches: Iterable[tuple[Touch, float]], stamp_ns: int) -> None:
        """Take down what presses from now on, with the radius of each touch, m."""
        touches = list(touches)
        who = tuple(touch.id for touch, _ in touches)
        self._waiting = None
        if who == self._who and stamp_ns - self._last_ns < INTERVAL_NS:
            self._waiting = (touches, stamp_ns)
            return
        self._write(touches, stamp_ns)

    def settle(self, stamp_ns: int) -> None:
        """Take down the end of a movement that was too soon after the line before."""
        if self._waiting is not None and stamp_ns - self._last_ns >= INTERVAL_NS:
            self._write(*self._waiting)
            self._waiting = None

    def _write(self, touches: list[tuple[Touch, float]], stamp_ns: int) -> None:
        self._who, self._last_ns = tuple(touch.id for touch, _ in touches), stamp_ns
        presses = [self._press(touch, radius) for touch, radius in touches]
        line = {"number": self._made, "stamp_ns": stamp_ns, "presses": presses}
        self._made += 1
        self._lines.append(line)
        if self._file is not None:
            self._file.write(json.dumps(line) + "\n")

    def _press(self, touch: Touch, radius: float) -> Line:
        patch = self._skin.patches[touch.patch]
        position = patch.surface.position_from_plane(_row(touch.x, touch.y))[0]
        return {
            "id": touch.id,
            "patch": patch.name,
            "x": touch.x,
            "y": touch.y,
            "position": [float(each) for each in position],
            "force": touch.force,
            "radius": touch.tool.radius,
            "shape": touch.tool.shape,
            "contact_radius": radius,
        }

    def after(self, number: int, most: int) -> list[Line]:
        """Lines from `number` on, at most so many, as far as they are kept."""
        first = self._made - len(self._lines)
        start = max(number - first, 0)
        return [self._lines[i] for i in range(start, min(start + most, len(self._lines)))]

    @property
    def made(self) -> int:
        """Lines so far."""
        return self._made

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
            self._file = None


def _row(x: float, y: float) -> Any:
    import numpy as np

    return np.array([[x, y]])

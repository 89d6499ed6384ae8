"""Truth log of a virtual skin: what really pressed, line by line, in memory that does not grow."""

import json
from pathlib import Path
from typing import IO, Any

import numpy as np

from skinfield.emulator.scenes import CurrentPress, SceneTool
from skinfield.errors import FileError
from skinfield.skin import Skin

LINES = 10_000  # in memory: 100 s of a press that moves all the time
PRESSES = 4 * LINES  # of all of them
INTERVAL_NS = 10_000_000  # between lines while a press only moves
Line = dict[str, Any]
Whose = tuple[str, int, SceneTool]


class LineStore:
    """The newest lines, in room that is taken once.

    Attributes
    ----------
    made : int
        Lines so far.
    first : int
        Number of the oldest that is still there.
    last_ns : int, ns
        Stamp of the newest; 0 before the first.
    last_ids : list of str
        Of its presses.
    """

    def __init__(self) -> None:
        self.made = self.first = self.last_ns = 0
        self.last_ids: list[str] = []
        self._presses = 0  # so far
        # ones: what is zero takes its memory only once it is written
        self._stamps, self._begins = np.ones((2, LINES), np.int64)
        self._numbers = np.ones((PRESSES, 6))  # x, y, force, contact_radius, shear
        self._whose: list[Whose | None] = [None] * PRESSES

    def append(self, stamp_ns: int, touches: list[CurrentPress]) -> None:
        """Keep a line; the oldest ones make room."""
        row = self.made % LINES
        self._stamps[row], self._begins[row] = stamp_ns, self._presses
        for touch in touches:
            place, whose = self._presses % PRESSES, (touch.id, touch.patch, touch.tool)
            before = self._whose[place - len(touches)]  # as a rule its own in the line before
            self._whose[place] = before if before == whose else whose
            numbers = touch.x, touch.y, touch.force, touch.contact_radius, *touch.shear
            self._numbers[place] = numbers
            self._presses += 1
        self.made += 1
        self.last_ns, self.last_ids = stamp_ns, [touch.id for touch in touches]
        self.first = max(self.first, self.made - LINES)
        while self._begins[self.first % LINES] < self._presses - PRESSES:
            self.first += 1

    def __getitem__(self, number: int) -> tuple[int, list[CurrentPress]]:
        """Stamp and presses of a line that is there."""
        row, end = number % LINES, self._presses
        if number + 1 < self.made:
            end = int(self._begins[(number + 1) % LINES])
        touches = []
        for each in range(int(self._begins[row]), end):
            whose = self._whose[each % PRESSES]
            assert whose is not None  # it was written
            x, y, force, radius, along, across = self._numbers[each % PRESSES].tolist()
            touches.append(CurrentPress(*whose, x, y, force, radius, (along, across)))
        return int(self._stamps[row]), touches


class TruthLog:
    """Lines about the presses: one at each change of what presses, and every 10 ms on the way.

    A line holds from its stamp to that of the next one. The newest are in memory; all are in the
    file.

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
        self._skin, self._lines = skin, LineStore()
        self._waiting: tuple[int, list[CurrentPress]] | None = None
        self._file: IO[str] | None = None
        if path:
            try:
                self._file = Path(path).open("w", encoding="utf-8", buffering=1)  # noqa: SIM115
            except OSError as error:
                raise FileError(f"{path} cannot be written: {error.strerror}") from error

    @property
    def made(self) -> int:
        """Lines so far."""
        return self._lines.made

    def note(self, touches: list[CurrentPress] | None, stamp_ns: int) -> None:
        """Take down what presses from now on; None: as before.

        The end of a movement that is too soon after the line before is taken down later.
        """
        if touches is not None:
            self._waiting = stamp_ns, touches
        if self._waiting is None:
            return
        lines = self._lines
        moves = lines.made and [touch.id for touch in self._waiting[1]] == lines.last_ids
        if moves and stamp_ns - lines.last_ns < INTERVAL_NS:
            return
        if self._file is not None:
            self._file.write(json.dumps(self._line(lines.made, *self._waiting)) + "\n")
        lines.append(*self._waiting)
        self._waiting = None

    def _line(self, number: int, stamp_ns: int, touches: list[CurrentPress]) -> Line:
        presses = [self._press(touch) for touch in touches]
        return {"number": number, "stamp_ns": stamp_ns, "presses": presses}

    def _press(self, touch: CurrentPress) -> Line:
        patch = self._skin.patches[touch.patch]
        position = patch.surface.position_from_plane(np.array([[touch.x, touch.y]]))[0]
        return {
            "id": touch.id,
            "patch": patch.name,
            "x": touch.x,
            "y": touch.y,
            "position": position.tolist(),
            "force": touch.force,
            "radius": touch.tool.radius,
            "shape": touch.tool.shape,
            "contact_radius": touch.contact_radius,
            "shear": list(touch.shear),
        }

    def after(self, number: int, most: int) -> list[Line]:
        """Lines from `number` on, at most so many, as far as they are in memory."""
        begin = max(number, self._lines.first)
        numbers = range(begin, min(begin + most, self.made))
        return [self._line(each, *self._lines[each]) for each in numbers]

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
            self._file = None

"""Tables of presses, solved beside the stream: in another process, so that no reading is late."""

import subprocess
import sys
from dataclasses import dataclass, field

from skinfield.errors import InputError
from skinfield.mechanics import Layer
from skinfield.virtual.tables import PressTable, is_stored, table_for
from skinfield.virtual.tool import Tool

Key = tuple[Tool, float]
AT_ONCE = 2  # tables that are solved at a time: each takes a processor for seconds
QUEUED = 16  # that wait for their turn
SCRIPT = """
import sys
from skinfield.mechanics import Layer
from skinfield.virtual.tables import table_for
from skinfield.virtual.tool import Tool
radius, shape, pad, *layer = sys.argv[1:]
table_for(Tool(float(radius), shape), Layer(*map(float, layer)), float(pad))
"""


@dataclass
class Solving:
    """Tables that are there, and those that are on their way.

    Parameters
    ----------
    layer : Layer
    """

    layer: Layer
    _there: dict[Key, PressTable] = field(default_factory=dict)
    _running: dict[Key, subprocess.Popen[bytes]] = field(default_factory=dict)
    _queue: list[Key] = field(default_factory=list)

    def get(self, tool: Tool, pad_diameter: float) -> PressTable | None:
        """A table, if it is there."""
        return self._there.get((tool, pad_diameter))

    def now(self, tool: Tool, pad_diameter: float) -> PressTable:
        """A table, solved here if it must be."""
        key = (tool, pad_diameter)
        if key not in self._there:
            self._there[key] = table_for(tool, self.layer, pad_diameter)
        return self._there[key]

    def start(self, tool: Tool, pad_diameter: float) -> None:
        """Have a table solved, at once or in its turn; one that was solved before is there.

        Raises
        ------
        InputError
            If too many wait.
        """
        key = (tool, pad_diameter)
        if key in self._running:
            return
        if is_stored(tool, self.layer, pad_diameter):
            self.now(tool, pad_diameter)
            return
        if key in self._queue:
            self._queue.remove(key)  # it is wanted now: before others
        if len(self._queue) >= QUEUED:
            raise InputError(
                f"tool is a {tool.shape} of {tool.radius * 1e3:g} mm while {QUEUED} others wait to "
                "be prepared, expected it some seconds later"
            )
        self._queue.append(key)
        self._begin()

    def _begin(self) -> None:
        """Begin the newest that wait: what was asked for last is looked at now."""
        while self._queue and len(self._running) < AT_ONCE:
            self._solve(self._queue.pop())

    def _solve(self, key: Key) -> None:
        (tool, pad_diameter), layer = key, self.layer
        numbers = (layer.thickness, layer.young_modulus, layer.poisson_ratio)
        words = [str(tool.radius), tool.shape, str(pad_diameter), *map(str, numbers)]
        words.append(str(layer.relative_permittivity))
        self._running[key] = subprocess.Popen(
            [sys.executable, "-c", SCRIPT, *words],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip

    def poll(self) -> bool:
        """Take in what is solved; whether there was some.

        Where nothing could be stored, it is solved here after all.
        """
        before = len(self._there)
        for key, process in list(self._running.items()):
            if process.poll() is not None:
                del self._running[key]
                self.now(*key)
        self._begin()
        return len(self._there) > before

    def close(self) -> None:
        """End what runs."""
        for process in self._running.values():
            process.kill()
            process.wait()
        self._running.clear()
        self._queue.clear()

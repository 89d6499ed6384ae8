"""World of a virtual skin: tables of presses, and what taxels read of them."""

import hashlib
import itertools
import math
import os
import subprocess
import sys
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.elastic import Layer
from skinfield.emulator.electronics import starts_of
from skinfield.emulator.scenes import BodyPath, CurrentPress, Scene, SceneTool, patch_index
from skinfield.emulator.transports import Request
from skinfield.errors import Floats, InputError
from skinfield.skin import Skin

if TYPE_CHECKING:
    from skinfield.simulate import Press

DEEPEST = 0.75  # of the thickness: where tables end
SOFTEST = 1.0 / 400.0  # of the largest force: the least that is solved; below it, in proportion
SHARES = (*np.geomspace(SOFTEST, 0.3, 6), *np.linspace(0.475, 1.0, 4))  # of it, that are solved
HARDEST = 30.0  # N: where tables of soft bodies end at the latest
ROUNDS = 3  # until their highest force is known
CELL = 0.5e-3  # m
LINE = 0.25e-3  # m between the distances that are solved
SPACING = 0.05e-3  # m between the distances of a table
FORCES = 128  # rows of a table
ROWS = np.arange(FORCES)
REACH = 12.0  # thicknesses beyond the touch where readings are below 1e-3 of the highest
Key = tuple[SceneTool, float]
AT_ONCE = 2  # tables that are solved at a time: each takes a processor for seconds
SCRIPT = """
from skinfield.elastic import Layer
from skinfield.emulator.scenes import SceneTool
from skinfield.emulator.world import table_for
table_for({tool!r}, Layer(*{layer!r}), {pad_diameter!r})
"""


@dataclass(frozen=True, eq=False)
class PressTable:
    """Readings of one tool on one layer.

    Attributes
    ----------
    highest_force : float, N
    contact_radius : (FORCES,) array, m
    change : (FORCES, D) array
        ΔC/C₀ at distances 0, SPACING, 2 SPACING, ... from the press. Row i is of the force
        (i / (FORCES - 1))² · highest_force: close to each other where readings rise steeply.
    """

    highest_force: float
    contact_radius: Floats
    change: Floats

    def check_force(self, force: float, tool: SceneTool) -> None:
        """Raise InputError for a force that pushes the tool through the layer."""
        highest = self.highest_force / max(part for _, part in tool.parts)
        if not 0.0 < force <= highest:
            raise InputError(
                f"force is {force:g} N, expected above 0 and at most {highest:.3g} N "
                f"for a {tool.shape} of {tool.radius * 1e3:g} mm radius, which then sinks through "
                f"{DEEPEST:.0%} of the layer: press lighter, or with a larger radius"
            )

    def _row(self, force: float) -> float:
        """Row of a force, between two of them as a rule."""
        return math.sqrt(min(force / self.highest_force, 1.0)) * (FORCES - 1)

    def readings(self, distance: Floats, force: float) -> Floats:
        """ΔC/C₀ at distances, m, from a press; linear between the entries."""
        row = self._row(force)
        lower = min(int(row), FORCES - 2)
        values = (lower + 1 - row) * self.change[lower] + (row - lower) * self.change[lower + 1]
        places = SPACING * np.arange(len(values))
        return np.asarray(np.interp(distance, places, values, right=0.0))

    def radius_at(self, force: float) -> float:
        """Radius of the touch, m."""
        return float(np.interp(self._row(force), ROWS, self.contact_radius))


def solve_table(tool: SceneTool, layer: Layer, pad_diameter: float) -> PressTable:
    """Solve the presses of a table: a second or two.

    Parameters
    ----------
    tool : SceneTool
    layer : Layer
    pad_diameter : float, m
    """
    from skinfield.simulate import press, press_ladder

    if tool.is_soft:
        return _soft_table(tool, layer, pad_diameter)
    bound = tool.radius if tool.shape == "flat" else math.sqrt(2.0 * tool.radius * layer.thickness)
    extent = 2.0 * math.ceil((min(bound, tool.radius) + 5.0 * layer.thickness) / CELL) * CELL
    deepest = press(layer, [tool.body(depth=DEEPEST * layer.thickness)], extent, CELL)
    highest = deepest.force
    forces = highest * np.array(SHARES)
    solved = [*press_ladder(layer, tool.body(), forces[:-1], extent, CELL), deepest]
    return _tabulated(solved, min(bound, tool.radius), pad_diameter)


def _soft_table(tool: SceneTool, layer: Layer, pad_diameter: float) -> PressTable:
    """Of a soft body, up to the force that sinks as deep; that goes by a power of it."""
    from skinfield.simulate import press, press_ladder

    widest = tool.body(force=HARDEST).reach
    extent = 2.0 * math.ceil((widest + 5.0 * layer.thickness) / CELL) * CELL
    target, force = DEEPEST * layer.thickness, SOFTEST * HARDEST
    for _ in range(ROUNDS):
        depth = float(press(layer, [tool.body(force=force)], extent, CELL).approach[0])
        power = 1.0 - 2.0 * tool.body(force=force).growth
        force = min(force * (target / depth) ** (1.0 / power), HARDEST)
    forces = force * np.array(SHARES)
    return _tabulated(press_ladder(layer, tool.body(), forces, extent, CELL), widest, pad_diameter)


def _tabulated(solved: "Sequence[Press]", widest: float, pad_diameter: float) -> PressTable:
    """Table of presses from a small part of the highest force to all of it."""
    from scipy.interpolate import CubicSpline, PchipInterpolator

    forces, highest = np.array([each.force for each in solved]), solved[-1].force
    reach = widest + pad_diameter + REACH * solved[0].layer.thickness
    distance = np.arange(0.0, reach + LINE, LINE)
    line = np.column_stack([distance, np.zeros_like(distance)])
    read = np.array([each.readings(line, pad_diameter, "capacitance") for each in solved])
    radius = np.array([math.sqrt(each.contact_area / math.pi) for each in solved])
    fine = np.arange(0.0, reach, SPACING)
    rows = (ROWS / (FORCES - 1)) ** 2 * highest
    # What is read per newton hardly changes with the force: that is what is interpolated.
    slope = CubicSpline(np.log(forces), read / forces[:, None])
    known = np.maximum(rows, forces[0])
    values = CubicSpline(distance, slope(np.log(known)) * rows[:, None], axis=1)(fine)
    touch = PchipInterpolator(np.concatenate([[0.0], forces]), np.concatenate([[0.0], radius]))
    return PressTable(float(highest), np.asarray(touch(rows)), np.ascontiguousarray(values))


def table_for(tool: SceneTool, layer: Layer, pad_diameter: float) -> PressTable:
    """As `solve_table`, from the user's cache where it was solved before by the very same code."""
    path = cache_path(tool, layer, pad_diameter)
    try:
        with np.load(path) as file:
            return PressTable(float(file["force"]), file["radius"], file["change"])
    except (OSError, ValueError, KeyError, EOFError):  # not there, or cut
        table = solve_table(tool, layer, pad_diameter)
    partial = path.with_name(f"{path.stem}-{os.getpid()}.part.npz")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez(
            partial, force=table.highest_force, radius=table.contact_radius, change=table.change
        )
        partial.replace(path)
    except OSError:  # a folder that cannot be written only means to solve again next time
        partial.unlink(missing_ok=True)
    return table


def cache_path(tool: SceneTool, layer: Layer, pad_diameter: float) -> Path:
    """Where a table is kept: its name depends on what is pressed and on the code that solves it."""
    root = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    asked = f"{tool!r} {astuple(layer)!r} {pad_diameter!r} {_code()}"
    name = hashlib.sha256(asked.encode()).hexdigest()[:24]
    return Path(root) / "skinfield" / f"press-{name}.npz"


@cache
def _code() -> str:
    """Digest of the sources that a table comes from, so that no change of them is missed."""
    root, digest = Path(__file__).parent.parent, hashlib.sha256()
    for room in ("simulate", "elastic"):
        for file in sorted((root / room).rglob("*.py")):
            digest.update(file.read_bytes())
    digest.update(Path(__file__).read_bytes())
    return digest.hexdigest()


class PressTables:
    """Tables that are there, and those that are on their way, of presses on one layer."""

    def __init__(self, layer: Layer) -> None:
        self._layer = layer
        self._there: dict[Key, PressTable] = {}
        self._running: dict[Key, subprocess.Popen[bytes]] = {}

    def get(self, key: Key) -> PressTable | None:
        """A table, if it is there or was solved before."""
        if key not in self._there and cache_path(key[0], self._layer, key[1]).is_file():
            return self.now(key)
        return self._there.get(key)

    def now(self, key: Key) -> PressTable:
        """A table, solved here if it must be."""
        if key not in self._there:
            self._there[key] = table_for(key[0], self._layer, key[1])
        return self._there[key]

    def poll(self, wanted: Sequence[Key]) -> bool:
        """Take in what is solved, and have others solved, the last first; whether there was some.

        Where nothing could be stored, it is solved here after all.
        """
        ended = [key for key, process in self._running.items() if process.poll() is not None]
        for key in ended:
            del self._running[key]
            self.now(key)
        for key in reversed(wanted):
            if len(self._running) < AT_ONCE and key not in self._there | self._running:
                self._solve(key)
        return bool(ended)

    def _solve(self, key: Key) -> None:
        script = SCRIPT.format(tool=key[0], layer=astuple(self._layer), pad_diameter=key[1])
        quiet = subprocess.DEVNULL
        self._running[key] = subprocess.Popen(
            [sys.executable, "-c", script], stdin=quiet, stdout=quiet, stderr=quiet
        )

    def close(self) -> None:
        """End what runs."""
        for process in self._running.values():
            process.kill()
            process.wait()
        self._running.clear()


MOST = 64  # presses at once, by hand
KEPT = 20  # notes
LONGEST_ID = 64  # characters


class World:
    """A scene, presses by hand, and the tables that tell what taxels read of them.

    Readings of several presses are added up: right where they are apart, by a few thicknesses of
    the layer, and not where they share skin.

    Parameters
    ----------
    skin : Skin
    layer : Layer
    scene : Scene
        Its tables are solved here and now.
    plane : (L, 2) array, m, optional
        Where the taxels of all patches truly are; default as stated.
    """

    def __init__(self, skin: Skin, layer: Layer, scene: Scene, plane: Floats | None = None) -> None:
        self.skin, self.layer = skin, layer
        self._starts = starts_of(skin)
        stated = np.concatenate([patch.plane for patch in skin]) if plane is None else plane
        self._plane = np.ascontiguousarray(stated)
        self._solving = PressTables(layer)
        self._by_hand: dict[str, CurrentPress] = {}
        self._numbers = itertools.count(1)
        self._published: list[CurrentPress] | None = None
        self.notes: list[str] = []
        self.play(scene)
        self._solving.now(self._key(0, SceneTool()))

    def play(self, scene: Scene) -> None:
        """Play another scene from now on.

        Raises
        ------
        InputError
            If it presses a body through the layer; the old one goes on then.
        """
        for (patch, tool), force in scene.tools.items():
            self._solving.now(self._key(patch, tool)).check_force(force, tool)
        tracks = sorted(scene.tracks, key=lambda track: track.points[0].time)
        self._tracks = [(f"{scene.name}-{i}", track) for i, track in enumerate(tracks)]
        self._begins = [track.points[0].time for track in tracks]
        self._longest = max((t.points[-1].time - t.points[0].time for t in tracks), default=0.0)
        self.scene = scene

    def _key(self, patch: int, tool: SceneTool) -> Key:
        return tool, self.skin.patches[patch].pad_diameter

    def _table(self, touch: CurrentPress) -> PressTable | None:
        return self._solving.get(self._key(touch.patch, touch.tool))

    def touches(self, time: float) -> list[CurrentPress]:
        """Presses at a time, s, of the scene."""
        found: list[CurrentPress] = []
        if time >= 0.0:
            time = time % self.scene.period if math.isfinite(self.scene.period) else time
            for name, track in self._playing(time):
                at = track.at(time)
                if at is not None:
                    found.append(CurrentPress(name, track.patch, track.tool, *at))
        for touch in self._by_hand.values():
            if self._table(touch) is not None:
                found.append(touch)
        return found

    def _playing(self, time: float) -> list[tuple[str, BodyPath]]:
        last = bisect_right(self._begins, time)
        first = bisect_right(self._begins, time - self._longest - 1e-9)
        return self._tracks[first:last]

    def update(self, time: float, change: Floats) -> list[CurrentPress] | None:
        """Write what the taxels read at a time of the scene into `change`, (C,) from the first.

        The presses; None where nothing has changed since the last call.
        """
        touches = self.touches(time)
        if touches == self._published:
            return None
        self._published = touches
        change[:] = 0.0
        found = []
        for touch in touches:
            table = self._solving.now(self._key(touch.patch, touch.tool))
            rows = slice(self._starts[touch.patch], self._starts[touch.patch + 1])
            away = self._plane[rows] - (touch.x, touch.y)
            for along, part in touch.tool.parts:
                distance = np.hypot(away[:, 0] - along, away[:, 1])
                change[rows] += table.readings(distance, part * touch.force)
            found.append(replace(touch, contact_radius=table.radius_at(touch.force)))
        return found

    def poll(self) -> None:
        """Take in tables that are solved by now; a press that is too hard for its own is let go."""
        if not self._solve():
            return
        for touch in list(self._by_hand.values()):
            table = self._table(touch)
            try:
                if table is not None:
                    table.check_force(touch.force, touch.tool)
            except InputError as error:
                del self._by_hand[touch.id]
                self.notes.append(f"press {touch.id} was let go: {error}")
                del self.notes[:-KEPT]

    def _solve(self) -> bool:
        presses = self._by_hand.values()
        return self._solving.poll([self._key(each.patch, each.tool) for each in presses])

    @property
    def waits(self) -> list[str]:
        """Presses by hand whose body is still being solved."""
        return [touch.id for touch in self._by_hand.values() if self._table(touch) is None]

    def press(self, request: Request) -> dict[str, Any]:
        """Begin a press by hand, see `docs/how-to/virtual-skin.md`; what came of it."""
        patch = patch_index(self.skin, request.patch)
        x, y = request.on(self.skin.patches[patch])
        tool = SceneTool(request.radius, request.shape)
        force = 1.0 if request.force is None else request.force
        name = request.id or f"press-{next(self._numbers)}"
        if len(name) > LONGEST_ID:
            raise InputError(f"id is {name!r:.80}, expected up to {LONGEST_ID} characters")
        if name not in self._by_hand and len(self._by_hand) >= MOST:
            raise InputError(f"{MOST} presses are there, expected fewer: release some first")
        before = self._by_hand.get(name)
        if before is not None and before.tool == tool:  # the same objects: the truth keeps them
            name, tool = before.id, before.tool
        touch = CurrentPress(name, patch, tool, x, y, force)
        table = self._table(touch)
        if table is not None:
            table.check_force(force, tool)
        self._by_hand.pop(name, None)  # the newest is the last
        self._by_hand[name] = touch
        self._solve()
        return {"id": name, "x": x, "y": y, "radius": tool.radius, "solving": table is None}

    def move(self, request: Request) -> dict[str, Any]:
        """Move a press by hand, or change its force."""
        touch = self._named(request.id)
        x = touch.x if request.x is None else request.x
        y = touch.y if request.y is None else request.y
        x, y = replace(request, x=x, y=y).on(self.skin.patches[touch.patch])
        force = touch.force if request.force is None else request.force
        table = self._table(touch)
        if request.force is not None and table is not None:
            table.check_force(force, touch.tool)
        self._by_hand[touch.id] = replace(touch, x=x, y=y, force=force)
        return {"id": touch.id, "x": x, "y": y, "force": force}

    def release(self, request: Request) -> dict[str, Any]:
        """Lift off one press by hand, or all."""
        names = list(self._by_hand) if request.id is None else [self._named(request.id).id]
        for name in names:
            del self._by_hand[name]
        return {"released": names}

    def _named(self, name: str | None) -> CurrentPress:
        if name not in self._by_hand:
            known = ", ".join(self._by_hand) or "none is there"
            raise InputError(f"id is {name!r:.80}, expected that of a press by hand: {known}")
        return self._by_hand[name]

    def close(self) -> None:
        """End what is being solved."""
        self._solving.close()

"""Tables of presses of a virtual skin: solved once for a tool, kept on disk, looked up at once."""

import hashlib
import math
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, fields, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from skinfield.elastic import Layer
from skinfield.emulator.scenes import STAMPS, SceneTool
from skinfield.errors import Floats, InputError

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
STAMP_SHARES = (0.02, 0.12, 0.25, 0.5, 0.75, 1.0)  # of the largest force of a stamp, as `SHARES`
PUSHES = np.geomspace(0.01, 1.0, 6)  # of the largest force, at which a push is solved
PUSH = 0.25  # of the force, that is pushed with: what is read is in proportion to it
POINTS = 0.5e-3  # m between the points of a stamp's table
ASIDE = 8.0  # thicknesses around a stamp that its table covers
ROWS = np.arange(FORCES)
REACH = 12.0  # thicknesses beyond the touch where readings are below 1e-3 of the highest
Key = tuple[SceneTool, float]
Tell = Callable[[float], None]  # takes the share of the work that is done
AT_ONCE = 2  # tables that are solved at a time: each takes a processor for seconds
BESIDE = 5  # nice of a process that solves what nobody presses with yet
SCRIPT = """
import os
from skinfield.elastic import Layer
from skinfield.emulator.scenes import STAMPS, SceneTool
from skinfield.emulator.press_tables import table_for
os.nice({nice!r})
table_for({tool!r}, Layer(*{layer!r}), {pad_diameter!r}, lambda share: print(share, flush=True))
"""


@dataclass(frozen=True, eq=False)
class ToolTable:
    """Readings of one tool on one layer.

    Attributes
    ----------
    highest_force : float, N
    """

    highest_force: float

    def check_force(self, force: float, tool: SceneTool) -> None:
        """Raise InputError for a force that pushes the tool through the layer."""
        highest = self.highest_force / max(part for _, part in tool.parts)
        if not 0.0 < force <= highest:
            raise InputError(
                f"force is {force:g} N, expected above 0 and at most {highest:.3g} N "
                f"for a {tool.shape} of {tool.radius * 1e3:g} mm radius, which then sinks through "
                f"{DEEPEST:.0%} of the layer: press lighter, or with a larger radius"
            )

    def readings(self, away: Floats, force: float) -> Floats:
        """ΔC/C₀ (N,) at places (N, 2) m from a press."""
        raise NotImplementedError

    def radius_at(self, force: float) -> float:
        """Radius of the touch, m; of a circle of its area."""
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class PressTable(ToolTable):
    """Readings of a tool that is the same all around.

    Attributes
    ----------
    contact_radius : (FORCES,) array, m
    change : (FORCES, D) array
        ΔC/C₀ at distances 0, SPACING, 2 SPACING, ... from the press. Row i is of the force
        (i / (FORCES - 1))² · highest_force: close to each other where readings rise steeply.
    """

    contact_radius: Floats
    change: Floats

    def _row(self, force: float) -> float:
        """Row of a force, between two of them as a rule."""
        return math.sqrt(min(force / self.highest_force, 1.0)) * (FORCES - 1)

    def readings(self, away: Floats, force: float) -> Floats:
        """See `ToolTable`; linear between the entries."""
        row, distance = self._row(force), np.hypot(away[:, 0], away[:, 1])
        lower = min(int(row), FORCES - 2)
        values = (lower + 1 - row) * self.change[lower] + (row - lower) * self.change[lower + 1]
        places = SPACING * np.arange(len(values))
        return np.asarray(np.interp(distance, places, values, right=0.0))

    def radius_at(self, force: float) -> float:
        """See `ToolTable`."""
        return float(np.interp(self._row(force), ROWS, self.contact_radius))


@dataclass(frozen=True, eq=False)
class StampTable(ToolTable):
    """Readings of a stamp.

    Attributes
    ----------
    forces : (F,) array, N
    contact_radius : (F,) array, m
    change : (F, n, n) array, 1/N
        Coefficients of the cubic B-splines of ΔC/C₀ per newton, on points `POINTS` apart about
        the press, rows along y.
    """

    forces: Floats
    contact_radius: Floats
    change: Floats

    def readings(self, away: Floats, force: float) -> Floats:
        """See `ToolTable`; what is read per newton is linear between the forces."""
        from scipy.ndimage import map_coordinates

        row = float(np.interp(force, self.forces, np.arange(len(self.forces))))
        lower = min(int(row), len(self.forces) - 2)
        slope = (lower + 1 - row) * self.change[lower] + (row - lower) * self.change[lower + 1]
        places = away.T[::-1] / POINTS + (len(slope) - 1) / 2.0
        return np.asarray(force * map_coordinates(slope, places, order=3, prefilter=False))

    def radius_at(self, force: float) -> float:
        """See `ToolTable`."""
        return float(np.interp(force, self.forces, self.contact_radius))


@dataclass(frozen=True, eq=False)
class PushTable(ToolTable):
    """What a push along the skin adds to the readings of a ball or a flat end, which stick.

    To first order in the push, as the cosine of the angle: what is of second order is a hundredth
    of the highest reading for half the force.

    Attributes
    ----------
    forces : (F,) array, N
        Into the skin.
    change : (F, D) array, 1/N
        ΔC/C₀ per newton straight ahead of the press, at distances 0, LINE, 2 LINE, ...
    """

    forces: Floats
    change: Floats

    def added(self, away: Floats, force: float, push: Floats) -> Floats:
        """ΔC/C₀ (N,) at places (N, 2) m from a press, by a push (2,) N; linear in ln force."""
        row = float(np.interp(math.log(force), np.log(self.forces), np.arange(len(self.forces))))
        lower = min(int(row), len(self.forces) - 2)
        ahead = (lower + 1 - row) * self.change[lower] + (row - lower) * self.change[lower + 1]
        distance = np.hypot(away[:, 0], away[:, 1])
        per_newton = np.interp(distance, LINE * np.arange(len(ahead)), ahead, right=0.0)
        return np.asarray(per_newton * (away @ push) / np.maximum(distance, 1e-9))


def solve_push(
    tool: SceneTool, layer: Layer, pad_diameter: float, tell: Tell = lambda share: None
) -> PushTable:
    """Solve the pushes of a table: about four seconds of a processor."""
    from skinfield.simulate import press

    _, solved, widest, extent = _hard_loads(tool, layer)
    forces, ahead = min(solved[len(SHARES) - 1].force, HARDEST) * PUSHES, []
    reach = widest + pad_diameter + REACH * layer.thickness
    line = np.arange(0.0, reach + LINE, LINE)[:, None] * [1.0, 0.0]
    for index, force in enumerate(forces.tolist()):
        body = replace(tool.body(force=force), shear=(PUSH * force, 0.0))
        made = press(layer, [body], extent, CELL)
        before, behind = made.readings(
            np.concatenate([line, -line]), pad_diameter, "capacitance"
        ).reshape(2, -1)
        ahead.append((before - behind) / (2.0 * PUSH * force))
        tell((index + 1) / len(forces))
    return PushTable(float(forces[-1]), forces, np.array(ahead))


def solve_stamp(
    tool: SceneTool, layer: Layer, pad_diameter: float, tell: Tell = lambda share: None
) -> StampTable:
    """Solve the presses of a stamp: see `solve_table`."""
    from scipy.ndimage import spline_filter

    from skinfield.simulate import ladder_steps, press

    extent = _extent(1.5 * tool.radius, layer)  # the corners of a face
    deepest = press(layer, [tool.body(depth=DEEPEST * layer.thickness)], extent, CELL)
    forces = min(deepest.force, HARDEST) * np.array(STAMP_SHARES)
    reach = tool.radius + pad_diameter + ASIDE * layer.thickness
    axis = POINTS * np.arange(-math.ceil(reach / POINTS), math.ceil(reach / POINTS) + 1)
    points = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    slopes, radius = np.zeros((len(forces), len(axis), len(axis))), np.zeros(len(forces))
    for index, each in ladder_steps(layer, tool.body(), forces, extent, CELL):
        read = each.readings(points, pad_diameter, "capacitance").reshape(slopes.shape[1:])
        slopes[index] = spline_filter(read / each.force)
        radius[index] = math.sqrt(each.contact_area / math.pi)
        tell((index + 1) / len(forces))
    return StampTable(float(forces[-1]), forces, radius, slopes)


def solve_table(
    tool: SceneTool, layer: Layer, pad_diameter: float, tell: Tell = lambda share: None
) -> ToolTable:
    """Solve the presses of a table: two to four seconds of a processor.

    Half of it are contacts, solved for `SHARES` of the highest force, half the electric field of
    each, which tells what taxels read.

    Parameters
    ----------
    tool : SceneTool
    layer : Layer
    pad_diameter : float, m
    tell : function
        Told the share of the work that is done, 0 to 1, after each step.
    """
    from skinfield.simulate import ladder_steps

    if tool.pushed:
        return solve_push(tool, layer, pad_diameter, tell)
    if tool.shape in STAMPS:
        return solve_stamp(tool, layer, pad_diameter, tell)
    load = _soft_loads if tool.is_soft else _hard_loads
    forces, solved, widest, extent = load(tool, layer)
    for index, each in ladder_steps(layer, tool.body(), forces, extent, CELL):
        solved[index] = each
        tell(0.5 * len(solved) / len(SHARES))
    return _tabulated([solved[i] for i in range(len(SHARES))], widest, pad_diameter, tell)


# forces that are to be solved, N, presses that are solved by their place in SHARES, the largest
# radius of a touch, m, and the side of the grid, m
Loads = tuple[Floats, dict[int, "Press"], float, float]


def _hard_loads(tool: SceneTool, layer: Layer) -> Loads:
    """Up to that which sinks as deep as a table goes."""
    from skinfield.simulate import press

    bound = tool.radius if tool.shape == "flat" else math.sqrt(2.0 * tool.radius * layer.thickness)
    widest = min(bound, tool.radius)
    extent = _extent(widest, layer)
    deepest = press(layer, [tool.body(depth=DEEPEST * layer.thickness)], extent, CELL)
    return deepest.force * np.array(SHARES)[:-1], {len(SHARES) - 1: deepest}, widest, extent


def _extent(widest: float, layer: Layer) -> float:
    return 2.0 * math.ceil((widest + 5.0 * layer.thickness) / CELL) * CELL


def _soft_loads(tool: SceneTool, layer: Layer) -> Loads:
    """Of a soft body up to the force that sinks as deep; the depth goes by a power of it."""
    from skinfield.simulate import press

    widest = tool.body(force=HARDEST).reach
    extent = _extent(widest, layer)
    target, force = DEEPEST * layer.thickness, SOFTEST * HARDEST
    for _ in range(ROUNDS):
        depth = float(press(layer, [tool.body(force=force)], extent, CELL).approach[0])
        power = 1.0 - 2.0 * tool.body(force=force).growth
        force = min(force * (target / depth) ** (1.0 / power), HARDEST)
    return force * np.array(SHARES), {}, widest, extent


def _tabulated(
    solved: "Sequence[Press]", widest: float, pad_diameter: float, tell: Tell
) -> PressTable:
    """Table of presses from a small part of the highest force to all of it."""
    from scipy.interpolate import CubicSpline, PchipInterpolator

    forces, highest = np.array([each.force for each in solved]), solved[-1].force
    reach = widest + pad_diameter + REACH * solved[0].layer.thickness
    distance = np.arange(0.0, reach + LINE, LINE)
    line = np.column_stack([distance, np.zeros_like(distance)])
    read = np.zeros((len(solved), len(distance)))
    for i, each in enumerate(solved):
        read[i] = each.readings(line, pad_diameter, "capacitance")
        tell(0.5 + 0.5 * (i + 1) / len(solved))
    radius = np.array([math.sqrt(each.contact_area / math.pi) for each in solved])
    fine = np.arange(0.0, reach, SPACING)
    rows = (ROWS / (FORCES - 1)) ** 2 * highest
    # What is read per newton hardly changes with the force: that is what is interpolated.
    slope = CubicSpline(np.log(forces), read / forces[:, None])
    known = np.maximum(rows, forces[0])
    values = CubicSpline(distance, slope(np.log(known)) * rows[:, None], axis=1)(fine)
    touch = PchipInterpolator(np.concatenate([[0.0], forces]), np.concatenate([[0.0], radius]))
    return PressTable(float(highest), np.asarray(touch(rows)), np.ascontiguousarray(values))


def table_for(
    tool: SceneTool, layer: Layer, pad_diameter: float, tell: Tell = lambda share: None
) -> ToolTable:
    """As `solve_table`, from the user's cache where it was solved before by the very same code."""
    path, kind = cache_path(tool, layer, pad_diameter), _kind(tool)
    try:
        with np.load(path) as file:
            values = {each.name: file[each.name] for each in fields(kind)}
            return kind(**values | {"highest_force": float(file["highest_force"])})
    except (OSError, ValueError, KeyError, EOFError):  # not there, or cut
        table = solve_table(tool, layer, pad_diameter, tell)
    partial = path.with_name(f"{path.stem}-{os.getpid()}.part.npz")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez(partial, **{each.name: getattr(table, each.name) for each in fields(kind)})
        partial.replace(path)
    except OSError:  # a folder that cannot be written only means to solve again next time
        partial.unlink(missing_ok=True)
    return table


def _kind(tool: SceneTool) -> type[PressTable | PushTable | StampTable]:
    if tool.pushed:
        return PushTable
    return StampTable if tool.shape in STAMPS else PressTable


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


class Solving:
    """A table that a process solves, which says how far it is.

    Attributes
    ----------
    share : float
        Of the work that is done.
    """

    def __init__(self, process: "subprocess.Popen[bytes]") -> None:
        self.process, self.share = process, 0.0
        if process.stdout is not None:
            os.set_blocking(process.stdout.fileno(), False)

    def ended(self) -> bool:
        """Whether it is done; takes in what it has said by now."""
        if self.process.stdout is not None:
            said = (self.process.stdout.read() or b"").split()
            self.share = float(said[-1]) if said else self.share
        return self.process.poll() is not None

    def close(self) -> None:
        """End it."""
        self.process.kill()
        self.process.wait()
        if self.process.stdout is not None:
            self.process.stdout.close()


class PressTables:
    """Tables that are there, and those that are on their way, of presses on one layer."""

    def __init__(self, layer: Layer) -> None:
        self._layer = layer
        self._there: dict[Key, ToolTable] = {}
        self._running: dict[Key, Solving] = {}

    @property
    def solved(self) -> set[Key]:
        """Of the tables that are there."""
        return set(self._there)

    @property
    def shares(self) -> dict[Key, float]:
        """Of the tables on their way: the share of the work that is done."""
        return {key: each.share for key, each in self._running.items()}

    def get(self, key: Key) -> ToolTable | None:
        """A table, if it is there or was solved before."""
        if key not in self._there and cache_path(key[0], self._layer, key[1]).is_file():
            return self.now(key)
        return self._there.get(key)

    def now(self, key: Key) -> ToolTable:
        """A table, solved here if it must be."""
        if key not in self._there:
            self._there[key] = table_for(key[0], self._layer, key[1])
        return self._there[key]

    def poll(self, wanted: Sequence[Key], ahead: Sequence[Key] = ()) -> bool:
        """Take in what is solved, and have others solved, the last first; whether there was some.

        Those `ahead` come one at a time, and while nothing is `wanted`. Where nothing could be
        stored, it is solved here after all.
        """
        ended = [key for key, each in self._running.items() if each.ended()]
        for key in ended:
            self._running.pop(key).close()
            self.now(key)
        self._begin(wanted, AT_ONCE, 0)
        self._begin(ahead, 1, BESIDE)
        return bool(ended)

    def _begin(self, keys: Sequence[Key], most: int, nice: int) -> None:
        for key in reversed(keys):
            if len(self._running) < most and key not in self._there | self._running:
                self._solve(key, nice)

    def _solve(self, key: Key, nice: int) -> None:
        tool, pad_diameter = key
        layer = astuple(self._layer)
        script = SCRIPT.format(tool=tool, layer=layer, pad_diameter=pad_diameter, nice=nice)
        quiet = subprocess.DEVNULL
        process = subprocess.Popen(
            [sys.executable, "-c", script], stdin=quiet, stdout=subprocess.PIPE, stderr=quiet
        )
        self._running[key] = Solving(process)

    def close(self) -> None:
        """End what runs."""
        for each in self._running.values():
            each.close()
        self._running.clear()

"""What taxels read of a round press, by force and distance: solved before the stream begins."""

import hashlib
import math
import os
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.mechanics import Layer
from skinfield.virtual.tool import Tool

DEEPEST = 0.75  # of the thickness: where tables end
SOFTEST = 1.0 / 400.0  # of the largest force: the least that is solved; below it, in proportion
SHARES = (*np.geomspace(SOFTEST, 0.3, 6), *np.linspace(0.475, 1.0, 4))  # of it, that are solved
CELL = 0.5e-3  # m
LINE = 0.25e-3  # m between the distances that are solved
SPACING = 0.05e-3  # m between the distances of a table
FORCES = 128  # rows of a table
REACH = 12.0  # thicknesses beyond the touch where readings are below 1e-3 of the highest


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

    def check_force(self, force: float, tool: Tool) -> None:
        """Raise InputError for a force that pushes the tool through the layer."""
        if not 0.0 < force <= self.highest_force:
            raise InputError(
                f"force is {force:g} N, expected above 0 and at most {self.highest_force:.3g} N "
                f"for a {tool.shape} of {tool.radius * 1e3:g} mm radius, which then sinks through "
                f"{DEEPEST:.0%} of the layer: press lighter, or with a larger radius"
            )

    def radius_at(self, force: float) -> float:
        """Radius of the touch, m."""
        row = math.sqrt(min(force / self.highest_force, 1.0)) * (FORCES - 1)
        lower = min(int(row), FORCES - 2)
        low, high = self._radii[lower], self._radii[lower + 1]
        return low + (row - lower) * (high - low)

    @cached_property
    def _radii(self) -> list[float]:
        return [float(each) for each in self.contact_radius]


def solve_table(tool: Tool, layer: Layer, pad_diameter: float) -> PressTable:
    """Solve the presses of a table: a second or two.

    Parameters
    ----------
    tool : Tool
    layer : Layer
    pad_diameter : float, m
    """
    from scipy.interpolate import CubicSpline, PchipInterpolator

    from skinfield.simulate import press, press_ladder

    bound = tool.radius if tool.shape == "flat" else math.sqrt(2.0 * tool.radius * layer.thickness)
    extent = 2.0 * math.ceil((min(bound, tool.radius) + 5.0 * layer.thickness) / CELL) * CELL
    deepest = press(layer, [tool.body(depth=DEEPEST * layer.thickness)], extent, CELL)
    highest = deepest.force
    forces = highest * np.array(SHARES)
    solved = [*press_ladder(layer, tool.body(), forces[:-1], extent, CELL), deepest]
    reach = min(bound, tool.radius) + pad_diameter + REACH * layer.thickness
    distance = np.arange(0.0, reach + LINE, LINE)
    line = np.column_stack([distance, np.zeros_like(distance)])
    read = np.array([each.readings(line, pad_diameter, "capacitance") for each in solved])
    radius = np.array([math.sqrt(each.contact_area / math.pi) for each in solved])
    fine = np.arange(0.0, reach, SPACING)
    rows = (np.arange(FORCES) / (FORCES - 1)) ** 2 * highest
    # What is read per newton hardly changes with the force: that is what is interpolated.
    slope = CubicSpline(np.log(forces), read / forces[:, None])
    known = np.maximum(rows, forces[0])
    values = CubicSpline(distance, slope(np.log(known)) * rows[:, None], axis=1)(fine)
    touch = PchipInterpolator(np.concatenate([[0.0], forces]), np.concatenate([[0.0], radius]))
    return PressTable(float(highest), np.asarray(touch(rows)), np.ascontiguousarray(values))


def table_for(tool: Tool, layer: Layer, pad_diameter: float) -> PressTable:
    """As `solve_table`, from the user's cache where it was solved before by the very same code."""
    path = cache_path(tool, layer, pad_diameter)
    found = _stored(path)
    if found is None:
        found = solve_table(tool, layer, pad_diameter)
        _store(path, found)
    return found


def cache_path(tool: Tool, layer: Layer, pad_diameter: float) -> Path:
    """Where a table is kept: its name depends on what is pressed and on the code that solves it."""
    root = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    asked = f"{tool!r} {layer!r} {pad_diameter!r} {_code()}"
    name = hashlib.sha256(asked.encode()).hexdigest()[:24]
    return Path(root) / "skinfield" / f"press-{name}.npz"


def is_stored(tool: Tool, layer: Layer, pad_diameter: float) -> bool:
    """Whether a table need not be solved."""
    return cache_path(tool, layer, pad_diameter).is_file()


@cache
def _code() -> str:
    """Digest of the sources that a table comes from, so that no change of them is missed."""
    root, digest = Path(__file__).parent.parent, hashlib.sha256()
    for room in ("simulate", "mechanics", "observation"):
        for file in sorted((root / room).rglob("*.py")):
            digest.update(file.read_bytes())
    digest.update(Path(__file__).read_bytes())
    return digest.hexdigest()


def _stored(path: Path) -> PressTable | None:
    """A table from the cache; None where there is none that can be read."""
    try:
        with np.load(path) as file:
            return PressTable(float(file["force"]), file["radius"], file["change"])
    except (OSError, ValueError, KeyError, EOFError):
        return None  # not there, or cut: it is solved again, which only takes time


def _store(path: Path, table: PressTable) -> None:
    """Keep a table; a folder that cannot be written only means to solve again next time."""
    partial = path.with_name(f"{path.stem}-{os.getpid()}.part.npz")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez(
            partial, force=table.highest_force, radius=table.contact_radius, change=table.change
        )
        partial.replace(path)
    except OSError:
        partial.unlink(missing_ok=True)

"""Published numbers of the bonded layer beside the exact solver and the contact solver."""

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from skinfield.errors import FileError, Floats
from skinfield.experiments.recorded.finding import Finding, Value, needed
from skinfield.mechanics import Layer
from skinfield.mechanics.axisymmetric import indent_to_radius, kappa
from skinfield.mechanics.hertz import HertzSphere, effective_modulus
from skinfield.mechanics.profiles import Paraboloid
from skinfield.simulate import Cylinder, press
from skinfield.simulate.indenters.body import Body

PUNCH, PARABOLOID = "hayes_flat_punch_kappa.csv", "paraboloid_bonded_layer_nu0.5.csv"
COMPUTED = {
    0.45: "kappa_computed_nu0.45",
    0.5: "kappa_computed_nu0.50",
    0.3: "kappa_computed_nu0.30",
}
HAYES = "kappa_hayes_table_nu0.45(found)"
SLENDER = 20.0  # radius of curvature over that of the contact, in the paraboloid's table
PRESSED = (0.2, 1.0, 3.0)  # contact radii over thickness that the contact solver is asked for
CELLS = 30  # across a contact that the contact solver computes
THICKNESS, MODULUS = 2e-3, 100e3  # any: the tables have no dimensions
SOURCE = "table of flat punches after Hayes et al. 1972, table of paraboloids at ν = 0.5"


@dataclass(frozen=True, kw_only=True)
class _Blunt(Body):
    """A paraboloid, as the table has it, for the contact solver."""

    radius: float
    kind: ClassVar[str] = "paraboloid"

    def height(self, x: Floats, y: Floats) -> Floats:
        """See `Indenter.height`."""
        return np.asarray((x**2 + y**2) / (2.0 * self.radius))


@dataclass(frozen=True)
class Agreement:
    """Largest relative deviation from one column of a table, over rows of these a/h."""

    column: str
    by: str
    largest: float
    widest: float  # a/h of the rows' last


def read_table(path: Path) -> list[dict[str, float]]:
    """Rows of a CSV file of numbers under titles.

    Raises
    ------
    FileError
        If a cell is no finite number, or there is no row; with the line.
    """
    try:
        with path.open(encoding="utf-8", newline="") as file:
            lines = list(csv.reader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise FileError(f"{path} cannot be read as a table: {error}") from error
    rows = []
    for number, line in enumerate(lines[1:], start=2):
        try:
            row = dict(zip(lines[0], map(float, line), strict=True))
        except ValueError as error:
            raise FileError(
                f"{path}:{number} is {','.join(line)[:40]!r}, expected {len(lines[0])} numbers"
            ) from error
        if not np.isfinite(list(row.values())).all():
            raise FileError(
                f"{path}:{number} has a number that is not finite, expected finite ones"
            )
        rows.append(row)
    if not rows:
        raise FileError(f"{path} has no rows below its titles, expected some")
    return rows


def _column(path: Path, rows: list[dict[str, float]], name: str) -> Floats:
    if name not in rows[0]:
        raise FileError(f"{path} has columns {', '.join(rows[0])}, expected {name} among them")
    return np.array([row[name] for row in rows])


def agreements(folder: Path) -> tuple[Agreement, ...]:
    """Every column by the exact solver, and some of it by the contact solver."""
    punch = needed(folder, "tables", PUNCH)
    parabola = needed(folder, "tables", PARABOLOID)
    return (*_punches(punch), *_paraboloids(parabola))


def _punches(path: Path) -> list[Agreement]:
    rows = read_table(path)
    share = _column(path, rows, "a_over_h")
    found, exact = [], {}
    for nu, column in COMPUTED.items():
        exact[nu] = np.array([kappa(float(a), nu) for a in share])
        table = _column(path, rows, column)
        found.append(_agreement(column, "exact", share, exact[nu], table))
        near = np.isin(share, PRESSED)
        pressed = np.array([pressed_kappa(float(a), nu) for a in share[near]])
        found.append(_agreement(column, "contact solver", share[near], pressed, table[near]))
    hayes = _column(path, rows, HAYES)
    return [*found, _agreement(HAYES, "exact", share, exact[0.45], hayes)]


def _paraboloids(path: Path) -> list[Agreement]:
    rows = read_table(path)
    share = _column(path, rows, "a_over_h")
    exact = np.array([paraboloid_numbers(float(a)) for a in share])
    found = []
    for name, numbers in zip(("delta_over_h", "F_over_FHertz_exact"), exact.T, strict=True):
        found.append(_agreement(name, "exact", share, numbers, _column(path, rows, name)))
    near = np.isin(share, PRESSED)
    force = _column(path, rows, "F_over_FHertz_exact")[near]
    depth = _column(path, rows, "delta_over_h")[near]
    pressed = [pressed_depth(a, d, f) for a, d, f in zip(share[near], depth, force, strict=True)]
    return [
        *found,
        _agreement("delta_over_h", "contact solver", share[near], np.array(pressed), depth),
    ]


def _agreement(column: str, by: str, share: Floats, found: Floats, table: Floats) -> Agreement:
    return Agreement(column, by, float(np.abs(found / table - 1.0).max()), float(share.max()))


def paraboloid_numbers(a_over_h: float) -> tuple[float, float]:
    """Depth over thickness, and force over Hertz's at the same depth, of the table's paraboloid."""
    radius = SLENDER * a_over_h
    # One metre of thickness is the unit; the table has none.
    state = indent_to_radius(Layer(1.0, 1.0, 0.5), Paraboloid(radius=radius), a_over_h)
    hertz = HertzSphere.from_depth(
        radius=radius, modulus=effective_modulus(1.0, 0.5), depth=state.depth
    )
    return state.depth, state.force / hertz.force


def pressed_kappa(a_over_h: float, nu: float) -> float:
    """Hayes' factor by the contact solver."""
    a, force = a_over_h * THICKNESS, 1e-4
    cell = 2.0 * a / CELLS
    body = Cylinder(radius=a, force=force)
    state = press(Layer(THICKNESS, MODULUS, nu), [body], extent=2.0 * a + 4.5 * cell, cell=cell)
    return float(force / (2.0 * effective_modulus(MODULUS, nu) * a * state.approach[0]))


def pressed_depth(a_over_h: float, depth_over_h: float, over_hertz: float) -> float:
    """Depth over thickness by the contact solver under the force of the table."""
    a = a_over_h * THICKNESS
    radius, depth = SLENDER * a, depth_over_h * THICKNESS
    hertz = HertzSphere.from_depth(
        radius=radius, modulus=effective_modulus(MODULUS, 0.5), depth=depth
    )
    body = _Blunt(radius=radius, force=over_hertz * hertz.force)
    state = press(Layer(THICKNESS, MODULUS, 0.5), [body], extent=2.6 * a, cell=2.0 * a / CELLS)
    return float(state.approach[0]) / THICKNESS


def layer_tables(folder: Path) -> Finding:
    """See `Agreement`; in words."""
    found = agreements(folder)
    exact = max(each.largest for each in found if each.by == "exact" and each.column != HAYES)
    pressed = max(each.largest for each in found if each.by != "exact")
    hayes = next(each for each in found if each.column == HAYES)
    sentences = (
        f"The exact axisymmetric solver meets every computed column to {exact:.1e} at most, the "
        "last digit of the tables.",
        f"The contact solver, on {CELLS} cells across the contact and at a/h of "
        f"{', '.join(f'{a:g}' for a in PRESSED)}, is within {100 * pressed:.1g} % of them.",
        f"Hayes' own table of 1972 differs by up to {100 * hayes.largest:.1f} %, at "
        f"a/h = {hayes.widest:g}.",
    )
    rows: list[dict[str, Value]] = [
        {
            "column": each.column,
            "by": each.by,
            "a/h up to": each.widest,
            "largest deviation (%)": float(f"{100 * each.largest:.2g}"),
        }
        for each in found
    ]
    return Finding(
        name="tables",
        title="published numbers of the bonded layer",
        source=SOURCE,
        sentences=sentences,
        rows=tuple(rows),
    )

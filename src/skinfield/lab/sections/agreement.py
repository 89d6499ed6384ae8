"""Verification of the truth: the contact solver beside finite elements, and the half-space's error.

The lattice and the exact solution share the layer's transfer function; the finite elements share
nothing with either, so they are the judge. The paper's half-space is given the true pressure, so
that what is off is the model alone.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from skinfield.elastic import HalfSpace, LatticeConvolution, Layer, Mechanics
from skinfield.elastic.axisymmetric import Ball, Indentation, indent_by_force, punch
from skinfield.elastic.lattice import lattice, mirrored
from skinfield.errors import Floats, InputError
from skinfield.lab.fem.electrostatics import pad_capacitance
from skinfield.lab.fem.small_strain import indent
from skinfield.lab.paper import LAYER, LOADS, TIPS
from skinfield.lab.plots import Curve, Panel, Scale, draw_panels
from skinfield.lab.report import Chapter, Claim, Effort, Picture, Table, spread_in_words
from skinfield.lab.score import Row, column, where
from skinfield.simulate import Cylinder, Press, Sphere, press

Round = Sphere | Cylinder
FINEST = 0.01  # length of the smallest elements, in thicknesses
SMOKE_LOADS, SMOKE_FINEST = (0.5,), 0.03
PAD = 4e-3  # m; the pads' diameter
SPAN = 30e-3  # m: side of the square over which the half-space is compared; fields fall within 10 h
HALF_SPACE = HalfSpace(point_forces=False)  # of uniform cells: no error but the model's
LINEAR = 0.5  # of the thickness: deeper, linear elasticity itself is off by several per cent
RADII = np.linspace(0.0, 12e-3, 241)  # m; where fields are compared, weighted by area
COLUMNS = {
    "indenter": "indenter",
    "force": "force (N)",
    "depth": "depth, elements (mm)",
    "lattice_depth": "depth, lattice (mm)",
    "exact_depth": "depth, exact (mm)",
    "lattice_base": "base stress, lattice (relative L2)",
    "exact_base": "base stress, exact (relative L2)",
    "lattice_surface": "surface, lattice (relative L2)",
    "exact_surface": "surface, exact (relative L2)",
    "lattice_peak": "base peak, lattice (relative error)",
    "reading": "ΔC/C₀, elements",
    "field": "ΔC/C₀, lattice",
    "series": "ΔC/C₀, series",
    "stress": "base stress below pads, half-space (relative L2)",
    "point_stress": "base stress at a point, half-space (relative L2)",
    "displacement": "surface, half-space (relative L2)",
}


def agree(
    layer: Layer,
    name: str,
    body: Round,
    force: float,
    cell: float = 0.25e-3,
    finest: float = FINEST,
) -> Row:
    """Press a body at the origin three ways and compare; a row with the keys of `COLUMNS`.

    Parameters
    ----------
    layer : Layer
    name : str
        For the row.
    body : Sphere or Cylinder
    force : float, N
    cell : float, m
        Of the lattice.
    finest : float
        Length of the smallest elements, in thicknesses.
    """
    cells = press(layer, [replace(body, force=force)], extent=body.radius * 2 + 4e-3, cell=cell)
    judge = indent(layer, lambda r: body.height(r, np.zeros_like(r)), force=force, finest=finest)
    exact: Indentation
    if isinstance(body, Sphere):
        exact = indent_by_force(layer, Ball(radius=body.radius), force)
    else:
        exact = punch(layer, body.radius, force=force)
    edges, pad = [judge.contact_radius], np.zeros((1, 2))
    charge = pad_capacitance(layer.thickness, judge.indentation, [0.0], PAD, edges=edges)
    line = np.column_stack([RADII, np.zeros_like(RADII)])
    base, weight = judge.base_stress(RADII), np.sqrt(RADII)
    lattice_base = cells.base_stress(line, 0.0)
    surface = judge.indentation(np.linalg.norm(cells.grid.plane, axis=1))
    exact_base, exact_surface = (
        np.asarray(values(RADII), dtype=float) for values in (exact.base_stress, exact.indentation)
    )
    return {
        "indenter": name,
        "force": force,
        "depth": 1e3 * judge.depth,
        "lattice_depth": 1e3 * float(cells.approach[0]),
        "exact_depth": 1e3 * exact.depth,
        "lattice_base": _relative(lattice_base, base, weight),
        "exact_base": _relative(exact_base, base, weight),
        "lattice_surface": _relative(-cells.displacement[:, 2], surface),
        "exact_surface": _relative(exact_surface, judge.indentation(RADII), weight),
        "lattice_peak": float(lattice_base[0] / base[0] - 1),
        "reading": float(charge[0]),
        "field": float(cells.capacitance(pad, PAD)[0]),
        "series": float(cells.capacitance(pad, PAD, order=3)[0]),
    } | half_space_error(cells)


def _relative(values: Floats, judge: Floats, weight: Floats | float = 1.0) -> float:
    """Relative L2; over the plane, where the weight is the root of the radius."""
    return float(np.linalg.norm(weight * (values - judge)) / np.linalg.norm(weight * judge))


def half_space_error(cells: Press) -> Row:
    """Compare the half-space with the layer under the true pressure, on its own cells.

    Relative L2 errors of the base stress' mean below a pad, of that at a point, and of the
    surface's normal displacement.
    """
    rows, columns = cells.grid.shape
    cell, layer = cells.grid.pitch, cells.layer
    margin = max(round((SPAN / cell - rows) / 2), 0)
    pressure = np.pad(cells.pressure.reshape(rows, columns), margin)
    half = len(pressure) - 1
    offsets = lattice(half, half, cell)

    def error(quadrant: Callable[[Mechanics], Floats]) -> float:
        exact, wrong = (
            LatticeConvolution(mirrored(quadrant(model).reshape(half + 1, half + 1)))(pressure)
            for model in (cells.mechanics, HALF_SPACE)
        )
        return _relative(wrong, exact)

    return {
        "stress": error(lambda model: model.base_stress(layer, offsets, cell, PAD)),
        "point_stress": error(lambda model: model.base_stress(layer, offsets, cell, 0.0)),
        "displacement": error(lambda model: model.indentation(layer, offsets, cell)),
    }


def agreements(settings: Effort) -> list[Row]:
    """The paper's indenters and loads, as far as Hooke's law keeps them off the base."""
    smoke = settings.name == "smoke"  # without the wide cylinder, which takes longest
    rows = []
    for tip in TIPS[:3] if smoke else TIPS:
        for force in SMOKE_LOADS if smoke else LOADS:
            try:
                finest = SMOKE_FINEST if smoke else FINEST
                rows.append(agree(LAYER, tip.name, tip.body, force, finest=finest))
            except InputError as error:
                if "sinks" not in str(error):
                    raise
    return rows


def agreement(settings: Effort) -> Chapter:
    """How far the truth of all other sections is from finite elements, per indenter and load."""
    rows = agreements(settings)
    linear = [row for row in rows if row["depth"] <= 1e3 * LINEAR * LAYER.thickness]
    stress, moved = (_percent(column(linear, name)) for name in ("stress", "displacement"))
    base, surface = (_percent(column(rows, f"lattice_{name}")) for name in ("base", "surface"))
    return Chapter(
        title="The truth and its judge, and what the half-space costs",
        claim="Simulations are compared with a commercial finite-element program; no numbers are "
        "given. The elastomer is treated as an elastic half-space, with displacements made to "
        "vanish at its base by subtraction; the error is not discussed.",
        sentences=(
            f"{len(rows)} presses, solved three ways: on cells with the layer's Green's function, "
            "as everywhere in this report; by an integral equation for bodies of revolution; and "
            "by mixed finite elements that share no code with either. A centred pad's capacitance "
            "is compared with what elements find for Laplace's equation in the deformed gap.",
            "The half-space is given the true pressure, up to half the thickness deep, where "
            "linear elasticity can be trusted; its displacement is corrected as in (17).",
        ),
        pictures=(
            _picture(
                "errors", rows, "contact solver against finite elements",
                (("Base stress", "lattice_base"), ("Surface", "lattice_surface")),
            ),
            _picture(
                "half-space", rows, "half-space, from the true pressure, against the layer",
                (("Base stress below pads", "stress"), ("Normal displacement", "displacement")),
            ),
        ),
        tables=(agreement_table(rows),),
        verdicts=(
            Claim(
                "truth", "a finite-element program is the reference",
                f"contact solver off by {base} of base stress, {surface} of the surface "
                "(relative L2)",
                "holds without it, up to linear elasticity",
            ),
            Claim(
                "model", "the layer behaves as a half-space",
                f"base stress off by {stress}, displacement by {moved} (relative L2, true pressure "
                "given)",
                "does not hold",
            ),
        ),
    )  # fmt: skip


def agreement_table(rows: Sequence[Row]) -> Table:
    """The comparison as a table of the report."""
    caption = (
        "One press three ways, compared with the finite elements; the half-space with the layer "
        "under the same true pressure."
    )
    cells = [{title: row[key] for key, title in COLUMNS.items()} for row in rows]
    return Table("agreement", caption, cells)


def _percent(values: Floats) -> str:
    return spread_in_words(values.tolist(), "%", 100)


def _picture(name: str, rows: list[Row], who: str, measures: Sequence[tuple[str, str]]) -> Picture:
    """Errors by indenter and load, a panel per measure (title, key)."""
    scale = Scale(
        x="load (N)", y="relative L2 (%)", log_x=True, log_y=True, x_ticks=LOADS,
        x_limits=(0.17, 3.5), marks=True,
    )  # fmt: skip
    panels = []
    for title, key in measures:
        each = [(tip.name, where(rows, indenter=tip.name)) for tip in TIPS]
        curves = [Curve(n, column(mine, "force"), 100 * column(mine, key)) for n, mine in each]
        panels.append(Panel(title, "", tuple(curves), scale))
    return Picture.of(name, f"Error of the {who}, by indenter and load.", draw_panels([panels]))

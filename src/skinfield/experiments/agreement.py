"""One press, three ways: on cells with the layer's Green's function, exactly, and by elements.

The lattice and the exact solution share the layer's transfer function; the finite elements share
nothing with either, so they are the judge.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from skinfield.errors import Floats, InputError
from skinfield.experiments.section import Table
from skinfield.fem import AxisymmetricSolution, indent, pad_capacitance
from skinfield.mechanics import Layer
from skinfield.mechanics.axisymmetric import Indentation, indent_by_force, punch
from skinfield.mechanics.profiles import Ball
from skinfield.simulate import Cylinder, Press, Sphere, press

Round = Sphere | Cylinder
LOADS = (0.2, 0.5, 1.8, 3.0)  # N, the paper's
BODIES: tuple[tuple[str, Round], ...] = (
    ("half-sphere 12 mm", Sphere(radius=6e-3)),
    ("half-sphere 6 mm", Sphere(radius=3e-3)),
    ("cylinder 3 mm", Cylinder(radius=1.5e-3)),
    ("cylinder 12 mm", Cylinder(radius=6e-3)),
)
PAD = 4e-3  # m; the pads' diameter
RADII = np.linspace(0.0, 12e-3, 241)  # m; where fields are compared, weighted by area


@dataclass(frozen=True)
class Answer:
    """What one method says, beside the finite elements.

    Parameters
    ----------
    depth : float, m
    base_error, surface_error : float
        Relative L2 of base stress and of the surface's depth.
    peak_error : float
        Of the base stress on the axis, relative.
    """

    depth: float
    base_error: float
    surface_error: float
    peak_error: float


@dataclass(frozen=True)
class Agreement:
    """One body with one load.

    Parameters
    ----------
    name : str
    force : float, N
    depth, contact_radius : float, m
        By finite elements, as are the next two.
    base_peak : float, Pa
        Base stress on the axis.
    reading : float
        ΔC/C₀ of the centred pad, by Laplace's equation.
    lattice, exact : Answer
        `simulate.press`, and the integral equation for bodies of revolution.
    field, series : float
        ΔC/C₀ of the centred pad below the lattice's surface: of the field, and to third order.
    """

    name: str
    force: float
    depth: float
    contact_radius: float
    base_peak: float
    reading: float
    lattice: Answer
    exact: Answer
    field: float
    series: float


def agree(
    layer: Layer, name: str, body: Round, force: float, cell: float = 0.25e-3, finest: float = 0.01
) -> Agreement:
    """Press a body at the origin three ways and compare.

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
    if body.position != (0.0, 0.0):
        raise InputError(f"position of {name} is {body.position}, expected the origin")
    judge = indent(layer, lambda r: body.height(r, np.zeros_like(r)), force=force, finest=finest)
    cells = press(layer, [replace(body, force=force)], extent=body.radius * 2 + 4e-3, cell=cell)
    if isinstance(body, Sphere):
        exact = indent_by_force(layer, Ball(radius=body.radius), force)
    else:
        exact = punch(layer, body.radius, force=force)
    edges = [judge.contact_radius]
    charge = pad_capacitance(layer.thickness, judge.indentation, [0.0], PAD, edges=edges)
    return Agreement(
        name=name,
        force=force,
        depth=judge.depth,
        contact_radius=judge.contact_radius,
        base_peak=float(judge.base_stress([0.0])[0]),
        reading=float(charge[0]),
        lattice=_beside(judge, cells),
        exact=_beside_exact(judge, exact),
        field=float(cells.capacitance(np.zeros((1, 2)), PAD)[0]),
        series=float(cells.capacitance(np.zeros((1, 2)), PAD, order=3)[0]),
    )


def agreements(
    layer: Layer | None = None,
    bodies: Sequence[tuple[str, Round]] = BODIES,
    loads: Sequence[float] = LOADS,
) -> list[Agreement]:
    """The paper's indenters and loads, as far as Hooke's law keeps them off the base."""
    soft = layer or Layer(2e-3, 100e3, 0.5)
    rows = []
    for name, body in bodies:
        for force in loads:
            try:
                rows.append(agree(soft, name, body, force))
            except InputError as error:
                if "sinks" not in str(error):
                    raise
    return rows


def agreement_table(rows: Sequence[Agreement]) -> Table:
    """The comparison as a table of the report."""
    columns = (
        "indenter", "force (N)", "depth, elements (mm)", "depth, lattice (mm)",
        "depth, exact (mm)", "base stress, lattice (relative L2)",
        "base stress, exact (relative L2)", "surface, lattice (relative L2)",
        "surface, exact (relative L2)", "base peak, lattice (relative error)",
        "ΔC/C₀, elements", "ΔC/C₀, lattice", "ΔC/C₀, series",
    )  # fmt: skip
    return Table(
        "agreement",
        "One press three ways; fields are compared with the finite elements",
        columns,
        tuple(
            (
                row.name, row.force, row.depth * 1e3, row.lattice.depth * 1e3,
                row.exact.depth * 1e3, row.lattice.base_error, row.exact.base_error,
                row.lattice.surface_error, row.exact.surface_error, row.lattice.peak_error,
                row.reading, row.field, row.series,
            )
            for row in rows
        ),
    )  # fmt: skip


def _beside(judge: AxisymmetricSolution, cells: Press) -> Answer:
    """Cells give the surface at their centres and the base anywhere."""
    line = np.column_stack([RADII, np.zeros_like(RADII)])
    base = cells.base_stress(line, 0.0)
    distance = np.linalg.norm(cells.grid.plane, axis=1)
    surface = judge.indentation(distance)
    miss = -cells.displacement[:, 2] - surface
    return Answer(
        depth=float(cells.approach[0]),
        base_error=_relative(base, judge.base_stress(RADII)),
        surface_error=float(np.linalg.norm(miss) / np.linalg.norm(surface)),
        peak_error=float(base[0] / judge.base_stress([0.0])[0] - 1),
    )


def _beside_exact(judge: AxisymmetricSolution, exact: Indentation) -> Answer:
    peak = _at(exact.base_stress, np.zeros(1))[0] / judge.base_stress([0.0])[0] - 1
    return Answer(
        depth=exact.depth,
        base_error=_relative(_at(exact.base_stress, RADII), judge.base_stress(RADII)),
        surface_error=_relative(_at(exact.indentation, RADII), judge.indentation(RADII)),
        peak_error=float(peak),
    )


def _at(function: Callable[[Floats], Floats], radius: Floats) -> Floats:
    return np.asarray(function(radius), dtype=float)


def _relative(found: Floats, judge: Floats) -> float:
    """Relative L2 over the plane, of values at RADII."""
    weight = np.sqrt(RADII)
    return float(np.linalg.norm(weight * (found - judge)) / np.linalg.norm(weight * judge))

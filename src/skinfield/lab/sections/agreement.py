"""Verification of the truth: the contact solver beside finite elements, and the half-space's error.

The lattice and the exact solution share the layer's transfer function; the finite elements share
nothing with either, so they are the judge. The paper's half-space is given the true pressure, so
that what is off is the model alone.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec

import numpy as np

from skinfield.elastic import HalfSpace, LatticeConvolution, Layer, Mechanics
from skinfield.elastic.axisymmetric import Ball, Indentation, indent_by_force, punch
from skinfield.elastic.lattice import lattice, mirrored
from skinfield.errors import Floats, InputError
from skinfield.lab.fem.electrostatics import pad_capacitance
from skinfield.lab.fem.small_strain import AxisymmetricSolution, indent
from skinfield.lab.paper import LOADS, TIPS
from skinfield.lab.plots import Curve, Panel, Scale, draw_panels
from skinfield.lab.report import (
    PAPER_LAYER,
    Missing,
    Picture,
    Section,
    Settings,
    Table,
    Verdict,
    spread_in_words,
)
from skinfield.simulate import Cylinder, Press, Sphere, press

Round = Sphere | Cylinder
BODIES: tuple[tuple[str, Round], ...] = tuple((tip.name, tip.body) for tip in TIPS)
FINEST = 0.01  # length of the smallest elements, in thicknesses
SMOKE_LOADS, SMOKE_FINEST = (0.5,), 0.03
PAD = 4e-3  # m; the pads' diameter
SPAN = 30e-3  # m: side of the square over which the half-space is compared; fields fall within 10 h
HALF_SPACE = HalfSpace(point_forces=False)  # of uniform cells: no error but the model's
LINEAR = 0.5  # of the thickness: deeper, linear elasticity itself is off by several per cent
RADII = np.linspace(0.0, 12e-3, 241)  # m; where fields are compared, weighted by area


@dataclass(frozen=True)
class Deviation:
    """One method beside the finite elements.

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
class ModelError:
    """Relative L2 errors of the half-space, given the true pressure of the layer.

    Parameters
    ----------
    stress, point_stress, displacement : float
        Of the base stress' mean below a pad, of that at a point, and of the surface's normal
        displacement.
    """

    stress: float
    point_stress: float
    displacement: float


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
    lattice, exact : Deviation
        `simulate.press`, and the integral equation for bodies of revolution.
    field, series : float
        ΔC/C₀ of the centred pad below the lattice's surface: of the field, and to third order.
    half_space : ModelError
    """

    name: str
    force: float
    depth: float
    contact_radius: float
    base_peak: float
    reading: float
    lattice: Deviation
    exact: Deviation
    field: float
    series: float
    half_space: ModelError


def agree(
    layer: Layer,
    name: str,
    body: Round,
    force: float,
    cell: float = 0.25e-3,
    finest: float = FINEST,
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
    cells = press(layer, [replace(body, force=force)], extent=body.radius * 2 + 4e-3, cell=cell)
    judge = indent(layer, lambda r: body.height(r, np.zeros_like(r)), force=force, finest=finest)
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
        lattice=_of_lattice(judge, cells),
        exact=_of_exact(judge, exact),
        field=float(cells.capacitance(np.zeros((1, 2)), PAD)[0]),
        series=float(cells.capacitance(np.zeros((1, 2)), PAD, order=3)[0]),
        half_space=half_space_error(cells),
    )


def half_space_error(cells: Press) -> ModelError:
    """Compare the half-space with the layer under the true pressure, on its own cells."""
    rows, columns = cells.grid.shape
    cell = cells.grid.pitch
    margin = max(round((SPAN / cell - rows) / 2), 0)
    pressure = np.pad(cells.pressure.reshape(rows, columns), margin)
    half = len(pressure) - 1
    offsets = lattice(half, half, cell)

    def error(quadrant: Callable[[Mechanics], Floats]) -> float:
        exact, wrong = (
            LatticeConvolution(mirrored(quadrant(model).reshape(half + 1, half + 1)))(pressure)
            for model in (cells.mechanics, HALF_SPACE)
        )
        return float(np.linalg.norm(wrong - exact) / np.linalg.norm(exact))

    return ModelError(
        stress=error(lambda model: model.base_stress(cells.layer, offsets, cell, PAD)),
        point_stress=error(lambda model: model.base_stress(cells.layer, offsets, cell, 0.0)),
        displacement=error(lambda model: model.indentation(cells.layer, offsets, cell)),
    )


def agreements(
    layer: Layer = PAPER_LAYER,
    bodies: Sequence[tuple[str, Round]] = BODIES,
    loads: Sequence[float] = LOADS,
    finest: float = FINEST,
) -> list[Agreement]:
    """The paper's indenters and loads, as far as Hooke's law keeps them off the base."""
    rows = []
    for name, body in bodies:
        for force in loads:
            try:
                rows.append(agree(layer, name, body, force, finest=finest))
            except InputError as error:
                if "sinks" not in str(error):
                    raise
    return rows


def agreement_table(rows: Sequence[Agreement]) -> Table:
    """The comparison as a table of the report."""
    cells = [
        {
            "indenter": row.name,
            "force (N)": row.force,
            "depth, elements (mm)": row.depth * 1e3,
            "depth, lattice (mm)": row.lattice.depth * 1e3,
            "depth, exact (mm)": row.exact.depth * 1e3,
            "base stress, lattice (relative L2)": row.lattice.base_error,
            "base stress, exact (relative L2)": row.exact.base_error,
            "surface, lattice (relative L2)": row.lattice.surface_error,
            "surface, exact (relative L2)": row.exact.surface_error,
            "base peak, lattice (relative error)": row.lattice.peak_error,
            "ΔC/C₀, elements": row.reading,
            "ΔC/C₀, lattice": row.field,
            "ΔC/C₀, series": row.series,
            "base stress below pads, half-space (relative L2)": row.half_space.stress,
            "base stress at a point, half-space (relative L2)": row.half_space.point_stress,
            "surface, half-space (relative L2)": row.half_space.displacement,
        }
        for row in rows
    ]
    caption = (
        "One press three ways, compared with the finite elements; the half-space with the layer "
        "under the same true pressure."
    )
    return Table.of("agreement", caption, cells)


def _of_lattice(judge: AxisymmetricSolution, cells: Press) -> Deviation:
    """Cells give the surface at their centres and the base anywhere."""
    line = np.column_stack([RADII, np.zeros_like(RADII)])
    base = cells.base_stress(line, 0.0)
    distance = np.linalg.norm(cells.grid.plane, axis=1)
    surface = judge.indentation(distance)
    miss = -cells.displacement[:, 2] - surface
    return Deviation(
        depth=float(cells.approach[0]),
        base_error=_relative(base, judge.base_stress(RADII)),
        surface_error=float(np.linalg.norm(miss) / np.linalg.norm(surface)),
        peak_error=float(base[0] / judge.base_stress([0.0])[0] - 1),
    )


def _of_exact(judge: AxisymmetricSolution, exact: Indentation) -> Deviation:
    peak = _at(exact.base_stress, np.zeros(1))[0] / judge.base_stress([0.0])[0] - 1
    return Deviation(
        depth=exact.depth,
        base_error=_relative(_at(exact.base_stress, RADII), judge.base_stress(RADII)),
        surface_error=_relative(_at(exact.indentation, RADII), judge.indentation(RADII)),
        peak_error=float(peak),
    )


def _at(function: Callable[[Floats], Floats], radius: Floats) -> Floats:
    return np.asarray(function(radius), dtype=float)


def _relative(values: Floats, judge: Floats) -> float:
    """Relative L2 over the plane, of values at RADII."""
    weight = np.sqrt(RADII)
    return float(np.linalg.norm(weight * (values - judge)) / np.linalg.norm(weight * judge))


def agreement(settings: Settings) -> Section | Missing:
    """How far the truth of all other sections is from finite elements, per indenter and load."""
    if find_spec("skfem") is None:
        return Missing(
            "agreement with finite elements: scikit-fem is not installed "
            "(pip install 'skinfield[lab]')"
        )
    if settings.size.name == "smoke":  # the wide cylinder takes longest
        rows = agreements(settings.layer, BODIES[:3], SMOKE_LOADS, SMOKE_FINEST)
    else:
        rows = agreements(settings.layer)
    linear = [row for row in rows if row.depth <= LINEAR * settings.layer.thickness]
    return Section(
        name="agreement",
        title="The truth and its judge, and what the half-space costs",
        claim="Simulations are compared with a commercial finite-element program; no numbers are "
        "given. The elastomer is treated as an elastic half-space, with displacements made to "
        "vanish at its base by subtraction; the error is not discussed.",
        sentences=(_sentence(rows), _half_space_sentence(linear)),
        pictures=(
            _picture(
                "errors", rows, "contact solver", lambda row: row.lattice,
                (("Base stress", "base_error"), ("Surface", "surface_error")),
            ),
            _picture(
                "half-space", rows, "half-space, from the true pressure,",
                lambda row: row.half_space,
                (("Base stress below pads", "stress"), ("Normal displacement", "displacement")),
            ),
        ),
        tables=(agreement_table(rows),),
        verdicts=(
            Verdict(
                "truth",
                "a finite-element program is the reference",
                f"contact solver off by at most {_worst(rows, 'base_error')} of base stress, "
                f"{_worst(rows, 'surface_error')} of the surface (relative L2)",
                "holds without it, up to linear elasticity",
            ),
            Verdict(
                "model",
                "the layer behaves as a half-space",
                f"base stress off by {_half_space(linear, 'stress')}, displacement by "
                f"{_half_space(linear, 'displacement')} (relative L2, true pressure given)",
                "does not hold",
            ),
        ),
    )  # fmt: skip


def _half_space(rows: list[Agreement], name: str) -> str:
    return spread_in_words([getattr(row.half_space, name) for row in rows], "%", 100)


def _half_space_sentence(rows: list[Agreement]) -> str:
    return (
        "Given the true pressure, and up to half the thickness deep, where linear elasticity can "
        f"be trusted, the half-space's mean stress below a pad is off by "
        f"{_half_space(rows, 'stress')} (at a point by {_half_space(rows, 'point_stress')}), its "
        f"displacement, corrected as in (17), by {_half_space(rows, 'displacement')}."
    )


def _worst(rows: list[Agreement], name: str) -> str:
    return f"{100 * max(getattr(row.lattice, name) for row in rows):.2g} %"


def _sentence(rows: list[Agreement]) -> str:
    lattice = [row.lattice for row in rows]
    exact = [row.exact for row in rows]
    depth = [abs(row.lattice.depth / row.depth - 1) for row in rows]
    field = [abs(row.field / row.reading - 1) for row in rows]
    series = [abs(row.series / row.reading - 1) for row in rows]
    return (
        f"{len(rows)} presses, solved three ways: on cells with the layer's Green's function, as "
        "everywhere in this report; by an integral equation for bodies of revolution; and by "
        "mixed finite elements that share no code with either. Against the elements the cells are "
        f"off by {spread_in_words([a.base_error for a in lattice], '%', 100)} of base stress, "
        f"{spread_in_words([a.surface_error for a in lattice], '%', 100)} of the surface and "
        f"{spread_in_words(depth, '%', 100)} of depth; the integral equation by "
        f"{spread_in_words([a.base_error for a in exact], '%', 100)} and "
        f"{spread_in_words([a.surface_error for a in exact], '%', 100)}. A centred pad's "
        f"capacitance is {spread_in_words(field, '%', 100)} off what elements find for Laplace's "
        "equation in the deformed gap, and to third order of its series "
        f"{spread_in_words(series, '%', 100)}."
    )


def _picture(
    name: str,
    rows: list[Agreement],
    who: str,
    errors: Callable[[Agreement], Deviation | ModelError],
    measures: Sequence[tuple[str, str]],
) -> Picture:
    """Errors by indenter and load, a panel per measure (title, field)."""
    scale = Scale(
        x="load (N)", y="relative L2 (%)", log_x=True, log_y=True, x_ticks=LOADS,
        x_limits=(0.17, 3.5), marks=True,
    )  # fmt: skip
    panels = []
    for title, field in measures:
        curves = []
        for body, _ in BODIES:
            mine = [row for row in rows if row.name == body]
            x = np.array([row.force for row in mine])
            y = np.array([100 * getattr(errors(row), field) for row in mine])
            curves.append(Curve(body, x, y))
        panels.append(Panel(title, "", tuple(curves), scale))
    judge = "the layer" if name == "half-space" else "finite elements"
    caption = f"Error of the {who} against {judge}, by indenter and load."
    return Picture.of(name, caption, draw_panels([panels]))

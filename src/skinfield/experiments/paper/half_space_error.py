"""What the half-space in place of the layer costs at the paper's loads, before any inversion."""

from dataclasses import dataclass

import numpy as np

from skinfield.errors import Floats
from skinfield.experiments.paper.presses import BALL, LOADS, TIPS, Tip, paper_patch
from skinfield.experiments.section import Picture, Section, Table, Verdict
from skinfield.experiments.settings import Settings
from skinfield.experiments.words import png_of, spread_in_words
from skinfield.figures.panels import Line, Panel, Scale, draw_panels
from skinfield.mechanics import HalfSpace, LatticeConvolution, Layer, Mechanics
from skinfield.mechanics.lattice import lattice, mirrored
from skinfield.simulate import Press, Sphere

SPAN = 30e-3  # m: side of the square over which fields are compared; they fall within 10 h
EXACT = HalfSpace(point_forces=False)  # of the cells' uniform pressure: no error but the model's
LINEAR = 0.5  # of the thickness: deeper, linear elasticity itself is off by several per cent


@dataclass(frozen=True)
class Error:
    """Of the half-space at one load, from the true pressure of the layer.

    Parameters
    ----------
    tip, force : N
    depth, half_space_depth : float, m
        Of the tip's lowest point: by the layer, and by the half-space's own contact (NaN where
        Hertz and the flat punch do not say).
    stress, point_stress, displacement : float
        Relative L2 error of the base stress' mean below a pad, of that at a point, and of the
        surface's normal displacement.
    stress_peak, displacement_peak : float
        Relative error of the highest value.
    """

    tip: Tip
    force: float
    depth: float
    half_space_depth: float
    stress: float
    stress_peak: float
    point_stress: float
    displacement: float
    displacement_peak: float


def half_space_error(settings: Settings) -> Section:
    """Errors of stress, displacement and depth at the paper's loads."""
    errors = [
        error_of(tip, force, settings.layer, solved)
        for tip in TIPS
        for force in LOADS
        if (solved := tip.pressed(settings.layer, force, settings.size.cell)) is not None
    ]
    linear = [error for error in errors if error.depth <= LINEAR * settings.layer.thickness]
    return Section(
        name="half-space",
        title="What the half-space costs",
        claim="The elastomer is treated as an elastic half-space, with displacements made to "
        "vanish at its base by subtraction; the error is not discussed.",
        sentences=tuple(_sentences(errors, linear, settings)),
        pictures=(_picture(errors),),
        tables=(_table(errors),),
        verdicts=(
            Verdict(
                "model",
                "the layer behaves as a half-space",
                f"base stress off by {_ends(linear, 'stress')}, displacement by "
                f"{_ends(linear, 'displacement')} (relative L2, true pressure given)",
                "does not hold",
            ),
        ),
    )


def error_of(tip: Tip, force: float, layer: Layer, solved: Press) -> Error:
    """Compare both models under one true pressure, on its own cells."""
    pressure, cell = widened(solved, SPAN), solved.grid.pitch
    models, pad = (solved.mechanics, EXACT), paper_patch().pad_diameter
    stress = [_stress(model, layer, pressure, cell, pad) for model in models]
    point = [_stress(model, layer, pressure, cell, 0.0) for model in models]
    sunk = [_sunk(model, layer, pressure, cell) for model in models]
    return Error(
        tip,
        force,
        float(solved.approach[0]),
        depth_on_half_space(tip, force, layer),
        relative_l2(stress[1], stress[0]),
        float(stress[1].max() / stress[0].max()) - 1,
        relative_l2(point[1], point[0]),
        relative_l2(sunk[1], sunk[0]),
        float(sunk[1].max() / sunk[0].max()) - 1,
    )


def widened(solved: Press, span: float) -> Floats:
    """Pressure (n, n) of a press on a square of side `span` m with the same cells, 0 around it."""
    rows, columns = solved.grid.shape
    margin = max(round((span / solved.grid.pitch - rows) / 2), 0)
    return np.pad(solved.pressure.reshape(rows, columns), margin)


def _stress(
    mechanics: Mechanics, layer: Layer, pressure: Floats, cell: float, pad: float
) -> Floats:
    """Base stress below pads of a diameter in m, at each cell (n, n), Pa."""
    half = len(pressure) - 1
    offsets = lattice(half, half, cell)
    quadrant = mechanics.base_stress(layer, offsets, cell, pad)
    return LatticeConvolution(mirrored(quadrant.reshape(half + 1, half + 1)))(pressure)


def _sunk(mechanics: Mechanics, layer: Layer, pressure: Floats, cell: float) -> Floats:
    """Normal displacement of the surface at each cell (n, n), m, inwards."""
    half = len(pressure) - 1
    quadrant = mechanics.indentation(layer, lattice(half, half, cell), cell)
    return LatticeConvolution(mirrored(quadrant.reshape(half + 1, half + 1)))(pressure)


def relative_l2(found: Floats, true: Floats) -> float:
    """Norm of the difference over that of the truth."""
    return float(np.linalg.norm(found - true) / np.linalg.norm(true))


def depth_on_half_space(tip: Tip, force: float, layer: Layer) -> float:
    """Depth in m that contact on a half-space would have: Hertz (1882), flat punch (Boussinesq)."""
    modulus = layer.young_modulus / (1 - layer.poisson_ratio**2)
    radius = tip.body.radius
    if isinstance(tip.body, Sphere):
        return float((9 * force**2 / (16 * radius * modulus**2)) ** (1 / 3))
    return force / (2 * radius * modulus)


def _ends(errors: list[Error], name: str) -> str:
    return spread_in_words([abs(getattr(error, name)) for error in errors], "%", 100.0)


def _sentences(errors: list[Error], linear: list[Error], settings: Settings) -> list[str]:
    ball = next(e for e in errors if e.tip is BALL and e.force == 1.8)
    missing = [
        f"{tip.name} at {force:g} N"
        for tip in TIPS
        for force in LOADS
        if not any(error.tip is tip and error.force == force for error in errors)
    ]
    thickness = settings.layer.thickness
    found = [
        "The true pressure of each press, from the contact solver on the bonded layer, is given to "
        "both models; what differs is the model alone. Up to half the thickness deep, where linear "
        f"elasticity can be trusted, the half-space's mean stress below a pad is off by "
        f"{_ends(linear, 'stress')} (at a point by {_ends(linear, 'point_stress')}), its peak by "
        f"{_ends(linear, 'stress_peak')}; its "
        f"displacement, corrected as in (17), by {_ends(linear, 'displacement')}.",
        f"The half-sphere of 1.2 cm under 1.8 N goes {ball.depth * 1e3:.2f} mm into the layer; on "
        f"a half-space Hertz has {ball.half_space_depth * 1e3:.2f} mm, in a layer of "
        f"{thickness * 1e3:g} mm.",
    ]
    if missing:
        found.append(
            f"Left out: {', '.join(missing)}, which by linear elasticity would go through the "
            f"layer of {thickness * 1e3:g} mm."
        )
    return found


def _picture(errors: list[Error]) -> Picture:
    panels = []
    for title, name, note in (
        ("Base stress below pads", "stress", "from the true pressure"),
        ("Normal displacement", "displacement", "from the true pressure, eq. (17)"),
    ):
        lines = []
        for tip in TIPS:
            mine = [error for error in errors if error.tip is tip]
            x = np.array([error.force for error in mine])
            y = np.array([100 * getattr(error, name) for error in mine])
            lines.append(Line(tip.name, x, y))
        panels.append(Panel(title, note, tuple(lines)))
    scale = Scale(
        x="load (N)",
        y="relative L2 error of the half-space (%)",
        log_x=True,
        y_limits=(0.0, None),
        x_ticks=LOADS,
    )
    caption = "Error of the half-space against the bonded layer under the same true pressure."
    return Picture("errors", caption, png_of(draw_panels(panels, scale, columns=2)))


def _table(errors: list[Error]) -> Table:
    columns = (
        "indenter",
        "load (N)",
        "depth (mm)",
        "depth on a half-space (mm)",
        "stress, relative L2 (%)",
        "stress, peak (%)",
        "stress at a point, relative L2 (%)",
        "displacement, relative L2 (%)",
        "displacement, peak (%)",
    )
    rows = tuple(
        (
            error.tip.name,
            error.force,
            1e3 * error.depth,
            1e3 * error.half_space_depth,
            100 * error.stress,
            100 * error.stress_peak,
            100 * error.point_stress,
            100 * error.displacement,
            100 * error.displacement_peak,
        )
        for error in errors
    )
    caption = (
        "The half-space against the bonded layer. Depth on a half-space is that of its own contact "
        "(Hertz, flat punch), the other errors are under the layer's pressure."
    )
    return Table("errors", caption, columns, rows)

"""Figure of a simulated press: pressure, stress at the base, a section, and readings of it."""

from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import Floats, check_shape
from skinfield.plot import (
    BLUE,
    FAINT,
    INK,
    QUIET,
    TITLE,
    add_colour_bar,
    add_title,
    new_figure,
    number,
    plural,
    style,
)
from skinfield.simulate import Press
from skinfield.skin import Patch
from skinfield.skin.maps import MM, draw_cells, draw_pads, extent_of_pads, frame_axes, outline_pads

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

AROUND = 2.5  # layer thicknesses shown around the contact
FINE = 800  # points of an indenter's outline in the section
NAMED = 3  # indenters in the heading


def draw_press(
    press: Press,
    patch: Patch | None = None,
    readings: Floats | None = None,
    *,
    label: str = "ΔC/C₀ (%)",
) -> "Figure":
    """Figure of a press: maps of pressure and base stress, a section, and a patch's readings.

    Parameters
    ----------
    press : Press
    patch : Patch, optional
        Its pads are outlined, and coloured by their readings. Without one the fourth panel shows
        the depth of the surface.
    readings : (L,) array, optional
        Of the patch's taxels. Default ΔC/C₀ in percent.
    label : str
        Of the readings, with their unit.

    Raises
    ------
    InputError
        If the readings are not one per taxel.
    """
    view, depth = _view(press), -press.displacement[:, 2]
    with style():
        figure = new_figure(9.6, 8.0)
        figure.text(0.07, 0.968, heading(press), va="center", **TITLE)
        upper, lower = 0.545, 0.075
        boxes = [(0.07, upper, 0.33, 0.35), (0.56, upper, 0.33, 0.35), (0.56, lower, 0.33, 0.35)]
        axes = [figure.add_axes(box) for box in boxes]
        _field(axes[0], press, press.pressure / 1e3, view, "pressure (kPa)")
        peak, area = number(press.pressure.max() / 1e3), number(press.contact_area * MM**2)
        note = f"peak {peak} kPa, contact {area} mm²; dotted: section C"
        add_title(axes[0], "A", "Pressure on the skin", note)
        _field(axes[1], press, press.base_stress_below_cells / 1e3, view, "base stress (kPa)")
        add_title(axes[1], "B", "Stress at the base", "normal, positive in compression")
        if patch is None:
            _field(axes[2], press, depth * MM, view, "indentation (mm)")
            add_title(axes[2], "D", "Depth of the surface", "below its place at rest")
        else:
            outline_pads(axes[1], patch)
            _readings(axes[2], press, patch, readings, label)
        _section(figure.add_axes((0.07, lower, 0.33, 0.35)), press, depth, view)
    return figure


def heading(press: Press) -> str:
    """Words for indenters and layer, on one line."""
    forces = [number(float(f"{force:.3g}")) for force in [*press.forces, press.force]]
    if len(press.indenters) <= NAMED:
        each = zip(press.indenters, forces, strict=False)
        bodies = ", ".join(f"{body.kind} {force} N" for body, force in each)
    else:
        bodies = f"{len(press.indenters)} indenters, {forces[-1]} N"
    layer = press.layer
    return (
        f"{bodies} on {number(layer.thickness * MM)} mm of {number(layer.young_modulus / 1e3)} kPa"
    )


def _view(press: Press) -> Floats:
    """Low and high corner (2, 2) m of what is drawn, the same side along x and y."""
    touched = press.grid.plane[press.contact]
    low, high = touched.min(axis=0), touched.max(axis=0)
    middle = (low + high) / 2
    half = float((high - low).max()) / 2 + AROUND * press.layer.thickness
    edge_low = press.grid.plane.min(axis=0) - press.grid.pitch / 2
    edge_high = press.grid.plane.max(axis=0) + press.grid.pitch / 2
    half = min(half, float((edge_high - edge_low).min()) / 2)
    middle = np.clip(middle, edge_low + half, edge_high - half)
    return np.stack([middle - half, middle + half])


def _field(axes: "Axes", press: Press, values: Floats, view: Floats, label: str) -> None:
    """Draw values (K,) of the cells, the outlines of touch, and the section's line."""
    add_colour_bar(axes, draw_cells(axes, press.grid, values), label)
    _outline(axes, press)
    axes.axhline(_section_place(press) * MM, color=QUIET, lw=0.8, ls=(0, (1, 2)))
    frame_axes(axes, press.grid.patch, view)


def _outline(axes: "Axes", press: Press) -> None:
    for outline in press.outline:
        axes.plot(*(outline.T * MM), color=INK, lw=0.8)


def _section_place(press: Press) -> float:
    """The y (m) of the section: the row of cells nearest to where the strongest body presses."""
    y, strongest = press.grid.plane[:, 1], int(np.argmax(press.forces))
    pressure = press.pressure_by_body[strongest]
    centre = float(pressure @ y / pressure.sum())
    touched = y[pressure > 0]
    return float(touched[np.abs(touched - centre).argmin()])


def _section(axes: "Axes", press: Press, depth: Floats, view: Floats) -> None:
    """Draw layer and indenters cut along x; heights are exaggerated to fill the panel."""
    place, thick = _section_place(press), press.layer.thickness * MM
    row = np.abs(press.grid.plane[:, 1] - place) < press.grid.pitch / 2
    x, sideways = press.grid.plane[row, 0], press.displacement[row, 0]
    top = max(0.45 * thick, 0.6 * float(press.approach.max()) * MM)
    axes.fill_between(
        (x + sideways) * MM, -thick, -depth[row] * MM, color="#f2e3cf", lw=0.0, zorder=1
    )
    axes.plot((x + sideways) * MM, -depth[row] * MM, color=INK, lw=1.2, zorder=3)
    axes.axhline(0.0, color=QUIET, lw=0.7, ls=(0, (1, 2)), zorder=0.5)
    axes.fill_between([-1e4, 1e4], -1.15 * thick, -thick, color="#9c9ca6", lw=0.0, zorder=2)
    fine = np.linspace(view[0, 0], view[1, 0], FINE)
    moved = zip(press.indenters, press.approach.tolist(), press.translation.tolist(), strict=True)
    for body, deep, (right, ahead) in moved:
        under = (body.height(fine - right, np.full(FINE, place - ahead)) - deep) * MM
        under = np.where(under < 2 * top, under, np.nan)
        axes.fill_between(fine * MM, under, 2 * top, color=BLUE, alpha=0.25, lw=0.0, zorder=2)
        axes.plot(fine * MM, under, color=BLUE, lw=1.0, zorder=2.5)
    axes.set(xlim=view[:, 0] * MM, ylim=(-1.15 * thick, top))
    axes.set(xlabel="x (mm)", ylabel="height over the skin at rest (mm)")
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.spines["left"].set_color(FAINT)
    add_title(axes, "C", "Section through the contact", _section_note(axes, press))


def _section_note(axes: "Axes", press: Press) -> str:
    figure: Any = axes.figure
    box = axes.get_position()
    width, height = figure.get_size_inches() * [box.width, box.height]
    wide, high = np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())
    factor = float((height / high) / (width / wide))
    place = number(_section_place(press) * MM)
    return f"at y = {place} mm; indenters blue; heights drawn {number(factor, 2)} times"


def _readings(
    axes: "Axes", press: Press, patch: Patch, readings: Floats | None, label: str
) -> None:
    if readings is None:
        readings = press.readings(patch.plane, patch.pad_diameter, "capacitance") * 100.0
    check_shape("readings", readings, (len(patch),), "one per taxel of the patch")
    pads = draw_pads(axes, patch, readings)
    _outline(axes, press)
    frame_axes(axes, patch, extent_of_pads(patch))
    add_colour_bar(axes, pads, label)
    add_title(axes, "D", "What the taxels read", f"{plural(len(patch), 'taxel')}, without noise")

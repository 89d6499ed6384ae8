"""One reading and what it means: raw, pressure, deformation, contacts."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, InputError, as_floats, check_shape
from skinfield.fields import Estimate
from skinfield.figures.deformation import draw_deformation
from skinfield.figures.maps import draw_cells, draw_pads, extent_of, frame_axes, hatch_uncovered
from skinfield.figures.marks import draw_contacts, draw_presses
from skinfield.figures.page import Page, page_of
from skinfield.figures.presses import Press, presses_from_truth
from skinfield.figures.style import (
    TITLE,
    add_colour_bar,
    add_title,
    new_figure,
    number,
    plural,
    style,
)
from skinfield.figures.table import draw_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FACTOR = {"%": 100.0, "kPa": 1e-3}  # from the unit of the readings to the one shown


def draw_estimate(
    estimate: Estimate,
    readings: ArrayLike | None = None,
    *,
    truth: Iterable[tuple[Any, Any, float]] | None = None,
    quantity_name: str = "ΔC/C₀",
    quantity_unit: str = "%",
    title: str | None = None,
) -> "Figure":
    """Figure of one reading: the taxels, the pressure, the deformation and the contacts.

    Parameters
    ----------
    estimate : Estimate
        Of one reading; of a batch, pick one: ``estimate[index]``.
    readings : (L,) array, optional
        What the taxels read, in the quantity's SI unit; NaN is drawn as an invalid taxel. Without
        it the first panel shows the residual of the estimate.
    truth : sequence of (position, force, radius), optional
        What was truly pressed: position (3,) m, or (2,) m in the patch's plane; force in N, or as
        a vector (3,) N; radius in m.
    quantity_name, quantity_unit : str
        What the taxels read, and the unit it is shown in: "%" shows fractions times 100, "kPa"
        shows pascals over 1000, and any other unit is the readings' own ("1" is left unsaid).
    title : str, optional
        Over the figure; by default the patch, its contacts and their force.

    Returns
    -------
    matplotlib Figure
        1536 pixels wide, and as high as the patch asks for, 1024 at most; `save` writes it.

    Raises
    ------
    InputError
        If `estimate` is of many readings, or `readings` is not one number per taxel.
    """
    check_single(estimate)
    values, name = _shown_readings(estimate, readings)
    presses = presses_from_truth(truth, estimate.grid)
    with style():
        page = page_of(estimate.grid)
        figure = new_figure(*page.size)
        words = title or headline(estimate)
        figure.text(0.02, 1 - 0.22 / page.size[1], words, va="center", **TITLE)
        unit = "" if quantity_unit == "1" else f" ({quantity_unit})"
        _draw_readings(
            figure.add_axes(page.readings),
            estimate,
            values * FACTOR.get(quantity_unit, 1.0),
            f"{quantity_name}{unit}",
            name,
        )
        _draw_pressure(figure.add_axes(page.pressure), estimate, presses)
        _draw_surface(figure, page, estimate)
        panel = figure.add_axes(page.contacts)
        add_title(
            panel, "d", "Contacts", "in the frame of the patch; force ± one standard deviation"
        )
        draw_table(panel, estimate, presses)
    return figure


def check_single(estimate: Estimate) -> None:
    """Raise InputError, naming the reading of the highest load, unless it is of one reading."""
    if estimate.is_batch:
        load = np.nan_to_num(estimate.normal_force, nan=-np.inf)
        best = int(load.argmax()) if len(load) else 0
        raise InputError(
            f"estimate holds {plural(len(estimate), 'reading')}, expected one: pick it by index, "
            f"estimate[{best}] has the highest load"
        )


def headline(estimate: Estimate) -> str:
    """Name of the patch, number of contacts and their force."""
    name, contacts = estimate.grid.patch.name, estimate.contacts
    if not contacts:
        return f"{name}: no contact"
    force = number(sum(contact.normal_force for contact in contacts))
    return f"{name}: {plural(len(contacts), 'contact')}, {force} N"


def _shown_readings(estimate: Estimate, readings: ArrayLike | None) -> tuple[Floats, str]:
    if readings is None:
        return np.where(estimate.valid, estimate.residual, np.nan), "Residual"
    values = as_floats("readings", readings)
    check_shape("readings", values, (len(estimate.grid.patch),), "one number per taxel")
    return np.where(estimate.valid & np.isfinite(values), values, np.nan), "Raw reading"


def _draw_readings(axes: "Axes", estimate: Estimate, values: Floats, label: str, name: str) -> None:
    pads = draw_pads(axes, estimate.grid.patch, values)
    frame_axes(axes, estimate.grid.patch, extent_of(estimate.grid, measured=True))
    if np.isfinite(values).any():
        add_colour_bar(axes, pads, label)
    left_out = int((~np.isfinite(values)).sum())
    note = "pads to scale" + (f"; crossed: {left_out} left out" if left_out else "")
    add_title(axes, "a", name, note)


def _draw_pressure(axes: "Axes", estimate: Estimate, presses: list[Press]) -> None:
    grid = estimate.grid
    draw_cells(axes, grid, estimate.pressure * 1e-3, "pressure (kPa)")
    hatch_uncovered(axes, grid)
    frame_axes(axes, grid.patch, extent_of(grid, measured=True))
    draw_presses(axes, grid, presses)
    draw_contacts(axes, grid, estimate.contacts)
    notes = ["line: contact"] if estimate.contacts else []
    notes += ["dashed: truth"] if presses else []
    notes += [] if grid.covered.all() else ["hatched: outside the taxels"]
    add_title(axes, "b", "Pressure", "; ".join(notes))


def _draw_surface(figure: "Figure", page: Page, estimate: Estimate) -> None:
    axes: Any = figure.add_axes(page.deformation, projection="3d")
    factor = draw_deformation(figure, axes, estimate)
    note = "true to scale" if factor == 1 else f"indentation drawn {factor:g} times larger"
    heading = figure.add_axes(page.heading)
    heading.axis("off")
    add_title(heading, "c", "Deformation", note)

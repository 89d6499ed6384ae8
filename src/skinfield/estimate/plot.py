"""Figure of an estimate: readings, pressure, contacts beside the true presses, and the surface."""

from collections.abc import Iterable, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from skinfield.errors import Floats, InputError, as_floats, check_finite, check_shape, check_type
from skinfield.estimate import Contact, Estimate
from skinfield.estimate.deformation_plot import draw_deformation
from skinfield.estimate.developed_plane import Chart
from skinfield.plot import (
    BLUE,
    FAINT,
    INK,
    QUIET,
    TITLE,
    Place,
    add_colour_bar,
    add_title,
    axes_for,
    duration,
    new_figure,
    number,
    open_axes,
    plural,
    plus_minus,
    style,
)
from skinfield.skin import Grid
from skinfield.skin.maps import (
    MM,
    draw_cells,
    draw_pads,
    extent_of,
    frame_axes,
    hatch_uncovered,
    outline_pads,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class TruePress(NamedTuple):
    """A true press: where (3,) m, how hard N along the skin's normal, and over which radius m."""

    position: Floats
    force: float
    radius: float


def presses_from_truth(
    truth: Iterable[tuple[Any, Any, float]] | None, grid: Grid
) -> list[TruePress]:
    """Presses from (position, force, radius).

    A position is (3,) m, or (2,) m in the patch's plane; a force is in N along the inward normal;
    a radius is in m.

    Raises
    ------
    InputError
        If it is no sequence, or an entry is anything else.
    """
    presses: list[TruePress] = []
    if truth is None:
        return presses
    check_type("truth", truth, Iterable, "of presses, each (position, force, radius)")
    for row, entry in enumerate(truth):
        try:
            place, force, radius = entry
            position = as_floats(f"truth[{row}] position", place)
            check_finite(f"truth[{row}]", np.array([*position, force, radius], float), "a press")
            check_shape("position", position, (3 if len(position) == 3 else 2,), "in metres")
        except (TypeError, ValueError) as error:
            raise InputError(
                f"truth[{row}] is {entry!r} ({error}), expected (position, force, radius): (2,) or "
                "(3,) m, N and m"
            ) from error
        if len(position) == 2:
            position = grid.patch.surface.position_from_plane(position[None])[0]
        presses.append(TruePress(position, float(force), float(radius)))
    return presses


DIRECTIONS = [(0, 1), (0, -1), (1, 0), (-1, 0), (0.7, 0.8), (-0.7, 0.8), (0.7, -0.8), (-0.7, -0.8)]


def draw_contacts(
    axes: "Axes", grid: Grid, contacts: Sequence[Contact], words: Sequence[str] | None = None
) -> None:
    """Draw outline, centre and words, else the number, of each contact; once limits are set."""
    from matplotlib.patheffects import withStroke

    halo = [withStroke(linewidth=2.6, foreground="white")]
    for contact in contacts:
        outline = Chart(grid).plane_from_position(contact.outline) * MM
        axes.plot(*outline.T, color=INK, lw=1.2, path_effects=halo, zorder=3)
        centre = Chart(grid).plane_from_position(contact.position[None])[0] * MM
        axes.plot(*centre, "+", color=INK, ms=7, mew=1.3, path_effects=halo, zorder=4)
    numbers = [f"{index + 1}" for index in range(len(contacts))]
    _label_contacts(axes, grid, contacts, numbers if words is None else words)


def _label_contacts(
    axes: "Axes", grid: Grid, contacts: Sequence[Contact], words: Sequence[str]
) -> None:
    """Write words of each contact where there is room beside it."""
    from matplotlib.patheffects import withStroke
    from matplotlib.transforms import Bbox

    axes.apply_aspect()
    inside, bodies = axes.get_window_extent(), []
    halo: list[Any] = [withStroke(linewidth=2.2, foreground="white")]
    for contact in contacts:
        points = np.vstack([contact.outline, contact.position[None]])
        pixels = axes.transData.transform(Chart(grid).plane_from_position(points) * MM)
        bodies.append(Bbox(np.array([pixels.min(axis=0), pixels.max(axis=0)])).padded(4.0))
    taken = list(bodies)
    for index, body in enumerate(bodies):
        text = axes.text(0.0, 0.0, words[index], fontsize=8, ha="center", va="center", zorder=6)
        text.set_path_effects(halo if len(words[index]) > 2 else [])
        half = np.ptp(text.get_window_extent().get_points(), axis=0) / 2
        low, high = body.get_points()
        middle, reach = (low + high) / 2, (high - low) / 2 + np.maximum(half + 4.0, (9.0, 15.0))
        for far, way in product((1.0, 1.25, 1.6), np.array(DIRECTIONS)):
            x, y = axes.transData.inverted().transform(middle + far * reach * way)
            text.set_position((float(x), float(y)))
            box = text.get_window_extent().padded(3.0)
            first, last = box.get_points() - inside.get_points()
            free = not any(box.overlaps(other) for other in taken)
            if free and (first > 0).all() and (last < 0).all():
                taken.append(box)
                break
        else:
            text.remove()


WIDTH, HEAD = 9.6, 0.83  # inches: of the page, and from its top to the upper maps


def page_of(grid: Grid) -> tuple[tuple[float, float], dict[str, tuple[float, float, float, float]]]:
    """Size in inches of a page that suits the shape of what is shown, and boxes in parts of it."""
    width, height = np.ptp(extent_of(grid, measured=True), axis=0)
    high = float(np.clip(3.2 * height / width, 1.05, 2.46))
    size = (WIDTH, 3.1 + high + HEAD)
    boxes = {
        "readings": (0.67, 3.1, 3.2, high),
        "pressure": (5.47, 3.1, 3.2, high),
        "deformation": (0.3, 0.42, 3.8, 1.7),
        "contacts": (5.47, 0.0, 4.05, 2.14),
        "heading": (0.67, 0.0, 3.4, 2.14),  # the deformation's own box has no fixed edge
    }
    page = np.array([*size, *size])
    return size, {name: tuple(np.array(box) / page) for name, box in boxes.items()}


COLUMNS = {"": 0.0, "place (mm)": 0.07, "force (N)": 0.45, "area (mm²)": 0.66, "peak (kPa)": 0.85}
RELATIVE = {"force (N)": "force (rel.)", "peak (kPa)": "peak (rel.)"}
LINES, STEP = 11, 0.0876  # of the table, and from one to the next in parts of its height


def draw_table(axes: "Axes", estimate: Estimate, presses: Sequence[TruePress]) -> None:
    """Write contacts, their sum, the truth where it is known, and how the estimate was made."""
    axes.set(xlim=(0, 1), ylim=(0, 1))
    axes.axis("off")
    grid, contacts, notes = estimate.grid, list(estimate.contacts), facts(estimate)
    room = LINES - len(notes) - 3 - bool(presses)
    truths = len(presses) if len(presses) + min(len(contacts), 2) <= room else 0
    room = max(room - truths, 2)
    listed = contacts if len(contacts) <= room else contacts[: room - 1]
    rest = contacts[len(listed) :]
    quiet, true = {"color": QUIET}, {"color": BLUE}
    rule: tuple[list[str], dict[str, Any]] = ([], {})
    heads = [RELATIVE.get(head, head) if estimate.relative else head for head in COLUMNS]
    rows: list[tuple[list[str], dict[str, Any]]] = [(heads, quiet), rule]
    rows += [(row_of(index, contact, grid), {}) for index, contact in enumerate(listed)]
    rows += [] if contacts else [(["no contact above the noise"], quiet)]
    rows += [(["", plural(len(rest), "other"), *_sums(rest), ""], quiet)] if rest else []
    rows.append(rule)
    bold = {"fontweight": "bold"}
    rows += [(["", "all contacts", *_sums(contacts), ""], bold)] if contacts else []
    for press in presses[:truths]:
        area = number(np.pi * press.radius**2 * 1e6)
        words = ["true", place_of(press.position, grid), number(press.force), area, ""]
        rows.append((words, true))
    rows += [([truth_note(presses, contacts)], true)] if presses else []
    rows += [([note], quiet) for note in notes]
    y = 1.0
    for words, look in rows:
        if not words:
            axes.plot([0, 1], [y, y], color=FAINT, lw=0.8, clip_on=False)
            continue
        font = 8.5 if len(words) > 1 else 8.0  # running text
        for x, word in zip(COLUMNS.values(), words, strict=False):
            axes.text(x, y - STEP / 2, word, va="center", fontsize=font, **look)
        y -= STEP


def _sums(contacts: list[Contact]) -> tuple[str, str]:
    force, area = sum(c.normal_force for c in contacts), sum(c.area for c in contacts)
    return number(force), number(area * 1e6)


def row_of(index: int, contact: Contact, grid: Grid) -> list[str]:
    """Cells of the table for one contact."""
    return [
        f"{index + 1}",
        place_of(contact.position, grid),
        plus_minus(contact.normal_force, contact.force_std),
        number(contact.area * 1e6),
        number(contact.peak_pressure * 1e-3),
    ]


def place_of(position: Floats, grid: Grid) -> str:
    """Coordinates in mm; two where the patch lies in z = 0."""
    flat = np.allclose(grid.patch.positions[:, 2], 0.0)
    return ", ".join(f"{x * MM:.1f}".replace("-", "−") for x in position[: 2 if flat else 3])


def truth_note(presses: Sequence[TruePress], contacts: Sequence[Contact]) -> str:
    """Say how far the contacts nearest to the true presses are from them, at worst."""
    if not contacts:
        return "truth: no contact found"
    pairs = []
    for press in presses:
        apart = [float(np.linalg.norm(c.position - press.position)) for c in contacts]
        pairs.append((press, contacts[int(np.argmin(apart))], min(apart)))
    changes = [(c.normal_force / p.force - 1) * 100 for p, c, _ in pairs if p.force]
    change = max(changes, key=abs, default=float("nan"))
    distance = max(apart for _, _, apart in pairs) * MM
    worst = ", at worst" if len(pairs) > 1 else ""
    sign = "+" if change >= 0 else ""
    force, place = number(change, 2), number(distance, 2)
    return f"off the truth by {sign}{force} % of force, {place} mm of place{worst}"


def facts(estimate: Estimate) -> list[str]:
    """Sum of a field that answered, and how the estimate was made, in short lines."""
    grid = estimate.grid
    rows, columns = grid.shape
    std = estimate.pressure_std[grid.covered] if grid.covered.any() else estimate.pressure_std
    spread = float(np.nanmedian(std)) if np.isfinite(std).any() else np.nan
    last = [f"{columns} × {rows} cells of {number(grid.pitch * MM)} mm"]
    if np.isfinite(spread) and spread > 0.0:  # contacts that are fitted have none beside them
        last.append(f"σ of pressure {number(spread * 1e-3, 2)} kPa")
    if np.isfinite(estimate.latency):
        last.append(duration(estimate.latency))
    unit = "relative" if estimate.relative else "N"
    total = number(float(estimate.normal_force))
    whole = f"whole field {total} {unit}; " if estimate.is_field else ""
    return [
        f"{whole}{int(estimate.valid.sum())} of {plural(len(estimate.valid), 'taxel')} used",
        "; ".join(last),
    ]


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
        What was truly pressed: position (3,) m, or (2,) m in the patch's plane; force in N; radius
        in m.
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
    name, known, patch = "Residual", estimate.valid, estimate.grid.patch
    values = estimate.residual
    if readings is not None:
        name, values = "Raw reading", as_floats("readings", readings)
        check_shape("readings", values, (len(patch),), "one number per taxel")
        known = known & np.isfinite(values)
    values = np.where(known, values, np.nan)
    presses = presses_from_truth(truth, estimate.grid)
    with style():
        size, boxes = page_of(estimate.grid)
        figure = new_figure(*size)
        words = title or headline(estimate)
        figure.text(0.02, 1 - 0.22 / size[1], words, va="center", **TITLE)
        unit = "" if quantity_unit == "1" else f" ({quantity_unit})"
        axes: Any = figure.add_axes(boxes["readings"])
        pads = draw_pads(axes, patch, values * FACTOR.get(quantity_unit, 1.0))
        frame_axes(axes, patch, extent_of(estimate.grid, measured=True))
        if known.any():
            add_colour_bar(axes, pads, f"{quantity_name}{unit}")
        crossed = "" if known.all() else f"; crossed: {(~known).sum()} left out"
        add_title(axes, "a", name, f"pads to scale{crossed}")
        _draw_pressure(figure.add_axes(boxes["pressure"]), estimate, presses)
        axes = figure.add_axes(boxes["deformation"], projection="3d")
        factor = draw_deformation(figure, axes, estimate)
        note = "true to scale" if factor == 1 else f"indentation drawn {factor:g} times larger"
        heading = figure.add_axes(boxes["heading"])
        heading.axis("off")
        add_title(heading, "c", "Deformation", note)
        panel = figure.add_axes(boxes["contacts"])
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
    unit = "(relative)" if estimate.relative else "N"
    return f"{name}: {plural(len(contacts), 'contact')}, {force} {unit}"


def plot_estimate(
    estimate: Estimate, ax: Place = None, truth: Iterable[tuple[Any, Any, float]] | None = None
) -> Any:
    """Draw the pressure, the taxels and the contacts, or forces over time; see `Estimate.plot`."""
    if estimate.is_batch:
        if truth is not None:
            raise InputError(
                f"truth is given for {len(estimate)} readings, expected it for one: "
                "plot one of them, as in est[0].plot(truth=...)"
            )
        return _plot_run(estimate, ax)
    presses = presses_from_truth(truth, estimate.grid)
    width, height = np.ptp(extent_of(estimate.grid, measured=True), axis=0)
    unit = "" if estimate.relative else " N"
    words = [f"{plus_minus(c.normal_force, c.force_std)}{unit}" for c in estimate.contacts]
    with style():
        size = (4.4, float(np.clip(4.4 * height / width, 1.0, 5.0)))
        axes = axes_for(ax, size, (0.75, 0.55, 1.15, 0.6))
        _draw_pressure(axes, estimate, presses, words)
        outline_pads(axes, estimate.grid.patch)
    return axes


def _plot_run(estimate: Estimate, ax: Place) -> Any:
    """Force over time, or over the readings where they have no stamps."""
    stamps = np.broadcast_to(estimate.stamp_ns, len(estimate))
    timed = len(np.unique(stamps)) > 1
    across = (stamps - stamps[0]) * 1e-9 if timed else np.arange(len(stamps))
    with style():
        axes = axes_for(ax, (6.2, 2.6), (0.8, 0.55, 0.2, 0.65))
        axes.plot(across, estimate.normal_force, color=INK, lw=1.0)
        axes.set_xlabel("time (s)" if timed else "reading")
        axes.set_ylabel("force (relative)" if estimate.relative else "force (N)")
        open_axes(axes)
        note = "sum of the contacts, or of the field that answers"
        add_title(axes, "", f"{estimate.grid.patch.name}: force into the skin", note)
    return axes


def _draw_pressure(
    axes: "Axes",
    estimate: Estimate,
    presses: list[TruePress],
    words: Sequence[str] | None = None,
) -> None:
    from matplotlib.patches import Circle

    grid = estimate.grid
    label = "pressure (relative)" if estimate.relative else "pressure (kPa)"
    add_colour_bar(axes, draw_cells(axes, grid, estimate.pressure * 1e-3), label)
    hatch_uncovered(axes, grid)
    frame_axes(axes, grid.patch, extent_of(grid, measured=True))
    for press in presses:
        centre = Chart(grid).plane_from_position(press.position[None])[0] * MM
        if press.radius == 0.0:
            axes.plot(*centre, "x", color=BLUE, ms=8, mew=1.4, zorder=5)
            continue
        look: dict[str, Any] = {"ec": BLUE, "lw": 1.4, "ls": (0, (3, 2)), "zorder": 5}
        axes.add_patch(Circle(centre, press.radius * MM, fill=False, **look))
    draw_contacts(axes, grid, estimate.contacts, words)
    notes = ["line: contact"] if estimate.contacts else []
    notes += ["blue: truth"] if presses else []
    notes += [] if grid.covered.all() else ["hatched: outside the taxels"]
    head = ("b", "Pressure") if words is None else ("", headline(estimate))
    add_title(axes, *head, "; ".join(notes))

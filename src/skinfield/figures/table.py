"""Contacts of a reading as a small table in a figure."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from skinfield.errors import Floats
from skinfield.fields import Contact, Estimate
from skinfield.figures.maps import MM
from skinfield.figures.presses import Press, nearest_contact
from skinfield.figures.style import BLUE, FAINT, QUIET, number, plural, plus_minus
from skinfield.layout import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLUMNS = {"": 0.0, "place (mm)": 0.07, "force (N)": 0.45, "area (mm²)": 0.66, "peak (kPa)": 0.85}


class Writer:
    """Lines of text down a panel, of a height in points."""

    def __init__(self, axes: "Axes", line: float) -> None:
        box = axes.get_position()
        width, height = np.array([box.width, box.height]) * axes.figure.bbox.size / axes.figure.dpi
        self.axes, self.y, self.step = axes, 1.0, line / (height * 72.0)
        self.lines = int(height * 72.0 // line)
        self.size = float(np.clip(2.1 * width, 6.5, 8.5))

    def cells(self, words: Sequence[str], **look: Any) -> None:
        """Write one line across the columns."""
        for x, word in zip(COLUMNS.values(), words, strict=True):
            self.axes.text(x, self.y - self.step / 2, word, va="center", fontsize=self.size, **look)
        self.y -= self.step

    def words(self, words: str, **look: Any) -> None:
        """Write one line of running text."""
        self.axes.text(
            0.0, self.y - self.step / 2, words, va="center", fontsize=self.size - 0.5, **look
        )
        self.y -= self.step

    def rule(self, gap: float = 0.0) -> None:
        """Draw a thin line across the panel and leave `gap` lines of space."""
        self.axes.plot([0, 1], [self.y, self.y], color=FAINT, lw=0.8, clip_on=False)
        self.y -= gap * self.step


def draw_table(axes: "Axes", estimate: Estimate, presses: Sequence[Press]) -> None:
    """Write contacts, their sum, the truth where it is known, and how the estimate was made."""
    axes.set(xlim=(0, 1), ylim=(0, 1))
    axes.axis("off")
    contacts = list(estimate.contacts)
    writer = Writer(axes, line=13.5)
    notes = facts(estimate)
    room = writer.lines - len(notes) - 3 - bool(presses)
    truths = len(presses) if len(presses) + min(len(contacts), 2) <= room else 0
    writer.cells(list(COLUMNS), color=QUIET)
    writer.rule()
    _write_contacts(writer, contacts, estimate.grid, max(room - truths, 2))
    for press in presses[:truths]:
        writer.cells(row_of_press(press, estimate.grid), color=BLUE)
    if presses:
        writer.words(truth_note(presses, contacts), color=BLUE)
    writer.y -= 0.4 * writer.step
    for note in notes:
        writer.words(note, color=QUIET)


def _write_contacts(writer: Writer, contacts: list[Contact], grid: Grid, room: int) -> None:
    """Write one row a contact, as many as there is room for, the others as one, and the sum."""
    listed = contacts if len(contacts) <= room else contacts[: room - 1]
    for index, contact in enumerate(listed):
        writer.cells(row_of(index, contact, grid))
    if not contacts:
        writer.words("no contact above the noise", color=QUIET)
    if len(listed) < len(contacts):
        rest = contacts[len(listed) :]
        writer.cells(["", plural(len(rest), "other"), *_sums(rest), ""], color=QUIET)
    writer.rule()
    if contacts:
        writer.cells(["", "all contacts", *_sums(contacts), ""], fontweight="bold")


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


def row_of_press(press: Press, grid: Grid) -> list[str]:
    """Cells of the table for one true press."""
    area = number(np.pi * press.radius**2 * 1e6)
    return ["true", place_of(press.position, grid), number(press.force), area, ""]


def place_of(position: Floats, grid: Grid) -> str:
    """Coordinates in mm; two where the patch lies in z = 0."""
    flat = np.allclose(grid.patch.positions[:, 2], 0.0)
    return ", ".join(f"{x * MM:.1f}".replace("-", "−") for x in position[: 2 if flat else 3])


def truth_note(presses: Sequence[Press], contacts: Sequence[Contact]) -> str:
    """Say how far the contacts nearest to the true presses are from them, at worst."""
    found = [(press, nearest_contact(press, contacts)) for press in presses]
    pairs = [(press, *match) for press, match in found if match is not None]
    if not pairs:
        return "truth: no contact found"
    changes = [(c.normal_force / p.force - 1) * 100 for p, c, _ in pairs if p.force]
    change = max(changes, key=abs, default=float("nan"))
    distance = max(apart for _, _, apart in pairs) * MM
    worst = ", at worst" if len(pairs) > 1 else ""
    sign = "+" if change >= 0 else ""
    force, place = number(change, 2), number(distance, 2)
    return f"off the truth by {sign}{force} % of force, {place} mm of place{worst}"


def facts(estimate: Estimate) -> list[str]:
    """Sum over the patch, and how the estimate was made, in short lines."""
    grid = estimate.grid
    rows, columns = grid.shape
    std = estimate.pressure_std[grid.covered] if grid.covered.any() else estimate.pressure_std
    spread = float(np.nanmedian(std)) if np.isfinite(std).any() else np.nan
    last = [f"{columns} × {rows} cells of {number(grid.pitch * MM)} mm"]
    if np.isfinite(spread) and spread > 0.0:  # contacts that are fitted have none beside them
        last.append(f"σ of pressure {number(spread * 1e-3, 2)} kPa")
    if np.isfinite(estimate.latency):
        last.append(duration(estimate.latency))
    return [
        f"whole patch {number(float(estimate.normal_force))} N; "
        f"{int(estimate.valid.sum())} of {plural(len(estimate.valid), 'taxel')} used",
        "; ".join(last),
    ]


def duration(seconds: float) -> str:
    """Write a time in s, ms or µs."""
    scale, unit = next(
        ((scale, unit) for scale, unit in ((1.0, "s"), (1e3, "ms")) if seconds * scale >= 1.0),
        (1e6, "µs"),
    )
    return f"{number(seconds * scale, 2)} {unit}"

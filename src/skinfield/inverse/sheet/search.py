"""Contacts of a sheet: where the pressure stands out of the noise, window by window."""

from typing import TYPE_CHECKING

import numpy as np

from skinfield.errors import check_offers
from skinfield.fields import Contact
from skinfield.inverse.sheet.noise import SheetNoise
from skinfield.inverse.sheet.plan import SheetPlan
from skinfield.inverse.sheet.windows import TILE, Finder, contacts_of, windows
from skinfield.layout import Grid, Patch

if TYPE_CHECKING:
    from skinfield.inverse.sheet.estimate import SheetEstimate

SAMPLES = 9  # tiles by which the deviation of a sheet's cells is known
MOST = 0.99  # of the cells, whose deviation is no higher


def contacts_on(estimate: "SheetEstimate", finder: Finder) -> tuple[Contact, ...]:
    """See `SheetEstimate.contacts`."""
    from scipy.special import ndtri

    check_offers("finder", finder, ("false_alarm_rate",), "an object such as ContactFinder()")
    sheet = estimate.sheet
    sigmas = float(-ndtri(finder.false_alarm_rate / estimate.pressure.size))
    valid = estimate.valid[sheet.plan.placing.order]
    high = estimate.pressure > sigmas * sheet.highest_std
    corners = np.pad(
        sheet.origin + np.array([[0, 0], [1, 0], [0, 1]]) * sheet.pitch, ((0, 0), (0, 1))
    )
    patch = Patch(corners, sheet.pad_diameter, name="sheet")
    contacts: list[Contact] = []
    for window in windows(high):
        part = estimate.pressure[window.rows, window.columns]
        first = np.array([window.columns.start, window.rows.start])
        grid = Grid(patch, part.shape, sheet.pitch, sheet.origin + first * sheet.pitch)
        noise = SheetNoise(sheet.plan, valid, window.rows, window.columns)
        found = finder(grid, part.astype(np.float64).ravel(), noise)
        contacts += contacts_of(grid, window, found, sheet.shape[1], sigmas * noise.std)
    return tuple(sorted(contacts, key=lambda contact: -contact.normal_force))


def highest_std(plan: SheetPlan) -> float:
    """Deviation that few cells exceed, Pa, by those about some taxels, where all answer."""
    valid = np.ones(len(plan.placing.order), dtype=bool)
    some = np.linspace(0, len(valid) - 1, SAMPLES).astype(int)
    found = []
    for column, row in plan.placing.cell[some] - TILE // 2:
        rows, columns = (slice(max(int(at), 0), max(int(at), 0) + TILE) for at in (row, column))
        found.append(SheetNoise(plan, valid, rows, columns).std)
    return float(np.quantile(np.concatenate(found), MOST))

"""From bodies above the skin to the pressure below them: coarse first, then fine where they touch.

The grid's own cells only tell where touch is. There each contact gets a window of finer squares,
three, nine, 27 or 81 to a cell, so that a small one is seen as well as a large one, and the whole
is solved again. If the contact then reaches a window's border, or a body overlaps the skin outside,
the windows grow.
"""

from collections.abc import Sequence

import numpy as np

from skinfield.errors import Floats, SkinfieldError
from skinfield.mechanics.contact import (
    TOLERANCE,
    ContactProblem,
    solve_contact,
)
from skinfield.simulate.indenters import Indenter
from skinfield.simulate.pressing.checks import check_border, check_depth, check_places
from skinfield.simulate.pressing.cover import cover
from skinfield.simulate.pressing.laid import Laid, Settled
from skinfield.simulate.pressing.plane import PAD, Skin
from skinfield.simulate.pressing.responses import Indenting
from skinfield.simulate.pressing.window import Window, cut, merged, resplit, touched, width

ROUNDS = 12
REFINED = 4  # rounds in which windows may still be cut finer
COARSE = 1e-2  # residual that tells where touch is


def settle(skin: Skin, indenters: Sequence[Indenter], before: Settled | None = None) -> Settled:
    """Solve for the contact of all bodies at once.

    A solution `before` of the same bodies in the same places, under other loads, saves the way to
    where they touch.
    """
    if before is None:
        whole = _lay(skin, indenters, [skin.whole])
        check_places(skin, indenters, whole)
        settled = _solve(whole, whole, indenters, _first_push(whole, indenters), COARSE)
    else:
        whole, settled = before.whole, before
    margin, pierced = 2, False
    for attempt in range(ROUNDS):
        windows = _windows(settled, margin)
        laid = settled.laid
        if windows != laid.windows or pierced:
            laid = _lay(skin, indenters, windows, settled.contact.approach)
        settled = _solve(laid, whole, indenters, _carried_over(settled, laid))
        check_depth(indenters, settled)
        if _leaks(settled):
            margin += 3
            continue
        margin = 1
        pierced = _pierced(settled)
        if not pierced and (attempt >= REFINED or not _finer(settled, margin)):
            check_border(settled)
            return settled
    raise SkinfieldError(
        f"touch did not settle in {ROUNDS} rounds, expected it to after a few: "
        "move the bodies apart where they overlap each other"
    )


def _lay(
    skin: Skin, indenters: Sequence[Indenter], windows: list[Window], approach: Floats | None = None
) -> Laid:
    parts = []
    for window in windows:
        y, x = skin.axes(window)
        search = window == skin.whole
        covers = [cover(indenter, y, x, skin.side(window), search) for indenter in indenters]
        parts.append([[c.height.ravel(), c.coverage.ravel(), c.grown.ravel()] for c in covers])
    each, coverages, grown = np.moveaxis(np.concatenate(parts, axis=2), 1, 0)
    deep = np.zeros(len(indenters)) if approach is None else approach
    bodies = (each - deep[:, None]).argmin(axis=0)
    return Laid(skin, windows, each, coverages, grown, bodies)


def _solve(
    laid: Laid,
    whole: Laid,
    indenters: Sequence[Indenter],
    start: Floats,
    tolerance: float = TOLERANCE,
) -> Settled:
    indenting = Indenting(laid.skin, laid.windows)
    number = [(np.nan if i.force is None else i.force, np.nan if i.depth is None else i.depth)
              for i in indenters]  # fmt: skip
    forces, depths = np.array(number, dtype=np.float64).T
    problem = ContactProblem(
        indenting,
        indenting.own(),
        laid.chosen(laid.each),
        laid.bodies,
        laid.area,
        forces,
        depths,
    )
    softness = laid.softness
    contact = solve_contact(problem, start, softness, tolerance)
    return Settled(laid, indenting, contact, whole)


def _first_push(laid: Laid, indenters: Sequence[Indenter]) -> Floats:
    """Each force spread over the cells within a tenth of a thickness above the lowest point."""
    start = np.zeros(len(laid.bodies))
    near = max(0.1 * laid.skin.layer.thickness, 0.0)
    for body, indenter in enumerate(indenters):
        if indenter.force is None:
            continue
        own = np.isfinite(laid.each[body]) & (laid.bodies == body)
        guess = own & (laid.each[body] <= max(near, float(laid.each[body][own].min())))
        start[guess] = indenter.force / laid.area[guess].sum()
    return start


def _windows(settled: Settled, margin: int) -> list[Window]:
    """Windows around all contacts, each cut as finely as its smallest contact asks for."""
    laid, grid = settled.laid, settled.laid.skin.grid
    found: list[tuple[Window, float]] = []
    for body in range(len(laid.each)):
        mask = (settled.contact.pressure > 0) & (laid.bodies == body)
        masks = [picture > 0 for picture in settled.indenting.pictures(mask)]
        if not mask.any():  # the body may touch within a cell, or not at all
            masks = [picture > 0 for picture in settled.indenting.pictures(laid.nearest(body))]
        parts = settled.indenting.pictures(laid.coverage)
        for index, window in enumerate(touched(laid.windows, masks)):
            if window is not None:
                across = width(masks[index], parts[index]) / laid.windows[index].split
                found.append((window.grown(margin, grid.shape), across))
    return cut(merged(found))


def _carried_over(settled: Settled, laid: Laid) -> Floats:
    """A start on other windows from a solution, spread over the cells."""
    if laid is settled.laid:
        return settled.contact.pressure
    picture = np.zeros(laid.skin.grid.shape)
    for window, pressure in zip(
        settled.laid.windows, settled.indenting.pictures(settled.contact.pressure), strict=True
    ):
        picture[window.cells] = window.means(pressure)
    return np.concatenate(
        [resplit(picture[window.cells], 1, window.split).ravel() for window in laid.windows]
    )


def _leaks(settled: Settled) -> bool:
    """Whether touch reaches a window's border, or a body is in the skin outside of all windows."""
    laid, contact = settled.laid, settled.contact
    skin, shape = laid.skin, laid.skin.grid.shape
    outside = np.ones(shape, dtype=bool)
    sunk = np.zeros(shape)
    for window, pressure in zip(
        laid.windows, settled.indenting.pictures(contact.pressure), strict=True
    ):
        outside[window.cells] = False
        sunk += skin.far(skin.carried(window, pressure))[PAD:-PAD, PAD:-PAD]
        for inner, line in (
            (window.row > 0, pressure[0]),
            (window.row + window.rows < shape[0], pressure[-1]),
            (window.column > 0, pressure[:, 0]),
            (window.column + window.columns < shape[1], pressure[:, -1]),
        ):
            if inner and line.any():
                return True
    height = (settled.whole.each - contact.approach[:, None]).min(axis=0).reshape(shape)
    gap = np.where(outside, height + sunk, np.inf)
    return bool(gap.min() < -1e-4 * np.abs(contact.approach).max())


def _pierced(settled: Settled) -> bool:
    """Whether a body is in the skin where another one was taken to touch."""
    laid, contact = settled.laid, settled.contact
    if len(laid.each) == 1:
        return False
    lower = (laid.each - contact.approach[:, None]).min(axis=0)
    own = laid.chosen(laid.each) - contact.approach[laid.bodies]
    there = np.isfinite(own)
    gap = contact.gap[there] + lower[there] - own[there]
    return bool(gap.min() < -1e-3 * np.abs(contact.approach).max())


def _finer(settled: Settled, margin: int) -> bool:
    """Whether a contact came out so small that its window should be cut again."""
    wanted = max(window.split for window in _windows(settled, margin))
    return wanted > max(window.split for window in settled.laid.windows)

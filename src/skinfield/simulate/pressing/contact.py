"""Contact of bodies with the layer: the pressure below bodies above the skin, coarse first."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skinfield.elastic.contact import (
    TOLERANCE,
    ContactProblem,
    ContactSolution,
    edge_softness,
    solve_contact,
)
from skinfield.errors import Floats, InputError, SkinfieldError
from skinfield.simulate.indenters.body import Indenter
from skinfield.simulate.pressing.windows import (
    PAD,
    Medium,
    Window,
    Yielding,
    cut,
    merged,
    resplit,
    touched,
    width,
)

POINTS = 10  # along each side of a cell that holds an edge
REFINEMENTS = 400  # of following a body that is thinner than a cell
CROSS = 0.73  # share of the dilation by four neighbours, the rest by eight: 0.1 cells in all


@dataclass(frozen=True, eq=False)
class Cover:
    """One body over a lattice of cells.

    Attributes
    ----------
    height : (rows, columns) array, m
        Median over the covered part of each cell, above the body's lowest point; infinite where the
        body is not.
    coverage : (rows, columns) array
        Covered fraction of each cell.
    grown : (rows, columns) array
        The same of a body whose edges stand out by a tenth of a cell, see `elastic.contact`.
    """

    height: Floats
    coverage: Floats
    grown: Floats


def cover(indenter: Indenter, y: Floats, x: Floats, side: float, search: bool = False) -> Cover:
    """Look at a body over cells with centres at y (rows,) and x (columns,) m.

    Centres decide, but for cells at an edge: there `POINTS` x `POINTS` places do. Edges are
    followed from cell to cell and from the body's lowest point, so what is thinner than a cell is
    seen too. If there is none of it, `search` looks between the centres of all cells.
    """
    from scipy.ndimage import binary_dilation

    height = np.array(indenter.height(*np.meshgrid(x, y)), dtype=np.float64)
    coverage = np.isfinite(height).astype(np.float64)
    seen = Cover(height, coverage, coverage.copy())
    looked = np.zeros(height.shape, dtype=bool)
    block = np.ones((3, 3), dtype=bool)
    todo = _around(indenter.lowest, y, x, side)
    if search and not coverage.any():
        todo |= _between(indenter, y, x, side)
    for _ in range(REFINEMENTS):
        uncertain = binary_dilation(coverage > 0, block) & binary_dilation(coverage < 1, block)
        todo = (todo | uncertain) & ~looked
        if not todo.any():
            break
        _look_closer(indenter, todo, y, x, side, seen)
        looked |= todo
    return seen


def _around(place: tuple[float, float], y: Floats, x: Floats, side: float) -> NDArray[np.bool_]:
    """The cells within one cell of a place."""
    return (np.abs(y - place[1]) < 1.5 * side)[:, None] & (np.abs(x - place[0]) < 1.5 * side)


def _between(indenter: Indenter, y: Floats, x: Floats, side: float) -> NDArray[np.bool_]:
    """The cells of which one of `POINTS` x `POINTS` places is under the body, a row at a time."""
    shift = ((np.arange(POINTS) + 0.5) / POINTS - 0.5) * side
    across = (x[:, None] + shift).ravel()
    rows = []
    for place in y:
        fine = np.asarray(indenter.height(*np.meshgrid(across, place + shift)))
        rows.append(np.isfinite(fine).any(axis=0).reshape(len(x), POINTS).any(axis=1))
    return np.stack(rows)


def _look_closer(
    indenter: Indenter, cells: NDArray[np.bool_], y: Floats, x: Floats, side: float, seen: Cover
) -> None:
    """Fill in some cells from points within them and in a rim around, for the dilation."""
    row, column = np.nonzero(cells)
    shift = ((np.arange(-1, POINTS + 1) + 0.5) / POINTS - 0.5) * side
    across, along = (part.ravel() for part in np.meshgrid(shift, shift))
    fine = np.asarray(indenter.height(x[column, None] + across, y[row, None] + along))
    fine = fine.reshape(-1, POINTS + 2, POINTS + 2)
    there = np.isfinite(fine)
    seen.coverage[row, column] = there[:, 1:-1, 1:-1].mean(axis=(1, 2))
    four = there[:, 1:-1, 1:-1] | there[:, :-2, 1:-1] | there[:, 2:, 1:-1]
    four |= there[:, 1:-1, :-2] | there[:, 1:-1, 2:]
    eight = four | there[:, :-2, :-2] | there[:, :-2, 2:] | there[:, 2:, :-2] | there[:, 2:, 2:]
    seen.grown[row, column] = CROSS * four.mean(axis=(1, 2)) + (1 - CROSS) * eight.mean(axis=(1, 2))
    # A cell that the edge only nearly reaches has the height of the rim.
    within = there.copy()
    within[:, [0, -1]] = within[:, :, [0, -1]] = False
    some = np.asarray(within.any(axis=(1, 2), keepdims=True))
    counted = np.where(some, within, there)
    # The median, as the steep wall beside the face of a leaning body would spoil a mean.
    ordered = np.sort(np.where(counted, fine, np.inf).reshape(len(fine), -1), axis=1)
    count, every = counted.sum(axis=(1, 2)), np.arange(len(fine))
    low, high = ordered[every, np.maximum(count - 1, 0) // 2], ordered[every, count // 2]
    seen.height[row, column] = np.where(count, (low + np.where(count, high, 0.0)) / 2, np.inf)


@dataclass(frozen=True, eq=False)
class Coverings:
    """Bodies over the squares of windows; arrays (N,) run through the windows.

    Attributes
    ----------
    skin : Medium
    windows : list of Window
    each : (bodies, N) array, m
        Height of each body above its lowest point.
    coverages, grown : (bodies, N) array
        See `Cover`.
    bodies : (N,) int array
        The one that can touch.
    """

    skin: Medium
    windows: list[Window]
    each: Floats
    coverages: Floats
    grown: Floats
    bodies: NDArray[np.int64]

    @property
    def area(self) -> Floats:
        """Of each square, (N,) m²."""
        return np.concatenate(
            [np.full(window.size, self.skin.side(window) ** 2) for window in self.windows]
        )

    def chosen(self, values: Floats) -> Floats:
        """Of values (bodies, N) that of the body that can touch, (N,)."""
        return np.asarray(np.take_along_axis(values, self.bodies[None], axis=0)[0])

    def nearest(self, body: int) -> NDArray[np.bool_]:
        """The square (N,) under the lowest part of a body."""
        out = np.zeros(len(self.bodies), dtype=bool)
        out[self.each[body].argmin()] = True
        return out

    @property
    def coverage(self) -> Floats:
        """Fraction of each square below the body that can touch, (N,)."""
        return self.chosen(self.coverages)

    @property
    def softness(self) -> Floats:
        """Of sharp edges, (N,), see `edge_softness`."""
        return edge_softness(self.chosen(self.grown))


@dataclass(frozen=True, eq=False)
class Settled:
    """A solution on windows, beside the same bodies over the whole grid."""

    coverings: Coverings
    indenting: Yielding
    contact: ContactSolution
    whole: Coverings


def check_places(skin: Medium, indenters: Sequence[Indenter], whole: Coverings) -> None:
    """Each body must have cells, and be the lowest on some of them."""
    for index, indenter in enumerate(indenters):
        under = np.isfinite(whole.each[index])
        if not under.any():
            grid = skin.grid
            raise InputError(
                f"indenters[{index}] at {indenter.position} m covers no cell, expected it within "
                f"{grid.shape[0] * grid.pitch / 2:g} m of the origin and wider than a tenth of a "
                f"cell of {grid.pitch:g} m"
            )
        if not under[whole.bodies == index].any():
            raise InputError(
                f"indenters[{index}] at {indenter.position} m lies behind the others, "
                "expected them apart: each must be the lowest somewhere"
            )


def check_border(settled: Settled) -> None:
    """A touch that the square of skin cuts off would be another press than the one meant."""
    coverings, grid = settled.coverings, settled.coverings.skin.grid
    pictures = settled.indenting.pictures(settled.contact.pressure)
    for window, pressure, body in zip(
        coverings.windows, pictures, settled.indenting.pictures(coverings.bodies), strict=True
    ):
        border = np.zeros(pressure.shape, dtype=bool)
        border[0] |= window.row == 0
        border[-1] |= window.end[0] == grid.shape[0]
        border[:, 0] |= window.column == 0
        border[:, -1] |= window.end[1] == grid.shape[1]
        cut_off = border & (pressure > 0)
        if cut_off.any():
            side = grid.shape[0] * grid.pitch
            raise InputError(
                f"indenters[{int(body[cut_off][0])}] touches the border of the {side:g} m of skin "
                "around the origin, expected skin on all sides of it: raise extent, or move it in"
            )


def check_depth(indenters: Sequence[Indenter], settled: Settled) -> None:
    """No body may reach the base; one that does as most of it has no skin hears of that."""
    thickness, approach = settled.coverings.skin.layer.thickness, settled.contact.approach
    deepest = int(approach.argmax())
    if approach[deepest] >= thickness:
        check_border(settled)
        raise InputError(
            f"indenters[{deepest}] with {_load(indenters[deepest])} sinks "
            f"{approach[deepest] * 1e3:.3g} mm into a layer of {thickness * 1e3:g} mm, "
            "expected less than its thickness: press lighter, or with a wider body"
        )


def _load(indenter: Indenter) -> str:
    return f"{indenter.depth:g} m" if indenter.force is None else f"{indenter.force:g} N"


ROUNDS = 12
REFINED = 4  # rounds in which windows may still be cut finer
COARSE = 1e-2  # residual that tells where touch is


def settle(skin: Medium, indenters: Sequence[Indenter], before: Settled | None = None) -> Settled:
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
        coverings = settled.coverings
        if windows != coverings.windows or pierced:
            coverings = _lay(skin, indenters, windows, settled.contact.approach)
        settled = _solve(coverings, whole, indenters, _carried_over(settled, coverings))
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
    skin: Medium,
    indenters: Sequence[Indenter],
    windows: list[Window],
    approach: Floats | None = None,
) -> Coverings:
    parts = []
    for window in windows:
        y, x = skin.axes(window)
        search = window == skin.whole
        covers = [cover(indenter, y, x, skin.side(window), search) for indenter in indenters]
        parts.append([[c.height.ravel(), c.coverage.ravel(), c.grown.ravel()] for c in covers])
    each, coverages, grown = np.moveaxis(np.concatenate(parts, axis=2), 1, 0)
    deep = np.zeros(len(indenters)) if approach is None else approach
    bodies = (each - deep[:, None]).argmin(axis=0)
    return Coverings(skin, windows, each, coverages, grown, bodies)


def _solve(
    coverings: Coverings,
    whole: Coverings,
    indenters: Sequence[Indenter],
    start: Floats,
    tolerance: float = TOLERANCE,
) -> Settled:
    indenting = Yielding(coverings.skin, coverings.windows)
    problem = problem_of(coverings, indenting, indenters)
    contact = solve_contact(problem, start, coverings.softness, tolerance)
    return Settled(coverings, indenting, contact, whole)


def problem_of(
    coverings: Coverings,
    indenting: Yielding,
    indenters: Sequence[Indenter],
    lift: Floats | None = None,
) -> ContactProblem:
    """Contact on all windows, with the surface raised by `lift` (N,) m before any pressure."""
    heights = coverings.chosen(coverings.each)
    return ContactProblem(
        lambda pressure: indenting(pressure[None])[0],
        indenting.own,
        heights if lift is None else heights - lift,
        coverings.bodies,
        coverings.area,
        np.array([body.force for body in indenters], dtype=np.float64),  # None is NaN
        np.array([body.depth for body in indenters], dtype=np.float64),
    )


def widened(settled: Settled, indenters: Sequence[Indenter], margin: int) -> Settled:
    """The same contact solved again on windows that reach some cells farther."""
    windows = _windows(settled, margin)
    coverings = _lay(settled.coverings.skin, indenters, windows, settled.contact.approach)
    return _solve(coverings, settled.whole, indenters, _carried_over(settled, coverings))


def _first_push(coverings: Coverings, indenters: Sequence[Indenter]) -> Floats:
    """Each force spread over the cells within a tenth of a thickness above the lowest point."""
    start = np.zeros(len(coverings.bodies))
    near = max(0.1 * coverings.skin.layer.thickness, 0.0)
    for body, indenter in enumerate(indenters):
        if indenter.force is None:
            continue
        own = np.isfinite(coverings.each[body]) & (coverings.bodies == body)
        guess = own & (coverings.each[body] <= max(near, float(coverings.each[body][own].min())))
        start[guess] = indenter.force / coverings.area[guess].sum()
    return start


def _windows(settled: Settled, margin: int) -> list[Window]:
    """Windows around all contacts, each cut as finely as its smallest contact asks for."""
    return cut(merged(_touch_windows(settled, margin)))


def shared(
    states: Sequence[Settled], bodies: Sequence[Sequence[Indenter]], margin: int
) -> list[Settled]:
    """Contacts of a path solved again on windows around all of them.

    They are cut as finely as the widest contact asks for: the narrow ones pass.
    """
    every = [found for settled in states for found in _touch_windows(settled, margin)]
    widest = max(across for _, across in every)
    windows = cut(merged([(window, widest) for window, _ in every]))
    again = []
    for settled, indenters in zip(states, bodies, strict=True):
        skin, approach = settled.coverings.skin, settled.contact.approach
        coverings = _lay(skin, indenters, windows, approach)
        start = _carried_over(settled, coverings)
        again.append(_solve(coverings, settled.whole, indenters, start))
    return again


def _touch_windows(settled: Settled, margin: int) -> list[tuple[Window, float]]:
    """Windows of cells around all contacts, and how wide these are."""
    coverings, grid = settled.coverings, settled.coverings.skin.grid
    found: list[tuple[Window, float]] = []
    for body in range(len(coverings.each)):
        mask = (settled.contact.pressure > 0) & (coverings.bodies == body)
        masks = [picture > 0 for picture in settled.indenting.pictures(mask)]
        if not mask.any():  # the body may touch within a cell, or not at all
            masks = [picture > 0 for picture in settled.indenting.pictures(coverings.nearest(body))]
        parts = settled.indenting.pictures(coverings.coverage)
        for whole, mask, part in zip(coverings.windows, masks, parts, strict=True):
            window = touched(whole, mask)
            if window is not None:
                across = width(mask, part) / whole.split
                found.append((window.grown(margin, grid.shape), across))
    return found


def _carried_over(settled: Settled, coverings: Coverings) -> Floats:
    """A start on other windows from a solution, spread over the cells."""
    if coverings is settled.coverings:
        return settled.contact.pressure
    picture = np.zeros(coverings.skin.grid.shape)
    for window, pressure in zip(
        settled.coverings.windows, settled.indenting.pictures(settled.contact.pressure), strict=True
    ):
        picture[window.cells] = window.means(pressure)
    return np.concatenate(
        [resplit(picture[window.cells], 1, window.split).ravel() for window in coverings.windows]
    )


def reaches_border(settled: Settled) -> bool:
    """Whether touch reaches the border of a window, beyond which there is more skin."""
    shape = settled.coverings.skin.grid.shape
    pictures = settled.indenting.pictures(settled.contact.pressure)
    for window, pressure in zip(settled.coverings.windows, pictures, strict=True):
        for inner, line in (
            (window.row > 0, pressure[0]),
            (window.end[0] < shape[0], pressure[-1]),
            (window.column > 0, pressure[:, 0]),
            (window.end[1] < shape[1], pressure[:, -1]),
        ):
            if inner and line.any():
                return True
    return False


def _leaks(settled: Settled) -> bool:
    """Whether touch reaches a window's border, or a body is in the skin outside of all windows."""
    if reaches_border(settled):
        return True
    coverings, contact = settled.coverings, settled.contact
    skin, shape = coverings.skin, coverings.skin.grid.shape
    outside = np.ones(shape, dtype=bool)
    sunk = np.zeros(shape)
    for window, pressure in zip(
        coverings.windows, settled.indenting.pictures(contact.pressure), strict=True
    ):
        outside[window.cells] = False
        sunk += skin.far(skin.carried(window, pressure))[PAD:-PAD, PAD:-PAD]
    height = (settled.whole.each - contact.approach[:, None]).min(axis=0).reshape(shape)
    gap = np.where(outside, height + sunk, np.inf)
    return bool(gap.min() < -1e-4 * np.abs(contact.approach).max())


def _pierced(settled: Settled) -> bool:
    """Whether a body is in the skin where another one was taken to touch."""
    coverings, contact = settled.coverings, settled.contact
    if len(coverings.each) == 1:
        return False
    lower = (coverings.each - contact.approach[:, None]).min(axis=0)
    own = coverings.chosen(coverings.each) - contact.approach[coverings.bodies]
    there = np.isfinite(own)
    gap = contact.gap[there] + lower[there] - own[there]
    return bool(gap.min() < -1e-3 * np.abs(contact.approach).max())


def _finer(settled: Settled, margin: int) -> bool:
    """Whether a contact came out so small that its window should be cut again."""
    wanted = max(window.split for window in _windows(settled, margin))
    return wanted > max(window.split for window in settled.coverings.windows)

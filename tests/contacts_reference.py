"""Contacts as they are defined, step by step and slowly: what the compiled code must agree with."""

import numpy as np
from scipy.stats import norm

from skinfield.estimate import (
    Contact,
    ContactFinder,
    ModelError,
    PressureError,
    PressureNoise,
    PressurePosterior,
)
from skinfield.skin import Grid

ROUNDING = 0.0572  # cells of variance per side of a border


def contacts(
    finder: ContactFinder,
    grid: Grid,
    pressure: np.ndarray,
    noise: PressureNoise,
    error: PressureError | None = None,
    model_error: ModelError | None = None,
) -> tuple[Contact, ...]:
    """As `ContactFinder.__call__`."""
    sigmas = norm.isf(finder.false_alarm_rate / max(int(np.count_nonzero(noise.std)), 1))
    highest = float(pressure.max())
    needed = np.maximum(sigmas * noise.std, finder.relative_height * highest)
    if not (pressure > needed).any():
        return ()
    drop = np.maximum(finder.prominence * pressure, sigmas * noise.std)
    floor = finder.edge * finder.relative_height * highest
    found = regions(pressure, drop, floor, finder.edge, grid.shape[1])
    found = [cells for cells in found if (pressure > needed)[cells].any()]
    stated = noise if error is None else error
    beside = ModelError() if model_error is None else model_error
    made = [contact_of(grid, pressure, cells, stated, beside, finder.edge) for cells in found]
    return by_force(made)


def by_force(made: list[Contact]) -> tuple[Contact, ...]:
    """Falling; neighbours that differ by 1e-9 at most are equal, and come by their first cell."""
    groups: list[list[Contact]] = []
    for contact in sorted(made, key=lambda each: -each.normal_force):
        if groups and groups[-1][-1].normal_force <= (1.0 + 1e-9) * contact.normal_force:
            groups[-1].append(contact)
        else:
            groups.append([contact])
    return tuple(each for group in groups for each in sorted(group, key=lambda c: c.cells[0]))


def regions(
    flat: np.ndarray, drop: np.ndarray, floor: float, edge: float, columns: int
) -> list[np.ndarray]:
    """Flat cells of each region, by falling peak."""
    above = np.flatnonzero(flat > floor)
    order = above[np.argsort(-flat[above], kind="stable")]
    peaks = flooded(flat, drop, order, columns)
    kept = order[flat[order] >= edge * flat[peaks[order]]]
    return [np.sort(kept[peaks[kept] == peak]) for peak in order[peaks[order] == order]]


def flooded(flat: np.ndarray, drop: np.ndarray, order: np.ndarray, columns: int) -> np.ndarray:
    """Peak of each cell's hill, -1 for cells that are not in `order`; Numba can compile it."""
    rows, parent = len(flat) // columns, np.full(len(flat), -1)
    for cell in order:
        row, column = cell // columns, cell % columns
        hills = []
        for step in range(9):
            r, c = row + step // 3 - 1, column + step % 3 - 1
            if 0 <= r < rows and 0 <= c < columns and parent[r * columns + c] >= 0:
                peak = r * columns + c
                while parent[peak] != peak:
                    peak = parent[peak]
                hills.append(peak)
        best = cell
        for peak in hills:  # the first of equal ones
            if best == cell or flat[peak] > flat[best]:
                best = peak
        for lower in hills:
            if lower != best and flat[lower] - flat[cell] < drop[lower]:
                parent[lower] = best
        parent[cell] = best
    for cell in order:
        while parent[cell] != parent[parent[cell]]:
            parent[cell] = parent[parent[cell]]
    return parent


def contact_of(
    grid: Grid,
    pressure: np.ndarray,
    cells: np.ndarray,
    error: PressureError,
    model_error: ModelError,
    edge: float,
) -> Contact:
    """Contact of a region."""
    weight = pressure[cells] * grid.cell_area
    total = float(weight.sum())
    centre = weight @ grid.plane[cells] / total
    surface = grid.patch.surface
    position = surface.position_from_plane(centre[None])[0]
    forces = -weight[:, None] * grid.normals[cells]
    away = grid.plane[cells] - centre
    spread = (away * (weight / total)[:, None]).T @ away + np.eye(2) * grid.cell_area / 12
    variance, direction = np.linalg.eigh(spread)
    angle = float(np.arctan2(direction[1, 1], direction[0, 1]))
    area = len(cells) * grid.cell_area
    moves = np.stack([*(away / total).T, np.ones(len(cells))]) * grid.cell_area
    known = np.diag([model_error.place**2, model_error.place**2, (model_error.force * total) ** 2])
    around, shifts, rounding = area_moves(grid, pressure, cells, edge)
    moved = covariance_of_sums(error, around, shifts[None])[0, 0]
    return Contact(
        position=position,
        force=forces.sum(axis=0),
        moment=np.cross(grid.positions[cells] - position, forces).sum(axis=0),
        normal=surface.frame_from_plane(centre[None])[0, :, 2],
        area=area,
        peak_pressure=float(pressure[cells].max()),
        covariance=covariance_of_sums(error, cells, moves) + known,
        area_std=float(np.sqrt(max(moved, 0.0) + rounding**2 + (area * model_error.area) ** 2)),
        radius=float(np.sqrt(area / np.pi)),
        shape="other",
        outline=surface.position_from_plane(grid.origin + border(cells, grid.shape) * grid.pitch),
        axes=2.0 * np.sqrt(variance[::-1]),
        angle=(angle + np.pi / 2) % np.pi - np.pi / 2,
        cells=cells,
    )


def covariance_of_sums(error: PressureError, cells: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """By the dense covariance of the cells."""
    part = error.factor[cells] @ error.factor[cells].T
    if isinstance(error, PressurePosterior):
        row, column = (np.abs(axis[:, None] - axis[None]) for axis in error.steps[cells].T)
        part = error.prior[row, column] - part
    return weights @ part @ weights.T


def area_moves(
    grid: Grid, pressure: np.ndarray, cells: np.ndarray, edge: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """Cells around the border, m²/Pa of each, and one deviation of the counted area."""
    rows, columns = grid.shape
    picture = pressure.reshape(grid.shape)
    slope = np.gradient(picture) if min(grid.shape) > 1 else [np.zeros_like(picture)] * 2
    inside = np.isin(np.arange(len(grid)), cells)
    row, column = np.divmod(cells, columns)
    peak = int(cells[np.argmax(pressure[cells])])
    level = edge * pressure[peak]
    around, weights, sides = [], [], 0
    for down, right in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        r, c = row + down, column + right
        on = (r >= 0) & (r < rows) & (c >= 0) & (c < columns)
        here, beside = cells[on], r[on] * columns + c[on]
        outer = ~inside[beside]
        sides += int(outer.sum()) + int((~on).sum())
        crossed = outer & (pressure[beside] < level) & (pressure[here] > level)
        here, beside = here[crossed], beside[crossed]
        across = pressure[here] - pressure[beside]
        tangent = slope[1 if down else 0].ravel()
        along = (tangent[here] + tangent[beside]) / 2
        share = (pressure[here] - level) / across
        per_pascal = grid.cell_area * across / (across**2 + along**2)
        around += [here, beside]
        weights += [per_pascal * (1 - share), per_pascal * share]
    moves = np.concatenate(weights)
    cells_around = np.concatenate([*around, [peak]])
    rounding = float(grid.cell_area * np.sqrt(ROUNDING * sides))
    return cells_around, np.append(moves, -edge * moves.sum()), rounding


def border(cells: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Corners around a region, counter-clockwise from the lower left one of its first cell."""
    inside = {divmod(int(cell), shape[1]) for cell in cells}
    row, column = divmod(int(cells[0]), shape[1])
    x, y, dx, dy = column, row, 1, 0
    way = [(x, y)]
    while True:
        x, y = x + dx, y + dy
        way.append((x, y))
        if (x, y) == (column, row):
            return np.array(way) - 0.5
        right = y + (dy - dx - 1) // 2, x + (dx + dy - 1) // 2
        left = y + (dy + dx - 1) // 2, x + (dx - dy - 1) // 2
        if right in inside:
            dx, dy = dy, -dx
        elif left not in inside:
            dx, dy = -dy, dx

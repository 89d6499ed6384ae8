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
    made = [contact_of(grid, pressure, cells, stated, beside) for cells in found]
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
    stretch = np.sqrt(variance[1] / variance[0]) ** 0.5
    radius = float(np.sqrt(area / np.pi))
    return Contact(
        position=position,
        force=forces.sum(axis=0),
        moment=np.zeros(3),
        normal=surface.frame_from_plane(centre[None])[0, :, 2],
        area=area,
        peak_pressure=float(pressure[cells].max()),
        covariance=covariance_of_sums(error, cells, moves) + known,
        area_std=np.nan,
        radius=radius,
        shape="other",
        outline=np.zeros((0, 3)),
        axes=np.array([radius * stretch, radius / stretch]),
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

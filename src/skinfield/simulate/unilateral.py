"""Frictionless contact of rigid bodies with the skin: pressure that pushes, gaps that stay open."""

import numpy as np
from numpy.typing import NDArray

from skinfield.errors import Floats, SkinfieldError
from skinfield.mechanics import LatticeConvolution


def solve_contact(
    indent: LatticeConvolution,
    heights: Floats,
    bodies: NDArray[np.int64],
    pressure: Floats,
    forces: Floats,
    tolerance: float = 1e-9,
    most_iterations: int = 2000,
) -> tuple[Floats, Floats]:
    """Pressure under rigid bodies that are each pushed with a given force.

    Conjugate gradients with the contact as an active set (Polonsky and Keer 1999), the mean gap
    and the force of each body held apart.

    Parameters
    ----------
    indent : LatticeConvolution
        From pressure to indentation.
    heights : (rows, columns) array, m
        Of the body over each cell, above its lowest point; infinite under none.
    bodies : (rows, columns) int array
        Which body can touch a cell.
    pressure : (rows, columns) array, N per cell
        A start whose sums are `forces`.
    forces : (bodies,) array, N per cell's unit, as `pressure`
    tolerance : float
        On the work of the open gap and of the wrong overlap, relative to the whole.

    Returns
    -------
    pressure, approach : (rows, columns), (bodies,)
        The approach is the depth of each body's lowest point, m.

    Raises
    ------
    SkinfieldError
        If it does not converge.
    """
    reachable = np.isfinite(heights)
    level = np.where(reachable, heights, 0.0)
    count = len(forces)
    members = [reachable & (bodies == body) for body in range(count)]
    pressure = np.where(reachable, pressure, 0.0)
    direction, unit = np.zeros_like(pressure), np.zeros_like(pressure)
    unit[0, 0] = 1.0
    own = float(indent(unit)[0, 0])
    previous, conjugate = 1.0, 0.0
    for _ in range(most_iterations):
        gap = indent(pressure) + level
        touching = pressure > 0
        approach = np.array([gap[m & touching].mean() for m in members])
        gap = np.where(reachable, gap - approach[bodies], 0.0)
        error = _complementarity(pressure, gap, approach, forces)
        if error < tolerance:
            return pressure, approach
        work = float(np.sum(gap[touching] ** 2))
        direction = np.where(touching, gap + conjugate * work / previous * direction, 0.0)
        previous = work or 1.0
        curved = indent(direction)
        curved -= np.array([curved[m & touching].mean() for m in members])[bodies]
        curvature = float(np.sum(curved[touching] * direction[touching]))
        # Bodies that touch one cell each leave no direction; the cells they overlap still ask.
        step = float(np.sum(gap[touching] * direction[touching])) / curvature if work else 1 / own
        pressure = np.maximum(pressure - step * direction, 0.0)
        overlap = reachable & (pressure == 0.0) & (gap < 0.0)
        conjugate = 0.0 if overlap.any() else 1.0
        pressure[overlap] -= step * gap[overlap]
        sums = np.array([pressure[m].sum() for m in members])
        pressure *= np.where(reachable, (forces / sums)[bodies], 0.0)
    raise SkinfieldError(
        f"contact reached a relative error of {error:.1e} in {most_iterations} iterations, "
        f"expected {tolerance:.1e}: use finer cells or a lower load"
    )


def _complementarity(pressure: Floats, gap: Floats, approach: Floats, forces: Floats) -> float:
    """Work of the pressure through the remaining gap, relative; overlap counts at mean pressure."""
    touching = pressure > 0
    whole = float(np.abs(forces) @ np.abs(approach)) + 1e-300
    wrong = float(pressure[touching] @ np.abs(gap[touching]))
    through = float(np.maximum(-gap[~touching], 0.0).sum()) * float(pressure[touching].mean())
    return (wrong + through) / whole

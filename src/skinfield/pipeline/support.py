"""Where pressure may be: a window's lattice, continued under all taxels."""

import numpy as np

from skinfield.errors import InputError, Ints
from skinfield.layout import Grid
from skinfield.mechanics import Layer

SIGHT = 5.0  # thicknesses beyond a pad's rim at which a press is no longer seen


def support_of(grid: Grid, layer: Layer) -> tuple[Grid, Ints]:
    """Lattice that carries pressure under every taxel, and the grid's nodes in it.

    A window that leaves taxels out would have to explain their readings by pressure inside it.
    The answer is wanted in the window, but pressure is sought wherever a taxel sees.

    Returns
    -------
    support : Grid
        The grid itself where its cells hold all taxels.
    nodes : (K,) int array
        Where the grid's nodes stand in the support.

    Raises
    ------
    InputError
        If no taxel sees any of the grid's nodes.
    """
    _check_sight(grid, layer)
    taxels = grid.patch.plane
    last = grid.plane[-1]
    margin = grid.pitch * (0.5 + 1e-9)  # a cell holds what lies within half a pitch of its node
    before = np.ceil(np.maximum(grid.origin - margin - taxels.min(axis=0), 0.0) / grid.pitch)
    after = np.ceil(np.maximum(taxels.max(axis=0) - margin - last, 0.0) / grid.pitch)
    left, low = before.astype(int).tolist()
    right, high = after.astype(int).tolist()
    if not any((left, low, right, high)):
        return grid, np.arange(len(grid))
    rows, columns = grid.shape
    shape = (low + rows + high, left + columns + right)
    origin = grid.origin - np.array([left, low]) * grid.pitch
    row, column = np.divmod(np.arange(len(grid)), columns)
    return Grid(grid.patch, shape, grid.pitch, origin), (row + low) * shape[1] + column + left


def _check_sight(grid: Grid, layer: Layer) -> None:
    from scipy.spatial import cKDTree

    patch = grid.patch
    nearest = float(np.min(cKDTree(patch.plane).query(grid.plane)[0]))
    sight = patch.pad_diameter / 2 + SIGHT * layer.thickness + grid.pitch
    if nearest > sight:
        raise InputError(
            f"the grid's nearest node is {nearest * 1e3:.1f} mm from any taxel of {patch.name!r}, "
            f"expected within {sight * 1e3:.1f} mm: nothing is measured there; move the window"
        )
